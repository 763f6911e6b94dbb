//! Counts of edges.

pub mod cycles;
pub mod matching;
pub mod parity;
pub mod regularity;
