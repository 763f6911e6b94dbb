//! Which patterns fit a boundary, and how wide their polychords become.

pub mod batch;
pub mod evenness;
pub mod feasibility;
pub mod graphs;
pub mod halves;
pub mod jointclaims;
pub mod matching;
pub mod sieve;
pub mod strokes;
pub mod systems;
