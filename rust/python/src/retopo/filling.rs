//! `patterndb._native.retopo.filling`.

mod edgecounts;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    edgecounts::add(&add_module(module, "edgecounts")?)
}
