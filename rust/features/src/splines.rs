//! Splines through points of a surface.
