//! Triangle surfaces and points on them; the shape of quads, and drawings of disks.
//!
//! Every function takes slices and returns owned data; nothing here reads files, starts threads or
//! looks at a clock. Modules have the names of the Python modules that call them.

pub mod adjacency;
pub mod barrier;
pub mod casting;
pub mod earclipping;
pub mod leastarea;
pub mod neighbours;
pub mod proximity;
pub mod quadshape;
pub mod relaxation;
pub mod sorting;
pub mod tree;
pub mod triangulation;
pub mod vector;

pub use vector::Point;
