//! `patterndb._native.query.holes.rings`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use patterndb_query::holes::rings::{self, Paving};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::from_rows;

type PavingArrays<'py> = (
    Bound<'py, PyArray2<i32>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
    usize,
);

#[pyfunction]
fn pave<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray1<'py, i32>,
    rings: usize,
) -> PyResult<PavingArrays<'py>> {
    let corners = read(&corners)?;
    let paving = run(py, || rings::pave(corners, rings))?;
    let paving = paving.unwrap_or_else(|| Paving {
        quads: Vec::new(),
        inner: Vec::new(),
        counts: Vec::new(),
        n_vertices: 0,
    });
    Ok((
        from_rows(py, paving.quads)?,
        paving.inner.into_pyarray(py),
        paving.counts.into_pyarray(py),
        paving.n_vertices,
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(pave, module)?)
}
