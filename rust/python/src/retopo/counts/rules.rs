//! `patterndb._native.retopo.counts.rules`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_retopo::counts::rules;
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn find_irregular<'py>(
    py: Python<'py>,
    first_side: PyReadonlyArray1<'py, i32>,
    lengths: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let (first_side, lengths) = (read(&first_side)?, read(&lengths)?);
    let found = run(py, || rules::find_irregular(first_side, lengths))?;
    Ok(found.into_pyarray(py))
}

#[pyfunction]
fn is_cheap(
    py: Python<'_>,
    lengths: PyReadonlyArray1<'_, i32>,
    low: usize,
    high: usize,
) -> PyResult<bool> {
    let lengths = read(&lengths)?;
    run(py, || rules::is_cheap(&lengths[low..high]))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(find_irregular, module)?)?;
    module.add_function(wrap_pyfunction!(is_cheap, module)?)
}
