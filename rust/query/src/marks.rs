//! Marked patterns: where the corners of a boundary fall on them.

pub mod bestmarked;
pub mod markplaces;
pub mod patterntable;
