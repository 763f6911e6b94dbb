//! `patterndb._native.ingest.prepare`.

use numpy::{IntoPyArray, PyArray1, PyReadwriteArray1};
use patterndb_ingest::prepare;
use pyo3::prelude::*;

use crate::arrays::{run, write};

#[pyfunction]
fn collapse_all<'py>(
    py: Python<'py>,
    mut vertex: PyReadwriteArray1<'py, i32>,
    mut twin: PyReadwriteArray1<'py, i32>,
    n_vertices: usize,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let (vertex, twin) = (write(&mut vertex)?, write(&mut twin)?);
    let alive = run(py, || prepare::collapse_all(vertex, twin, n_vertices))?;
    Ok(alive.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(collapse_all, module)?)
}
