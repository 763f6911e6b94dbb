//! `patterndb._native.surfacing.tessellation.piece`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_surfacing::tessellation::piece::{self, Mesh};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::read_rows;

#[pyfunction]
fn solve_heights<'py>(
    py: Python<'py>,
    at: PyReadonlyArray2<'py, i64>,
    tail: PyReadonlyArray1<'py, i64>,
    twin: PyReadonlyArray1<'py, i64>,
    boundary: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let mesh = Mesh {
        at: read_rows(&at)?,
        tail: read(&tail)?,
        twin: read(&twin)?,
    };
    let boundary = read(&boundary)?;
    let heights = run(py, || piece::solve_heights(mesh, boundary))?;
    Ok(heights.into_pyarray(py))
}

#[pyfunction]
fn measure_stretch<'py>(
    py: Python<'py>,
    at: PyReadonlyArray2<'py, i64>,
    tail: PyReadonlyArray1<'py, i64>,
    heights: PyReadonlyArray1<'py, f64>,
    step: f64,
) -> PyResult<f64> {
    let (at, tail, heights) = (read_rows(&at)?, read(&tail)?, read(&heights)?);
    run(py, || piece::measure_stretch(at, tail, heights, step))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(solve_heights, module)?)?;
    module.add_function(wrap_pyfunction!(measure_stretch, module)?)
}
