//! `patterndb._native.features`.

mod fishbone;
mod ribs;
mod splines;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    fishbone::add(&add_module(module, "fishbone")?)?;
    ribs::add(&add_module(module, "ribs")?)?;
    splines::add(&add_module(module, "splines")?)?;
    Ok(())
}
