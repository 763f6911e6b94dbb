//! `patterndb._native.geometry.quadshape`.

use numpy::PyReadonlyArray2;
use patterndb_geometry::quadshape;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::read_rows;

#[pyfunction]
fn squareness<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray2<'py, i32>,
    vertices: PyReadonlyArray2<'py, f64>,
) -> PyResult<f64> {
    let (quads, vertices) = (read_rows(&quads)?, read_rows(&vertices)?);
    run(py, || quadshape::squareness(quads, vertices))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(squareness, module)?)
}
