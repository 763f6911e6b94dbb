//! `patterndb._native.surfacing.chords`.

mod candidates;
mod decompose;
mod flatness;
mod search;
mod subcycles;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    candidates::add(&add_module(module, "candidates")?)?;
    decompose::add(&add_module(module, "decompose")?)?;
    flatness::add(&add_module(module, "flatness")?)?;
    search::add(&add_module(module, "search")?)?;
    subcycles::add(&add_module(module, "subcycles")?)?;
    Ok(())
}
