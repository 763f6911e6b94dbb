//! `patterndb._native.query.holes.assignments`.

use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_query::holes::assignments;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_all, read_rows};

#[pyfunction]
fn measure<'py>(
    py: Python<'py>,
    logs: PyReadonlyArray2<'py, f64>,
    regular_valence: PyReadonlyArray1<'py, i32>,
    assignments: PyReadonlyArray2<'py, i32>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (logs, regular_valence) = (read_rows(&logs)?, read(&regular_valence)?);
    let quads = read_all(&assignments)?;
    let rows = run(py, || assignments::measure(logs, regular_valence, quads))?;
    from_rows(py, rows)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(measure, module)?)
}
