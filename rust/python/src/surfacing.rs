//! `patterndb._native.surfacing`.

mod chords;
mod curvenetwork;
mod cycles;
mod tessellation;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    chords::add(&add_module(module, "chords")?)?;
    cycles::add(&add_module(module, "cycles")?)?;
    curvenetwork::add(&add_module(module, "curvenetwork")?)?;
    tessellation::add(&add_module(module, "tessellation")?)?;
    Ok(())
}
