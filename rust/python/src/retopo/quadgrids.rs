//! `patterndb._native.retopo.quadgrids`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadwriteArray1};
use patterndb_retopo::quadgrids::{self, Quads, Separatrices};
use pyo3::prelude::*;

use crate::arrays::{read, run, write};
use crate::rows::from_table;

#[pyfunction]
fn run_all<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    tail: PyReadonlyArray1<'py, i32>,
    irregular: PyReadonlyArray1<'py, bool>,
    border: PyReadonlyArray1<'py, bool>,
    mut marked: PyReadwriteArray1<'py, bool>,
) -> PyResult<()> {
    let mesh = borrow(&twin, &tail)?;
    let (irregular, border) = (read(&irregular)?, read(&border)?);
    let marked = write(&mut marked)?;
    run(py, || {
        Separatrices::new(mesh, irregular, border, marked).run_all()
    })
}

#[pyfunction]
fn cut_regular<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    tail: PyReadonlyArray1<'py, i32>,
    irregular: PyReadonlyArray1<'py, bool>,
    border: PyReadonlyArray1<'py, bool>,
    mut marked: PyReadwriteArray1<'py, bool>,
) -> PyResult<()> {
    let mesh = borrow(&twin, &tail)?;
    let (irregular, border) = (read(&irregular)?, read(&border)?);
    let marked = write(&mut marked)?;
    run(py, || {
        Separatrices::new(mesh, irregular, border, marked).cut_regular()
    })
}

/// The half-edges of all curves, where each curve begins, and the half-curve of each half-edge.
type CurveArrays<'py> = (
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
);

#[pyfunction]
fn follow_marked<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    tail: PyReadonlyArray1<'py, i32>,
    marked: PyReadonlyArray1<'py, bool>,
    corner: PyReadonlyArray1<'py, bool>,
) -> PyResult<CurveArrays<'py>> {
    let mesh = borrow(&twin, &tail)?;
    let (marked, corner) = (read(&marked)?, read(&corner)?);
    let found = run(py, || quadgrids::follow_marked(mesh, marked, corner))?;
    Ok((
        found.edges.into_pyarray(py),
        found.start.into_pyarray(py),
        found.half.into_pyarray(py),
    ))
}

#[pyfunction]
fn read_grid<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    tail: PyReadonlyArray1<'py, i32>,
    h: i32,
    w: usize,
    n: usize,
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    let mesh = borrow(&twin, &tail)?;
    let found = run(py, || quadgrids::read_grid(mesh, h, w, n))?;
    from_table(py, n + 1, w + 1, found)
}

fn borrow<'a>(
    twin: &'a PyReadonlyArray1<'_, i32>,
    tail: &'a PyReadonlyArray1<'_, i32>,
) -> PyResult<Quads<'a>> {
    Ok(Quads {
        twin: read(twin)?,
        tail: read(tail)?,
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(run_all, module)?)?;
    module.add_function(wrap_pyfunction!(cut_regular, module)?)?;
    module.add_function(wrap_pyfunction!(follow_marked, module)?)?;
    module.add_function(wrap_pyfunction!(read_grid, module)?)
}
