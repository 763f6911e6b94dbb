//! `patterndb._native.store`.

mod ddqkey;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    ddqkey::add(&add_module(module, "ddqkey")?)
}
