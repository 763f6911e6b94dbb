//! `patterndb._native.features.ribs.raster`.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2,
    PyUntypedArrayMethods,
};
use patterndb_features::ribs::raster::{self, Picture};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, from_table, read_all, read_rows, write_all};

fn read_picture(array: &PyReadonlyArray2<'_, u64>) -> PyResult<Picture> {
    Ok(Picture {
        n_rows: array.shape()[0],
        n_columns: array.shape()[1],
        cells: read_all(array)?.to_vec(),
    })
}

fn make_picture(py: Python<'_>, picture: Picture) -> PyResult<Bound<'_, PyArray2<u64>>> {
    from_table(py, picture.n_rows, picture.n_columns, picture.cells)
}

#[pyfunction]
fn read_ring(py: Python<'_>, picture: PyReadonlyArray2<'_, u64>, x: i32, y: i32) -> PyResult<u8> {
    let picture = read_picture(&picture)?;
    run(py, || picture.read_ring([x, y]))
}

#[pyfunction]
fn dilate<'py>(
    py: Python<'py>,
    picture: PyReadonlyArray2<'py, u64>,
) -> PyResult<Bound<'py, PyArray2<u64>>> {
    let picture = read_picture(&picture)?;
    make_picture(py, run(py, || picture.dilate())?)
}

#[pyfunction]
fn erode<'py>(
    py: Python<'py>,
    mut picture: PyReadwriteArray2<'py, u64>,
    first: PyReadonlyArray2<'py, u64>,
) -> PyResult<()> {
    let first = read_picture(&first)?;
    let (n_rows, n_columns) = (picture.shape()[0], picture.shape()[1]);
    let cells = write_all(&mut picture)?;
    run(py, || {
        let mut eroded = Picture {
            n_rows,
            n_columns,
            cells: cells.to_vec(),
        };
        eroded.erode(&first);
        cells.copy_from_slice(&eroded.cells);
    })
}

type RenderedArrays<'py> = (
    Bound<'py, PyArray2<u64>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
);

#[pyfunction]
fn render_edges<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    first: PyReadonlyArray1<'py, i32>,
    rows: usize,
    columns: usize,
) -> PyResult<RenderedArrays<'py>> {
    let (points, first) = (read_rows(&points)?, read(&first)?);
    let (picture, cells) = run(py, || {
        let first = first.iter().map(|&k| k as usize);
        raster::render_edges(points, first, rows, columns)
    })?;
    Ok((
        make_picture(py, picture)?,
        cells.head.into_pyarray(py),
        cells.edge.into_pyarray(py),
        cells.link.into_pyarray(py),
    ))
}

#[pyfunction]
fn close_gaps<'py>(
    py: Python<'py>,
    picture: PyReadonlyArray2<'py, u64>,
    rounds: usize,
) -> PyResult<Bound<'py, PyArray2<u64>>> {
    let picture = read_picture(&picture)?;
    make_picture(py, run(py, || picture.close_gaps(rounds))?)
}

#[pyfunction]
fn find_outer_contour<'py>(
    py: Python<'py>,
    picture: PyReadonlyArray2<'py, u64>,
    x: f64,
    y: f64,
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    let picture = read_picture(&picture)?;
    from_rows(py, run(py, || picture.find_outer_contour([x, y]))?)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(read_ring, module)?)?;
    module.add_function(wrap_pyfunction!(dilate, module)?)?;
    module.add_function(wrap_pyfunction!(erode, module)?)?;
    module.add_function(wrap_pyfunction!(render_edges, module)?)?;
    module.add_function(wrap_pyfunction!(close_gaps, module)?)?;
    module.add_function(wrap_pyfunction!(find_outer_contour, module)?)
}
