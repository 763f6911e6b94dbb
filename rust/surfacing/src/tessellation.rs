//! Triangles and quads of patches.

pub mod intersections;
pub mod piece;
pub mod planar;
