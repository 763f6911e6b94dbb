//! `patterndb._native.retopo.network`.

mod attaching;
mod crossings;
mod flooding;
mod patches;
mod samples;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    attaching::add(&add_module(module, "attaching")?)?;
    crossings::add(&add_module(module, "crossings")?)?;
    flooding::add(&add_module(module, "flooding")?)?;
    patches::add(&add_module(module, "patches")?)?;
    samples::add(&add_module(module, "samples")?)
}
