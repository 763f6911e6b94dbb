//! `patterndb._native.geometry.neighbours`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use patterndb_geometry::neighbours;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::read_rows;

type Numbers<'py> = Bound<'py, PyArray1<i32>>;

#[pyfunction]
fn join<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray2<'py, i32>,
    n_vertices: usize,
    perimeter: usize,
) -> PyResult<(Numbers<'py>, Numbers<'py>, Numbers<'py>, Numbers<'py>)> {
    let quads = read_rows(&quads)?;
    let made = run(py, || neighbours::join(quads, n_vertices, perimeter))?;
    Ok((
        made.twin.into_pyarray(py),
        made.start.into_pyarray(py),
        made.neighbour.into_pyarray(py),
        made.border.into_pyarray(py),
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(join, module)?)
}
