//! `patterndb._native.surfacing.curvenetwork`.

mod meetings;
mod survey;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    meetings::add(&add_module(module, "meetings")?)?;
    survey::add(&add_module(module, "survey")?)
}
