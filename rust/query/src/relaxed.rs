//! Relaxed matching: patterns of which the corners of a boundary may fall anywhere.

pub mod bestmarked;
pub mod corner_placement;
pub mod family;
