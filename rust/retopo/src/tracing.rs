//! Curves on a surface: shortest paths, cuts by planes, and the map around a stroke.

pub mod geodesic;
pub mod heap;
pub mod localmap;
pub mod planarcut;
pub mod shortening;
