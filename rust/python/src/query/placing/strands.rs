//! `patterndb._native.query.placing.strands`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_query::placing::strands;
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn walk<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    first: i32,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let twin = read(&twin)?;
    let chain = run(py, || strands::walk(twin, first))?;
    Ok(chain.into_pyarray(py))
}

#[pyfunction]
fn find_far_ends<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    border: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let (twin, border) = (read(&twin)?, read(&border)?);
    let far = run(py, || strands::find_far_ends(twin, border))?;
    Ok(far.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(walk, module)?)?;
    module.add_function(wrap_pyfunction!(find_far_ends, module)?)
}
