//! Retopology by sketches: paths on surfaces, networks of curves, counts, drafts.
//!
//! Every function takes slices and returns owned data; nothing here reads files, starts threads or
//! looks at a clock. Modules have the names of the Python modules that call them.

pub mod counts;
pub mod draft;
pub mod filling;
pub mod network;
pub mod quadgrids;
pub mod tools;
pub mod tracing;
