//! The surface that is drawn upon: paths, neighbours, cuts.

pub mod heap;
