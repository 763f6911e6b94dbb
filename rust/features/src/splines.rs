//! Splines through points of a surface.

pub mod fit;
pub mod knots;
