//! `patterndb._native.geometry.triangulation`.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2,
};
use patterndb_geometry::triangulation::{self, Faces};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows, write_rows};

#[pyfunction]
fn cut<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    corners: PyReadonlyArray1<'py, i32>,
    offsets: PyReadonlyArray1<'py, i64>,
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    let points = read_rows(&points)?;
    let (corners, offsets) = (read(&corners)?, read(&offsets)?);
    let triangles = run(py, || {
        triangulation::cut(points, Faces { corners, offsets })
    })?;
    from_rows(py, triangles)
}

#[pyfunction]
fn cut_chosen<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    corners: PyReadonlyArray1<'py, i32>,
    offsets: PyReadonlyArray1<'py, i64>,
    rows: PyReadonlyArray1<'py, i64>,
    chosen: PyReadonlyArray1<'py, i64>,
    mut triangles: PyReadwriteArray2<'py, i32>,
) -> PyResult<()> {
    let points = read_rows(&points)?;
    let (corners, offsets) = (read(&corners)?, read(&offsets)?);
    let (rows, chosen) = (read(&rows)?, read(&chosen)?);
    let triangles = write_rows(&mut triangles)?;
    run(py, || {
        triangulation::cut_chosen(points, Faces { corners, offsets }, rows, chosen, triangles);
    })
}

#[pyfunction]
fn write_once<'py>(
    py: Python<'py>,
    face: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let face = read(&face)?;
    let once = run(py, || triangulation::write_once(face))?;
    Ok(once.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(cut, module)?)?;
    module.add_function(wrap_pyfunction!(cut_chosen, module)?)?;
    module.add_function(wrap_pyfunction!(write_once, module)?)
}
