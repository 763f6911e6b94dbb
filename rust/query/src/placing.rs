//! Fills placed in space and on surfaces.

pub mod flow;
pub mod laplace;
pub mod region;
pub mod strands;
pub mod untangle;
