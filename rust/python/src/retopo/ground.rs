//! `patterndb._native.retopo.ground`.

mod geodesic;
mod localmap;
mod orientation;
mod planarcut;
mod shortening;
mod topology;

use numpy::{Element, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::add_module;
use crate::rows::read_rows;

/// Return the N items of an array to read; ValueError where it is not contiguous, or not N long.
pub fn read_items<'a, T: Element, const N: usize>(
    array: &'a PyReadonlyArray1<'_, T>,
) -> PyResult<&'a [T; N]> {
    Ok(&read_rows(array)?[0])
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    geodesic::add(&add_module(module, "geodesic")?)?;
    localmap::add(&add_module(module, "localmap")?)?;
    orientation::add(&add_module(module, "orientation")?)?;
    planarcut::add(&add_module(module, "planarcut")?)?;
    shortening::add(&add_module(module, "shortening")?)?;
    topology::add(&add_module(module, "topology")?)
}
