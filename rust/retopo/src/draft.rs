//! Drafts of quads over a surface.

pub mod crossfield;
pub mod remesh;
pub mod tracing;
