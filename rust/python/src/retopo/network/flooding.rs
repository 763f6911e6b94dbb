//! `patterndb._native.retopo.network.flooding`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_retopo::network::flooding;
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn flood<'py>(
    py: Python<'py>,
    across: PyReadonlyArray1<'py, i32>,
    crossed: PyReadonlyArray1<'py, bool>,
    areas: PyReadonlyArray1<'py, f64>,
    seeds: PyReadonlyArray1<'py, i32>,
    most: f64,
) -> PyResult<(Bound<'py, PyArray1<i32>>, f64)> {
    let (across, crossed) = (read(&across)?, read(&crossed)?);
    let (areas, seeds) = (read(&areas)?, read(&seeds)?);
    let (found, area) = run(py, || flooding::flood(across, crossed, areas, seeds, most))?;
    Ok((found.into_pyarray(py), area))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(flood, module)?)
}
