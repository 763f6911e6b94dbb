//! `patterndb._native.query.solving.sieve`.

use numpy::{
    IntoPyArray, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
    PyReadwriteArray1, PyReadwriteArray2, PyUntypedArrayMethods,
};
use patterndb_query::solving::sieve::{self, Claims, Sieve, Words};
use pyo3::prelude::*;

use crate::arrays::{read, run, write};
use crate::rows::{read_all, write_all};

#[pyfunction]
fn compare_pairs<'py>(
    py: Python<'py>,
    words: PyReadonlyArray2<'py, i64>,
) -> PyResult<Bound<'py, PyArray3<i64>>> {
    let (n_sides, n) = (words.shape()[0], words.shape()[1]);
    let words = read_all(&words)?;
    let compared = run(py, || sieve::compare_pairs(words, n))?;
    let n_pairs = n_sides.div_ceil(2);
    compared
        .into_pyarray(py)
        .reshape([n_pairs, sieve::PAIRS, n])
}

#[pyfunction]
fn state_claims<'py>(
    py: Python<'py>,
    lengths: PyReadonlyArray2<'py, i32>,
    claimant: PyReadonlyArray1<'py, i16>,
    near_first: PyReadonlyArray1<'py, i32>,
    near: PyReadonlyArray1<'py, i16>,
    claims: PyReadonlyArray1<'py, i32>,
    first: usize,
    mut stated: PyReadwriteArray2<'py, u8>,
) -> PyResult<()> {
    let of_class = Claims {
        lengths: read_all(&lengths)?,
        n_lanes: lengths.shape()[1],
        claimant: read(&claimant)?,
        near_first: read(&near_first)?,
        near: read(&near)?,
    };
    let claims = read(&claims)?;
    let width = stated.shape()[1];
    let stated = write_all(&mut stated)?;
    run(py, || {
        sieve::state_claims(&of_class, claims, first, stated, width)
    })
}

#[pyfunction]
fn sift_system<'py>(
    py: Python<'py>,
    row: usize,
    pairs: PyReadonlyArray2<'py, u8>,
    surplus: PyReadonlyArray2<'py, u8>,
    claim: PyReadonlyArray2<'py, i32>,
    marks: PyReadonlyArray1<'py, i64>,
    compared: PyReadonlyArray3<'py, i64>,
    stated: PyReadonlyArray2<'py, i64>,
    mut left: PyReadwriteArray1<'py, i64>,
) -> PyResult<bool> {
    let sieve = Sieve {
        pairs: read_all(&pairs)?,
        surplus: read_all(&surplus)?,
        claim: read_all(&claim)?,
        marks: read(&marks)?.as_chunks().0,
        compared: read_all(&compared)?.as_chunks().0,
        stated: read_all(&stated)?.as_chunks().0,
        n_sides: surplus.shape()[1],
    };
    let left = write(&mut left)?.as_chunks_mut().0;
    run(py, || sieve.sift(row, left))
}

#[pyfunction]
fn has_lane(py: Python<'_>, left: PyReadonlyArray1<'_, i64>, lane: usize) -> PyResult<bool> {
    let left: &[Words] = read(&left)?.as_chunks().0;
    run(py, || sieve::has_lane(left, lane))
}

#[pyfunction]
fn drop_lane(py: Python<'_>, mut left: PyReadwriteArray1<'_, i64>, lane: usize) -> PyResult<()> {
    let left: &mut [Words] = write(&mut left)?.as_chunks_mut().0;
    run(py, || sieve::drop_lane(left, lane))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(compare_pairs, module)?)?;
    module.add_function(wrap_pyfunction!(drop_lane, module)?)?;
    module.add_function(wrap_pyfunction!(has_lane, module)?)?;
    module.add_function(wrap_pyfunction!(sift_system, module)?)?;
    module.add_function(wrap_pyfunction!(state_claims, module)?)
}
