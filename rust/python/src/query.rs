//! `patterndb._native.query`.

mod expand;
mod holes;
mod identity;
mod solving;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    expand::add(&add_module(module, "expand")?)?;
    holes::add(&add_module(module, "holes")?)?;
    identity::add(&add_module(module, "identity")?)?;
    solving::add(&add_module(module, "solving")?)
}
