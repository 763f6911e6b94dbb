//! Which patterns fit a boundary, and how wide their polychords become: an integer program.
//!
//! [`widths`] and [`feasibility`] are what callers use. [`systems`] states the linear systems;
//! [`sieve`], [`hall_conditions`] and [`fractional_matching`] reject them, cheapest first,
//! [`matching`] decides them, and [`branch_and_bound`] finds the best solutions, most in
//! [`balance`] first. [`strokes`] makes systems of the ways in which strands follow strokes.

pub mod balance;
pub mod branch_and_bound;
pub mod feasibility;
pub mod fractional_matching;
pub mod hall_conditions;
pub mod matching;
pub mod sieve;
pub mod strokes;
pub mod systems;
pub mod widths;
