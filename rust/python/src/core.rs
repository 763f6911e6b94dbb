//! `patterndb._native.core`.

mod halfedge;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    halfedge::add(&add_module(module, "halfedge")?)
}
