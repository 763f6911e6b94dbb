//! `patterndb._native.query.solving`.

mod batch;
mod feasibility;
mod jointclaims;
mod sieve;
mod systems;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    batch::add(&add_module(module, "batch")?)?;
    feasibility::add(&add_module(module, "feasibility")?)?;
    jointclaims::add(&add_module(module, "jointclaims")?)?;
    sieve::add(&add_module(module, "sieve")?)?;
    systems::add(&add_module(module, "systems")?)
}
