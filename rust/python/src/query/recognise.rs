//! `patterndb._native.query.recognise`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_query::recognise;
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn lengths<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    head: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let (twin, head) = (read(&twin)?, read(&head)?);
    let lengths = run(py, || recognise::lengths(twin, head))?;
    Ok(lengths.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(lengths, module)?)
}
