//! `patterndb._native.retopo.ground.orientation`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_retopo::ground::orientation;
use pyo3::prelude::*;

use crate::arrays::{read, run};

type PartArrays<'py> = (Bound<'py, PyArray1<i32>>, Bound<'py, PyArray1<bool>>);

#[pyfunction]
fn walk_parts<'py>(
    py: Python<'py>,
    across: PyReadonlyArray1<'py, i32>,
    corner: PyReadonlyArray1<'py, i32>,
) -> PyResult<PartArrays<'py>> {
    let (across, corner) = (read(&across)?, read(&corner)?);
    let (part, over) = run(py, || orientation::walk_parts(across, corner))?;
    Ok((part.into_pyarray(py), over.into_pyarray(py)))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(walk_parts, module)?)
}
