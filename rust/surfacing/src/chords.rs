//! Chords that split cycles into nearly flat pieces.
//!
//! Source: Abbasinejad et al. 2013, section 3.

pub mod candidates;
pub mod decompose;
pub mod flatness;
pub mod search;
pub mod subcycles;
