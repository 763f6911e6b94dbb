//! `patterndb._native.geometry`.

mod earclipping;
mod leastarea;
mod neighbours;
mod quadshape;
mod relaxation;
mod search;
mod triangulation;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    search::add(module)?;
    earclipping::add(&add_module(module, "earclipping")?)?;
    leastarea::add(&add_module(module, "leastarea")?)?;
    neighbours::add(&add_module(module, "neighbours")?)?;
    quadshape::add(&add_module(module, "quadshape")?)?;
    relaxation::add(&add_module(module, "relaxation")?)?;
    triangulation::add(&add_module(module, "triangulation")?)
}
