//! `patterndb._native.query.solving`.

mod feasibility;
mod systems;
mod widths;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    feasibility::add(&add_module(module, "feasibility")?)?;
    systems::add(&add_module(module, "systems")?)?;
    widths::add(&add_module(module, "widths")?)
}
