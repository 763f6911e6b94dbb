//! `patterndb._native.query.families`.

mod growing;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    growing::add(&add_module(module, "growing")?)
}
