//! `patterndb._native.query.holes.regular`.

use numpy::{IntoPyArray, PyArray2, PyArray4, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_query::holes::regular::{self, Fill, TURNS};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

#[pyfunction]
fn fill_walk<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray1<'py, i32>,
) -> PyResult<(Bound<'py, PyArray2<i32>>, usize)> {
    let corners = read(&corners)?;
    let fill = run(py, || regular::fill_walk(corners))?;
    let Fill { quads, n_vertices } = fill.unwrap_or_else(|| Fill {
        quads: Vec::new(),
        n_vertices: 0,
    });
    Ok((from_rows(py, quads)?, n_vertices))
}

#[pyfunction]
fn tabulate_rest<'py>(
    py: Python<'py>,
    logs: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray4<f32>>> {
    let logs = read_rows(&logs)?;
    let rest = run(py, || regular::tabulate_rest(logs))?;
    let size = logs.len() + 1;
    let items = rest.into_flattened().into_pyarray(py);
    items.reshape([size, size, size, TURNS])
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(fill_walk, module)?)?;
    module.add_function(wrap_pyfunction!(tabulate_rest, module)?)
}
