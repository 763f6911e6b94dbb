//! `patterndb._native.query.holes.candidates`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use patterndb_query::holes::candidates;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::{from_rows, read_rows};

type TurnedArrays<'py> = (Bound<'py, PyArray2<i32>>, Bound<'py, PyArray1<i32>>);

#[pyfunction]
fn turn_quads<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray2<'py, i32>,
    first: i32,
    n: usize,
) -> PyResult<TurnedArrays<'py>> {
    let quads = read_rows(&quads)?;
    let (turned, counts) = run(py, || candidates::turn_quads(quads, first, n))?;
    Ok((from_rows(py, turned)?, counts.into_pyarray(py)))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(turn_quads, module)?)
}
