//! Complete families of patterns.

pub mod growing;
