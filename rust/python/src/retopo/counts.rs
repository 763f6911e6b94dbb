//! `patterndb._native.retopo.counts`.

mod evening;
mod rules;
mod tjoin;
mod walks;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    evening::add(&add_module(module, "evening")?)?;
    rules::add(&add_module(module, "rules")?)?;
    tjoin::add(&add_module(module, "tjoin")?)?;
    walks::add(&add_module(module, "walks")?)
}
