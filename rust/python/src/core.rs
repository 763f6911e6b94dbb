//! `patterndb._native.core`.

mod code;
mod description;
mod halfedge;
mod polychord;
mod quadmesh;
pub mod reduction;
mod shortcode;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    code::add(&add_module(module, "code")?)?;
    description::add(&add_module(module, "description")?)?;
    halfedge::add(&add_module(module, "halfedge")?)?;
    polychord::add(&add_module(module, "polychord")?)?;
    quadmesh::add(&add_module(module, "quadmesh")?)?;
    reduction::add(&add_module(module, "reduction")?)?;
    shortcode::add(&add_module(module, "shortcode")?)
}
