//! `patterndb._native.query.expand`.

use numpy::{PyArray2, PyReadonlyArray1};
use patterndb_query::expand;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::from_rows;

#[pyfunction]
fn expand_quads<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    across: PyReadonlyArray1<'py, i32>,
    perimeter: i32,
    first: i32,
    mirrored: bool,
) -> PyResult<(Bound<'py, PyArray2<i32>>, i32)> {
    let (twin, across) = (read(&twin)?, read(&across)?);
    let (quads, n_vertices) = run(py, || {
        expand::expand_quads(twin, across, perimeter, first, mirrored)
    })?;
    Ok((from_rows(py, quads)?, n_vertices))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(expand_quads, module)?)
}
