//! `patterndb._native.features.ribs.polygon`.

use numpy::{PyArray2, PyReadonlyArray2};
use patterndb_features::ribs::polygon;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::{from_rows, read_rows};

type SampleArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, i64);

#[pyfunction]
fn sample_polygon<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    closed: bool,
    count: usize,
) -> PyResult<SampleArrays<'py>> {
    let points = read_rows(&points)?;
    let samples = run(py, || polygon::sample_polygon(points, closed, count))?;
    Ok((
        from_rows(py, samples.places)?,
        from_rows(py, samples.normals)?,
        samples.nearest.map_or(-1, |i| i as i64),
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(sample_polygon, module)?)
}
