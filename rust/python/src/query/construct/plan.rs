//! `patterndb._native.query.construct.plan`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_query::construct::plan;
use pyo3::prelude::*;

use crate::arrays::{read, run};

/// The two loops into which a chord cuts one.
type Loops<'py> = (Bound<'py, PyArray1<i32>>, Bound<'py, PyArray1<i32>>);

#[pyfunction]
#[pyo3(signature = (r#loop, start, end, inner))]
fn split_loop<'py>(
    py: Python<'py>,
    r#loop: PyReadonlyArray1<'py, i32>,
    start: i64,
    end: i64,
    inner: PyReadonlyArray1<'py, i32>,
) -> PyResult<Loops<'py>> {
    let (vertices, inner) = (read(&r#loop)?, read(&inner)?);
    let [left, right] = run(py, || plan::split_loop(vertices, start, end, inner))?;
    Ok((left.into_pyarray(py), right.into_pyarray(py)))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(split_loop, module)?)
}
