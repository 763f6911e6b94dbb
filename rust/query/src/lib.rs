//! Fills of boundaries and holes: which patterns fit, how wide their polychords become, expansion.
//!
//! Every function takes slices and returns owned data; nothing here reads files, starts threads or
//! looks at a clock. Modules have the names of the Python modules that call them.

pub mod construct;
pub mod expand;
pub mod holes;
pub mod placing;
pub mod recognition;
pub mod relaxed;
pub mod solving;
