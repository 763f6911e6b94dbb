//! `patterndb._native.core.description`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use patterndb_core::description::{self, LISTS};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::from_rows;

type Described<'py> = (
    Bound<'py, PyArray2<i32>>,
    Bound<'py, PyArray1<u16>>,
    Bound<'py, PyArray1<i64>>,
    i64,
);

#[pyfunction]
fn describe<'py>(
    py: Python<'py>,
    flat: PyReadonlyArray1<'py, u16>,
    offsets: PyReadonlyArray1<'py, i64>,
) -> PyResult<Described<'py>> {
    let (flat, offsets) = (read(&flat)?, read(&offsets)?);
    let mut rows = run(py, || description::describe(flat, offsets))?;
    if rows.bad.is_some() {
        // The Python function returns its array uncut then.
        let n = (rows.ends.len() - 1) / LISTS;
        rows.lists.resize(7 * (2 * (flat.len() / 4) + 3 * n), 0);
    }
    Ok((
        from_rows(py, rows.counts)?,
        rows.lists.into_pyarray(py),
        rows.ends.into_pyarray(py),
        rows.bad.map_or(-1, |row| row as i64),
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(describe, module)?)
}
