//! `patterndb._native.surfacing`.

mod chords;
mod cycles;
mod joining;
mod tessellation;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    chords::add(&add_module(module, "chords")?)?;
    cycles::add(&add_module(module, "cycles")?)?;
    joining::add(&add_module(module, "joining")?)?;
    tessellation::add(&add_module(module, "tessellation")?)?;
    Ok(())
}
