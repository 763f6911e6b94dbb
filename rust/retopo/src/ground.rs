//! The surface that is drawn upon: paths, neighbours, cuts.

pub mod geodesic;
pub mod heap;
pub mod localmap;
pub mod orientation;
pub mod planarcut;
pub mod shortening;
pub mod topology;
