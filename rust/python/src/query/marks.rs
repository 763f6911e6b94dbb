//! `patterndb._native.query.marks`.

mod bestmarked;
mod markplaces;
mod patterntable;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    bestmarked::add(&add_module(module, "bestmarked")?)?;
    markplaces::add(&add_module(module, "markplaces")?)?;
    patterntable::add(&add_module(module, "patterntable")?)
}
