//! `patterndb._native.surfacing.chords.decompose`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use patterndb_surfacing::chords::decompose;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::read_rows;

#[pyfunction]
fn flatter<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    chords: PyReadonlyArray2<'py, i64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (points, chords) = (read_rows(&points)?, read_rows(&chords)?);
    let gains = run(py, || decompose::measure_gains(points, chords))?;
    Ok(gains.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(flatter, module)?)
}
