//! Which patterns fit a boundary, and how wide their polychords become.
//!
//! Every function takes slices and returns owned data; nothing here reads files, starts threads or
//! looks at a clock. Modules have the names of the Python modules that call them, those of
//! `query.solving`.

pub mod batch;
pub mod evenness;
pub mod feasibility;
pub mod graphs;
pub mod halves;
pub mod jointclaims;
pub mod matching;
pub mod sieve;
pub mod strokes;
pub mod systems;
