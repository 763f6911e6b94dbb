//! `patterndb._native.query.placing`.

mod flow;
mod laplace;
mod region;
mod strands;
mod untangle;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    flow::add(&add_module(module, "flow")?)?;
    laplace::add(&add_module(module, "laplace")?)?;
    region::add(&add_module(module, "region")?)?;
    strands::add(&add_module(module, "strands")?)?;
    untangle::add(&add_module(module, "untangle")?)
}
