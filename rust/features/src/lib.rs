//! Feature curves on triangle surfaces: ribs, the fishbone, splines.
//!
//! Every function takes slices and returns owned data; nothing here reads files, starts threads or
//! looks at a clock. Modules have the names of the Python modules that call them.

pub mod fishbone;
pub mod ribs;
pub mod splines;
