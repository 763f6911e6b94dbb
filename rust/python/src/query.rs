//! `patterndb._native.query`.

mod solving;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    solving::add(&add_module(module, "solving")?)
}
