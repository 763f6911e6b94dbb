//! Networks of curves: crossings, patches, what is near.

pub mod attaching;
pub mod crossings;
pub mod flooding;
pub mod patches;
pub mod samples;
