//! `patterndb._native.retopo`.

mod counts;
mod draft;
mod filling;
mod ground;
mod network;
mod quadgrids;
mod tools;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    counts::add(&add_module(module, "counts")?)?;
    draft::add(&add_module(module, "draft")?)?;
    filling::add(&add_module(module, "filling")?)?;
    ground::add(&add_module(module, "ground")?)?;
    network::add(&add_module(module, "network")?)?;
    quadgrids::add(&add_module(module, "quadgrids")?)?;
    tools::add(&add_module(module, "tools")?)?;
    Ok(())
}
