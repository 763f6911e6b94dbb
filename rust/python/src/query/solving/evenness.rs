//! `patterndb._native.query.solving.evenness`.

use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_query::solving::evenness;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_table, read_all};

#[pyfunction]
fn even_cost(py: Python<'_>, parts: i32, value: i32) -> PyResult<i64> {
    run(py, || evenness::even_cost(parts, value))
}

#[pyfunction]
fn list_splits<'py>(
    py: Python<'py>,
    values: PyReadonlyArray2<'py, i32>,
    class_n: PyReadonlyArray1<'py, i32>,
    class_of: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    let (values, class_n, class_of) = (read_all(&values)?, read(&class_n)?, read(&class_of)?);
    let widths = run(py, || evenness::list_splits(values, class_n, class_of))?;
    let n = class_of.len();
    from_table(py, widths.len() / n.max(1), n, widths)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(even_cost, module)?)?;
    module.add_function(wrap_pyfunction!(list_splits, module)?)
}
