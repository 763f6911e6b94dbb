//! Quad disks: half-edges, canonical codes, reduction to patterns.
//!
//! Every function takes slices and returns owned data; nothing here reads files, starts threads or
//! looks at a clock. Modules have the names of the Python modules that call them.

pub mod code;
pub mod ddqkey;
pub mod description;
pub mod halfedge;
pub mod label;
pub mod polychord;
pub mod quadmesh;
pub mod reduction;
pub mod shortcode;
