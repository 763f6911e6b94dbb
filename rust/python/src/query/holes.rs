//! `patterndb._native.query.holes`.

mod assignments;
mod candidates;
mod loops;
mod patterns;
mod ranking;
mod regular;
mod rings;
mod shape;
mod surroundings;
mod trees;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    assignments::add(&add_module(module, "assignments")?)?;
    candidates::add(&add_module(module, "candidates")?)?;
    loops::add(&add_module(module, "loops")?)?;
    patterns::add(&add_module(module, "patterns")?)?;
    ranking::add(&add_module(module, "ranking")?)?;
    regular::add(&add_module(module, "regular")?)?;
    rings::add(&add_module(module, "rings")?)?;
    shape::add(&add_module(module, "shape")?)?;
    surroundings::add(&add_module(module, "surroundings")?)?;
    trees::add(&add_module(module, "trees")?)
}
