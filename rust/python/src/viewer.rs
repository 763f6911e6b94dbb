//! `patterndb._native.viewer`.

mod raster;
mod skin;
mod solid;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    raster::add(&add_module(module, "raster")?)?;
    skin::add(&add_module(module, "skin")?)?;
    solid::add(&add_module(module, "solid")?)
}
