//! `patterndb._native.query.solving.jointclaims`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use patterndb_query::solving::jointclaims;
use pyo3::prelude::*;

use crate::arrays::{read, run};
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

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(list_joint_claims, module)?)
}
