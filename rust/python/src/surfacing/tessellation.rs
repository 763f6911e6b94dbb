//! `patterndb._native.surfacing.tessellation`.

mod intersections;
mod piece;
mod planar;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    intersections::add(&add_module(module, "intersections")?)?;
    piece::add(&add_module(module, "piece")?)?;
    planar::add(&add_module(module, "planar")?)
}
