//! `patterndb._native.retopo.counts.tjoin`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use patterndb_retopo::counts::tjoin;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::read_all;

#[pyfunction]
#[pyo3(name = "match")]
fn match_vertices<'py>(
    py: Python<'py>,
    weights: PyReadonlyArray2<'py, i64>,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let n = weights.shape()[0];
    let weights = read_all(&weights)?;
    let mate = run(py, || tjoin::match_vertices(weights, n))?;
    Ok(mate.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(match_vertices, module)?)
}
