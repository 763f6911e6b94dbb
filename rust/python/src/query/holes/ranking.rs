//! `patterndb._native.query.holes.ranking`.

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_query::holes::ranking::{self, Loop};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::read_rows;

#[pyfunction]
fn measure_quads<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray2<'py, i32>,
    n_vertices: usize,
    regular_valence: PyReadonlyArray1<'py, i32>,
    clamped_valence: PyReadonlyArray1<'py, i32>,
    ahead: PyReadonlyArray2<'py, f64>,
    logs: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let of_loop = Loop {
        regular_valence: read(&regular_valence)?,
        clamped_valence: read(&clamped_valence)?,
        ahead: read_rows(&ahead)?,
        logs: read(&logs)?,
    };
    let quads = read_rows(&quads)?;
    let found = run(py, || ranking::measure_quads(quads, n_vertices, &of_loop))?;
    Ok(PyArray1::from_slice(py, &found))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(measure_quads, module)?)
}
