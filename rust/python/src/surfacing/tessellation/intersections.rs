//! `patterndb._native.surfacing.tessellation.intersections`.

use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use patterndb_geometry::tree::Tree;
use patterndb_surfacing::tessellation::intersections;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_blocks, read_rows};

#[pyfunction]
fn crossings<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    triangles: PyReadonlyArray2<'py, i64>,
    owner: PyReadonlyArray1<'py, i64>,
    boxes: PyReadonlyArray3<'py, f64>,
    nodes: PyReadonlyArray2<'py, i32>,
    order: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let tree = Tree {
        corners: read_blocks(&corners)?,
        boxes: read_blocks(&boxes)?,
        nodes: read_rows(&nodes)?,
        order: read(&order)?,
    };
    let (vertices, owner) = (read_rows(&triangles)?, read(&owner)?);
    let found = run(py, || intersections::find_crossings(&tree, vertices, owner))?;
    from_rows(py, found)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(crossings, module)?)
}
