//! `patterndb._native.query.marks.patterntable`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_query::marks::patterntable;
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn meshes<'py>(
    py: Python<'py>,
    flat: PyReadonlyArray1<'py, u16>,
    offsets: PyReadonlyArray1<'py, i64>,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let (flat, offsets) = (read(&flat)?, read(&offsets)?);
    let meshes = run(py, || patterntable::meshes(flat, offsets))?;
    Ok(meshes.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(meshes, module)?)
}
