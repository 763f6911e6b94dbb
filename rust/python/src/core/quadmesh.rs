//! `patterndb._native.core.quadmesh`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2};
use patterndb_core::quadmesh;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{read_rows, write_rows};

#[pyfunction]
fn flip_to_agree<'py>(
    py: Python<'py>,
    mut quads: PyReadwriteArray2<'py, i32>,
    start: PyReadonlyArray1<'py, i64>,
    pairs: PyReadonlyArray2<'py, i64>,
) -> PyResult<()> {
    let quads = write_rows(&mut quads)?;
    let (start, pairs) = (read(&start)?, read_rows(&pairs)?);
    run(py, || quadmesh::flip_to_agree(quads, start, pairs))
}

#[pyfunction]
fn components<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let twin = read(&twin)?;
    let component = run(py, || quadmesh::components(twin))?;
    Ok(component.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(flip_to_agree, module)?)?;
    module.add_function(wrap_pyfunction!(components, module)?)
}
