//! `patterndb._native.ingest.shards`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_ingest::shards;
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn breadth_first<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    root: i32,
    inside: PyReadonlyArray1<'py, bool>,
    part: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let (twin, inside, part) = (read(&twin)?, read(&inside)?, read(&part)?);
    let order = run(py, || shards::breadth_first(twin, root, inside, part))?;
    Ok(order.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(breadth_first, module)?)
}
