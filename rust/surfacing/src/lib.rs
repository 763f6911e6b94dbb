//! Surfaces of networks of 3D curves: joints, cycles, chords, tessellation.
//!
//! Every function takes slices and returns owned data; nothing here reads files, starts threads or
//! looks at a clock. Modules have the names of the Python modules that call them.

mod axes;
pub mod chords;
pub mod curvenetwork;
pub mod cycles;
pub mod tessellation;
