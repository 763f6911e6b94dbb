//! `patterndb._native.surfacing.cycles`.

mod bounding;
mod closing;
mod measures;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    bounding::add(&add_module(module, "bounding")?)?;
    closing::add(&add_module(module, "closing")?)?;
    measures::add(&add_module(module, "measures")?)?;
    Ok(())
}
