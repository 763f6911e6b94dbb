//! Constructions: boundaries of many sides or long ones, cut into parts.

pub mod parts;
pub mod plan;
pub mod prolong;
