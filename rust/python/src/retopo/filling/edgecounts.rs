//! `patterndb._native.retopo.filling.edgecounts`.

use numpy::PyReadonlyArray2;
use patterndb_retopo::filling::edgecounts;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::read_rows;

#[pyfunction]
fn count_bend_edges(
    py: Python<'_>,
    line: PyReadonlyArray2<'_, f64>,
    closed: bool,
    steps: usize,
    edge: f64,
) -> PyResult<f64> {
    let line = read_rows(&line)?;
    run(py, || {
        edgecounts::count_bend_edges(line, closed, steps, edge)
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(count_bend_edges, module)?)
}
