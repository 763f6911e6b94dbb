//! Constructions: boundaries of many sides or long ones, cut into parts.

pub mod pentagon_cuts;
pub mod plan;
pub mod reflex_cuts;
