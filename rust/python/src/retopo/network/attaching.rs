//! `patterndb._native.retopo.network.attaching`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_retopo::network::attaching;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::retopo::ground::read_items;
use crate::rows::read_rows;

#[pyfunction]
fn find_departure<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    backwards: bool,
    reach: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let points = read_rows(&points)?;
    let departure = run(py, || attaching::find_departure(points, backwards, reach))?;
    Ok(departure.to_vec().into_pyarray(py))
}

#[pyfunction]
fn measure_turn<'py>(
    normal: PyReadonlyArray1<'py, f64>,
    one: PyReadonlyArray1<'py, f64>,
    two: PyReadonlyArray1<'py, f64>,
) -> PyResult<f64> {
    let (one, two) = (read_items(&one)?, read_items(&two)?);
    Ok(attaching::measure_turn(read_items(&normal)?, one, two))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(find_departure, module)?)?;
    module.add_function(wrap_pyfunction!(measure_turn, module)?)
}
