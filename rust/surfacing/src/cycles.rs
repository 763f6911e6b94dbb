//! Cycles of curves that bound patches: candidates, what they look like, what choices are worth.

pub mod bounding;
pub mod closing;
pub mod measures;
