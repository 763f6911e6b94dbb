//! `patterndb._native.query`.

mod expand;
mod identity;
mod placing;
mod solving;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    expand::add(&add_module(module, "expand")?)?;
    identity::add(&add_module(module, "identity")?)?;
    placing::add(&add_module(module, "placing")?)?;
    solving::add(&add_module(module, "solving")?)
}
