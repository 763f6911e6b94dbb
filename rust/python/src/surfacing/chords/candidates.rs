//! `patterndb._native.surfacing.chords.candidates`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_surfacing::chords::candidates as chords;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

#[pyfunction]
fn order_canonically<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let points = read_rows(&points)?;
    let order = run(py, || {
        let order = chords::order_canonically(points);
        order.into_iter().map(|i| i as i64).collect::<Vec<i64>>()
    })?;
    Ok(order.into_pyarray(py))
}

#[pyfunction]
fn endpoints<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    corners: PyReadonlyArray1<'py, bool>,
    bound: f64,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let (points, corners) = (read_rows(&points)?, read(&corners)?);
    let ends = run(py, || chords::find_endpoints(points, corners, bound))?;
    Ok(ends.into_pyarray(py))
}

#[pyfunction]
fn candidates<'py>(
    py: Python<'py>,
    given_points: PyReadonlyArray2<'py, f64>,
    given_corners: PyReadonlyArray1<'py, bool>,
    ends: PyReadonlyArray1<'py, i64>,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let (points, corners) = (read_rows(&given_points)?, read(&given_corners)?);
    let ends = read(&ends)?;
    let found = run(py, || {
        let found = chords::find_candidates(points, corners, ends);
        found
            .into_iter()
            .map(|ends| ends.map(|v| v as i64))
            .collect()
    })?;
    from_rows(py, found)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(order_canonically, module)?)?;
    module.add_function(wrap_pyfunction!(endpoints, module)?)?;
    module.add_function(wrap_pyfunction!(candidates, module)?)
}
