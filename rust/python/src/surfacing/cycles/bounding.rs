//! `patterndb._native.surfacing.cycles.bounding`.

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use patterndb_surfacing::cycles::bounding::{self, Curves, Incidence, Pairs};
use pyo3::prelude::*;

use crate::arrays::{read, run, write};

#[pyfunction]
fn spread_costs<'py>(
    py: Python<'py>,
    first: PyReadonlyArray1<'py, i64>,
    member: PyReadonlyArray1<'py, i64>,
    place: PyReadonlyArray1<'py, i64>,
    start: PyReadonlyArray1<'py, i64>,
    offset: PyReadonlyArray1<'py, i64>,
    one: PyReadonlyArray1<'py, i64>,
    other: PyReadonlyArray1<'py, i64>,
    price: PyReadonlyArray1<'py, f64>,
    mut cost: PyReadwriteArray1<'py, f64>,
) -> PyResult<()> {
    let incidence = Incidence {
        first: read(&first)?,
        member: read(&member)?,
        place: read(&place)?,
        start: read(&start)?,
        offset: read(&offset)?,
    };
    let pairs = Pairs {
        one: read(&one)?,
        other: read(&other)?,
        price: read(&price)?,
    };
    let cost = write(&mut cost)?;
    run(py, || bounding::spread_costs(&incidence, &pairs, cost))
}

#[pyfunction]
fn move_shares<'py>(
    py: Python<'py>,
    first: PyReadonlyArray1<'py, i64>,
    member: PyReadonlyArray1<'py, i64>,
    place: PyReadonlyArray1<'py, i64>,
    start: PyReadonlyArray1<'py, i64>,
    offset: PyReadonlyArray1<'py, i64>,
    cost: PyReadonlyArray1<'py, f64>,
    room: PyReadonlyArray1<'py, i64>,
    whole: PyReadonlyArray1<'py, bool>,
    mut shares: PyReadwriteArray1<'py, f64>,
    mut margin: PyReadwriteArray1<'py, f64>,
    sweeps: usize,
) -> PyResult<f64> {
    let incidence = Incidence {
        first: read(&first)?,
        member: read(&member)?,
        place: read(&place)?,
        start: read(&start)?,
        offset: read(&offset)?,
    };
    let curves = Curves {
        cost: read(&cost)?,
        room: read(&room)?,
        whole: read(&whole)?,
    };
    let (shares, margin) = (write(&mut shares)?, write(&mut margin)?);
    run(py, || {
        bounding::move_shares(&incidence, &curves, shares, margin, sweeps)
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(spread_costs, module)?)?;
    module.add_function(wrap_pyfunction!(move_shares, module)?)
}
