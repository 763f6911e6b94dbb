//! Pictures: triangles drawn into arrays of pixels.
//!
//! Every function takes slices and returns owned data; nothing here reads files, starts threads or
//! looks at a clock. Modules have the names of the Python modules that call them.

pub mod raster;
pub mod skin;
pub mod solid;
