//! `patterndb._native.retopo.network.samples`.

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use patterndb_retopo::network::samples::{self, Samples};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::retopo::ground::read_items;
use crate::rows::read_rows;

#[pyfunction]
fn find_nearest<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    starts: PyReadonlyArray1<'py, i32>,
    loose: PyReadonlyArray1<'py, bool>,
    at: PyReadonlyArray1<'py, f64>,
    up: PyReadonlyArray1<'py, f64>,
) -> PyResult<(i64, f64, f64)> {
    let of = Samples {
        points: read_rows(&points)?,
        normals: read_rows(&normals)?,
        starts: read(&starts)?,
        loose: read(&loose)?,
    };
    let (at, up) = (read_items(&at)?, read_items(&up)?);
    let found = run(py, || samples::find_nearest(&of, at, up))?;
    Ok((found.sample, found.share, found.distance))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(find_nearest, module)?)
}
