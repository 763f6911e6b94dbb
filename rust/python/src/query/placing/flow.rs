//! `patterndb._native.query.placing.flow`.

use numpy::{PyArray2, PyReadonlyArray2};
use patterndb_query::placing::flow;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::{from_rows, read_rows};

#[pyfunction]
fn measure_open_distance<'py>(
    py: Python<'py>,
    stroke: PyReadonlyArray2<'py, f64>,
    middle: PyReadonlyArray2<'py, f64>,
) -> PyResult<(f64, f64, f64)> {
    let (stroke, middle) = (read_rows(&stroke)?, read_rows(&middle)?);
    let found = run(py, || flow::measure_open_distance(stroke, middle))?;
    Ok((found.integral, found.mean, found.most))
}

#[pyfunction]
fn measure_loop_distance<'py>(
    py: Python<'py>,
    stroke: PyReadonlyArray2<'py, f64>,
    middle: PyReadonlyArray2<'py, f64>,
) -> PyResult<(f64, f64, f64, f64, bool)> {
    let (stroke, middle) = (read_rows(&stroke)?, read_rows(&middle)?);
    let found = run(py, || flow::measure_loop_distance(stroke, middle))?;
    let distance = found.distance;
    Ok((
        distance.integral,
        distance.mean,
        distance.most,
        found.offset,
        found.against,
    ))
}

#[pyfunction]
fn list_open_targets<'py>(
    py: Python<'py>,
    stroke: PyReadonlyArray2<'py, f64>,
    middle: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (stroke, middle) = (read_rows(&stroke)?, read_rows(&middle)?);
    from_rows(py, run(py, || flow::list_open_targets(stroke, middle))?)
}

#[pyfunction]
fn list_loop_targets<'py>(
    py: Python<'py>,
    stroke: PyReadonlyArray2<'py, f64>,
    middle: PyReadonlyArray2<'py, f64>,
    offset: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (stroke, middle) = (read_rows(&stroke)?, read_rows(&middle)?);
    let targets = run(py, || flow::list_loop_targets(stroke, middle, offset))?;
    from_rows(py, targets)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(measure_open_distance, module)?)?;
    module.add_function(wrap_pyfunction!(measure_loop_distance, module)?)?;
    module.add_function(wrap_pyfunction!(list_open_targets, module)?)?;
    module.add_function(wrap_pyfunction!(list_loop_targets, module)?)
}
