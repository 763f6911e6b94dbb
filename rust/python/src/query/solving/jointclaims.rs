//! `patterndb._native.query.solving.jointclaims`.

use numpy::{
    IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1,
    PyUntypedArrayMethods,
};
use patterndb_query::solving::jointclaims::{self, MOST_SIDES, Sums};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{read, run, write};
use crate::rows::read_all;

type Numbers<'py> = Bound<'py, PyArray1<i32>>;

#[pyfunction]
fn list_joint_claims<'py>(
    py: Python<'py>,
    claim: PyReadonlyArray2<'py, i32>,
    near_first: PyReadonlyArray1<'py, i32>,
    near: PyReadonlyArray1<'py, i16>,
) -> PyResult<(Numbers<'py>, Numbers<'py>, Numbers<'py>)> {
    let n_sides = claim.shape()[1];
    let (claim, near_first, near) = (read_all(&claim)?, read(&near_first)?, read(&near)?);
    let made = run(py, || {
        jointclaims::list_joint_claims(claim, n_sides, near_first, near)
    })?;
    Ok((
        made.graph.into_pyarray(py),
        made.first.into_pyarray(py),
        made.claims.into_pyarray(py),
    ))
}

#[pyfunction]
fn sum_needs(
    py: Python<'_>,
    need: PyReadonlyArray1<'_, i32>,
    mut sums: PyReadwriteArray1<'_, i32>,
) -> PyResult<()> {
    let need: &[i32; MOST_SIDES] = read(&need)?
        .try_into()
        .map_err(|_| PyValueError::new_err(format!("needs are those of {MOST_SIDES} sides")))?;
    let sums = write(&mut sums)?;
    run(py, || {
        let mut made = Sums::default();
        made.fill(need);
        sums.copy_from_slice(made.items());
    })
}

#[pyfunction]
fn is_refused(
    py: Python<'_>,
    first: usize,
    last: usize,
    claims: PyReadonlyArray1<'_, i32>,
    sums: PyReadonlyArray1<'_, i32>,
) -> PyResult<bool> {
    let (claims, sums) = (read(&claims)?, read(&sums)?);
    run(py, || Sums::from_items(sums).refuse(&claims[first..last]))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(is_refused, module)?)?;
    module.add_function(wrap_pyfunction!(list_joint_claims, module)?)?;
    module.add_function(wrap_pyfunction!(sum_needs, module)?)
}
