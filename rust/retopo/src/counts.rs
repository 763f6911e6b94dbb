//! Counts of edges.

pub mod evening;
pub mod rules;
pub mod tjoin;
pub mod walks;
