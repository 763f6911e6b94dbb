//! `patterndb._native.surfacing.chords.flatness`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_surfacing::chords::flatness;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

#[pyfunction]
fn standardised<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, f64)> {
    let points = read_rows(&points)?;
    let (own, determinant) = run(py, || flatness::standardise(points))?;
    Ok((from_rows(py, own)?, determinant))
}

#[pyfunction]
fn sum_moments<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let points = read_rows(&points)?;
    let moments = run(py, || flatness::sum_moments(points))?;
    Ok(moments.to_vec().into_pyarray(py))
}

#[pyfunction]
fn find_determinant(py: Python<'_>, moments: PyReadonlyArray1<'_, f64>) -> PyResult<f64> {
    let moments = read(&moments)?;
    let moments = moments
        .try_into()
        .map_err(|_| PyValueError::new_err("an array is not of 10 moments"))?;
    run(py, || flatness::find_determinant(moments))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(standardised, module)?)?;
    module.add_function(wrap_pyfunction!(sum_moments, module)?)?;
    module.add_function(wrap_pyfunction!(find_determinant, module)?)
}
