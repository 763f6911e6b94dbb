//! `patterndb._native.query.placing.laplace`.

use numpy::{
    PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, PyReadwriteArray2,
    PyUntypedArrayMethods,
};
use patterndb_query::placing::laplace::{self, Adjacency};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_blocks, read_rows, write_all};

#[pyfunction]
fn relax_inside<'py>(
    py: Python<'py>,
    start: PyReadonlyArray1<'py, i32>,
    neighbour: PyReadonlyArray1<'py, i32>,
    fixed: usize,
    mut values: PyReadwriteArray2<'py, f64>,
) -> PyResult<usize> {
    let graph = Adjacency {
        start: read(&start)?,
        neighbour: read(&neighbour)?,
        fixed,
    };
    let width = values.shape()[1];
    let values = write_all(&mut values)?;
    run(py, || laplace::relax_inside(&graph, width, values))
}

#[pyfunction]
fn relax_within<'py>(
    py: Python<'py>,
    start: PyReadonlyArray1<'py, i32>,
    neighbour: PyReadonlyArray1<'py, i32>,
    fixed: usize,
    points: PyReadonlyArray2<'py, f64>,
    frames: PyReadonlyArray3<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let graph = Adjacency {
        start: read(&start)?,
        neighbour: read(&neighbour)?,
        fixed,
    };
    let (points, frames) = (read_rows(&points)?, read_blocks(&frames)?);
    let moves = run(py, || laplace::relax_within(&graph, points, frames))?;
    from_rows(py, moves)
}

#[pyfunction]
fn measure_edge_energy<'py>(
    py: Python<'py>,
    start: PyReadonlyArray1<'py, i32>,
    neighbour: PyReadonlyArray1<'py, i32>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<f64> {
    let graph = Adjacency {
        start: read(&start)?,
        neighbour: read(&neighbour)?,
        fixed: 0,
    };
    let points = read_rows(&points)?;
    run(py, || laplace::measure_edge_energy(&graph, points))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(relax_inside, module)?)?;
    module.add_function(wrap_pyfunction!(relax_within, module)?)?;
    module.add_function(wrap_pyfunction!(measure_edge_energy, module)?)
}
