//! `patterndb._native.core.shortcode`.

use numpy::{Element, IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_core::shortcode::{self, Rows};
use pyo3::prelude::*;

use crate::arrays::{read, run};

type RowArrays<'py, T> = (Bound<'py, PyArray1<T>>, Bound<'py, PyArray1<i64>>);
type CheckedArrays<'py, T> = (Bound<'py, PyArray1<T>>, Bound<'py, PyArray1<i64>>, i64);

fn checked<T: Element>(py: Python<'_>, rows: Rows<T>) -> CheckedArrays<'_, T> {
    let bad = rows.bad.map_or(-1, |row| row as i64);
    (rows.flat.into_pyarray(py), rows.ends.into_pyarray(py), bad)
}

#[pyfunction]
fn name_once<'py>(
    py: Python<'py>,
    symbols: PyReadonlyArray1<'py, i32>,
    offsets: PyReadonlyArray1<'py, i64>,
) -> PyResult<CheckedArrays<'py, i32>> {
    let (symbols, offsets) = (read(&symbols)?, read(&offsets)?);
    Ok(checked(
        py,
        run(py, || shortcode::name_once(symbols, offsets))?,
    ))
}

#[pyfunction]
fn name_twice<'py>(
    py: Python<'py>,
    raw: PyReadonlyArray1<'py, u8>,
    ends: PyReadonlyArray1<'py, i64>,
) -> PyResult<CheckedArrays<'py, u16>> {
    let (raw, ends) = (read(&raw)?, read(&ends)?);
    Ok(checked(py, run(py, || shortcode::name_twice(raw, ends))?))
}

#[pyfunction]
fn pack_symbols<'py>(
    py: Python<'py>,
    symbols: PyReadonlyArray1<'py, u16>,
    offsets: PyReadonlyArray1<'py, i64>,
) -> PyResult<RowArrays<'py, u8>> {
    let (symbols, offsets) = (read(&symbols)?, read(&offsets)?);
    let rows = run(py, || shortcode::pack_symbols(symbols, offsets))?;
    Ok((rows.flat.into_pyarray(py), rows.ends.into_pyarray(py)))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(name_once, module)?)?;
    module.add_function(wrap_pyfunction!(name_twice, module)?)?;
    module.add_function(wrap_pyfunction!(pack_symbols, module)?)
}
