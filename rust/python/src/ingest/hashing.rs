//! `patterndb._native.ingest.hashing`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_ingest::hashing;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

type MapArrays<'py> = (Bound<'py, PyArray2<u64>>, Bound<'py, PyArray1<i32>>);

#[pyfunction]
fn random_pairs(py: Python<'_>, n: usize) -> PyResult<Bound<'_, PyArray2<u64>>> {
    let pairs = run(py, || hashing::random_pairs(n))?;
    from_rows(py, pairs)
}

/// A code, or the bytes of a packed one.
#[derive(FromPyObject)]
enum Symbols<'py> {
    Code(PyReadonlyArray1<'py, u16>),
    Packed(PyReadonlyArray1<'py, u8>),
}

#[pyfunction]
fn hash_symbols<'py>(py: Python<'py>, code: Symbols<'py>, n: usize) -> PyResult<(u64, u64)> {
    let hash = match &code {
        Symbols::Code(code) => {
            let code = read(code)?;
            run(py, || hashing::hash_symbols(&code[..n]))
        }
        Symbols::Packed(code) => {
            let code = read(code)?;
            run(py, || hashing::hash_symbols(&code[..n]))
        }
    };
    Ok(hash?.into())
}

#[pyfunction]
fn find<'py>(py: Python<'py>, keys: PyReadonlyArray2<'py, u64>, a: u64, b: u64) -> PyResult<i64> {
    let keys = read_rows(&keys)?;
    let found = run(py, || hashing::find(keys, [a, b]))?;
    Ok(match found {
        Ok(slot) => slot as i64,
        Err(slot) => -1 - slot as i64,
    })
}

#[pyfunction]
fn double_set<'py>(
    py: Python<'py>,
    keys: PyReadonlyArray2<'py, u64>,
) -> PyResult<Bound<'py, PyArray2<u64>>> {
    let keys = read_rows(&keys)?;
    let bigger = run(py, || hashing::double_set(keys))?;
    from_rows(py, bigger)
}

#[pyfunction]
fn double_map<'py>(
    py: Python<'py>,
    keys: PyReadonlyArray2<'py, u64>,
    values: PyReadonlyArray1<'py, i32>,
) -> PyResult<MapArrays<'py>> {
    let (keys, values) = (read_rows(&keys)?, read(&values)?);
    let (bigger, moved) = run(py, || hashing::double_map(keys, values))?;
    Ok((from_rows(py, bigger)?, moved.into_pyarray(py)))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(random_pairs, module)?)?;
    module.add_function(wrap_pyfunction!(hash_symbols, module)?)?;
    module.add_function(wrap_pyfunction!(find, module)?)?;
    module.add_function(wrap_pyfunction!(double_set, module)?)?;
    module.add_function(wrap_pyfunction!(double_map, module)?)
}
