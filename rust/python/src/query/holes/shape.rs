//! `patterndb._native.query.holes.shape`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_query::holes::shape::{self, Around, Mesh};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

type Numbers<'py> = Bound<'py, PyArray1<i64>>;

#[pyfunction]
fn neighbours<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray1<'py, i64>,
    offsets: PyReadonlyArray1<'py, i64>,
    quads: PyReadonlyArray2<'py, i64>,
    n_points: usize,
) -> PyResult<(Numbers<'py>, Numbers<'py>)> {
    let mesh = Mesh {
        quads: read_rows(&quads)?,
        corners: read(&corners)?,
        offsets: read(&offsets)?,
    };
    let made = run(py, || shape::neighbours(&mesh, n_points))?;
    Ok((made.start.into_pyarray(py), made.beside.into_pyarray(py)))
}

type LaplacianArrays<'py> = (
    Numbers<'py>,
    Numbers<'py>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
);

#[pyfunction]
fn laplacian_rows<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    start: PyReadonlyArray1<'py, i64>,
    beside: PyReadonlyArray1<'py, i64>,
    n_outer: usize,
    n_loop: usize,
) -> PyResult<LaplacianArrays<'py>> {
    let points = read_rows(&points)?;
    let (start, beside) = (read(&start)?, read(&beside)?);
    let made = run(py, || {
        shape::laplacian_rows(points, start, beside, n_outer, n_loop)
    })?;
    Ok((
        made.row.into_pyarray(py),
        made.column.into_pyarray(py),
        made.weight.into_pyarray(py),
        from_rows(py, made.right)?,
    ))
}

#[pyfunction]
fn measure_fill<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    quads: PyReadonlyArray2<'py, i64>,
    corners: PyReadonlyArray1<'py, i64>,
    offsets: PyReadonlyArray1<'py, i64>,
    normals: PyReadonlyArray2<'py, f64>,
    beyond: PyReadonlyArray2<'py, f64>,
    n_loop: usize,
    n_outer: usize,
    scale: f64,
    area: f64,
) -> PyResult<(Bound<'py, PyArray1<f64>>, usize)> {
    let mesh = Mesh {
        quads: read_rows(&quads)?,
        corners: read(&corners)?,
        offsets: read(&offsets)?,
    };
    let around = Around {
        normals: read_rows(&normals)?,
        beyond: read_rows(&beyond)?,
        n_loop,
        n_outer,
        scale,
        area,
    };
    let points = read_rows(&points)?;
    let (measures, flipped) = run(py, || shape::measure_fill(points, mesh, around))?;
    Ok((PyArray1::from_slice(py, &measures), flipped))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(neighbours, module)?)?;
    module.add_function(wrap_pyfunction!(laplacian_rows, module)?)?;
    module.add_function(wrap_pyfunction!(measure_fill, module)?)
}
