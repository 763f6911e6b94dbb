//! `patterndb._native.core.polychord`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_core::polychord;
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn trace<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
) -> PyResult<(Bound<'py, PyArray1<i32>>, i32, i32)> {
    let twin = read(&twin)?;
    let found = run(py, || polychord::trace(twin))?;
    Ok((found.of_edge.into_pyarray(py), found.n_open, found.n))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(trace, module)?)
}
