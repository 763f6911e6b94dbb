//! `patterndb._native.query.placing.region`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_query::placing::region;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::read_rows;

#[pyfunction]
fn flood_left<'py>(
    py: Python<'py>,
    beside: PyReadonlyArray2<'py, i32>,
    barrier: PyReadonlyArray1<'py, bool>,
    voters: PyReadonlyArray1<'py, i32>,
    sides: PyReadonlyArray1<'py, i8>,
) -> PyResult<(Bound<'py, PyArray1<bool>>, bool)> {
    let (beside, barrier) = (read_rows(&beside)?, read(&barrier)?);
    let (voters, sides) = (read(&voters)?, read(&sides)?);
    let (inside, separates) = run(py, || region::flood_left(beside, barrier, voters, sides))?;
    Ok((inside.into_pyarray(py), separates))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(flood_left, module)?)
}
