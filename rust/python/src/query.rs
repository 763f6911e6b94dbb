//! `patterndb._native.query`.

mod construct;
mod expand;
mod families;
mod holes;
mod identity;
mod marks;
mod placing;
mod recognise;
mod solving;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    construct::add(&add_module(module, "construct")?)?;
    expand::add(&add_module(module, "expand")?)?;
    families::add(&add_module(module, "families")?)?;
    holes::add(&add_module(module, "holes")?)?;
    identity::add(&add_module(module, "identity")?)?;
    marks::add(&add_module(module, "marks")?)?;
    recognise::add(&add_module(module, "recognise")?)?;
    placing::add(&add_module(module, "placing")?)?;
    solving::add(&add_module(module, "solving")?)
}
