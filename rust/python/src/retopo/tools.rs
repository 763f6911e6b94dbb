//! `patterndb._native.retopo.tools`.

mod salience;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    salience::add(&add_module(module, "salience")?)
}
