//! `patterndb._native.query.construct`.

mod parts;
mod plan;
mod prolong;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    parts::add(&add_module(module, "parts")?)?;
    plan::add(&add_module(module, "plan")?)?;
    prolong::add(&add_module(module, "prolong")?)
}
