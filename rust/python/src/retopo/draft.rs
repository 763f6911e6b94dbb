//! `patterndb._native.retopo.draft`.

mod crossfield;
mod remesh;
mod tracing;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    crossfield::add(&add_module(module, "crossfield")?)?;
    remesh::add(&add_module(module, "remesh")?)?;
    tracing::add(&add_module(module, "tracing")?)
}
