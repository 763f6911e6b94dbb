//! `patterndb._native.features.splines`: a submodule for each Python module there.

use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use patterndb_features::splines::fit::Basis;
use patterndb_features::splines::knots;
use pyo3::prelude::*;

use crate::add_module;
use crate::arrays::{read, run};
use crate::rows::{from_table, read_all};

fn read_basis<'a>(
    values: &'a PyReadonlyArray2<'_, f64>,
    first: &'a PyReadonlyArray1<'_, i32>,
) -> PyResult<Basis<'a>> {
    Ok(Basis {
        values: read_all(values)?,
        width: values.shape()[1],
        first: read(first)?,
    })
}

#[pyfunction]
fn normal_bands<'py>(
    py: Python<'py>,
    values: PyReadonlyArray2<'py, f64>,
    first: PyReadonlyArray1<'py, i32>,
    n: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let basis = read_basis(&values, &first)?;
    let bands = run(py, || basis.normal_bands(n))?;
    from_table(py, basis.width, n, bands)
}

#[pyfunction]
fn times<'py>(
    py: Python<'py>,
    values: PyReadonlyArray2<'py, f64>,
    first: PyReadonlyArray1<'py, i32>,
    control: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let basis = read_basis(&values, &first)?;
    let n_columns = control.shape()[1];
    let control = read_all(&control)?;
    let product = run(py, || basis.multiply(control, n_columns))?;
    from_table(py, basis.first.len(), n_columns, product)
}

#[pyfunction]
fn transposed<'py>(
    py: Python<'py>,
    values: PyReadonlyArray2<'py, f64>,
    first: PyReadonlyArray1<'py, i32>,
    n: usize,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let basis = read_basis(&values, &first)?;
    let n_columns = points.shape()[1];
    let points = read_all(&points)?;
    let product = run(py, || basis.multiply_transposed(n, points, n_columns))?;
    from_table(py, n, n_columns, product)
}

#[pyfunction]
fn count_determined<'py>(
    py: Python<'py>,
    parameters: PyReadonlyArray1<'py, f64>,
    knots: PyReadonlyArray1<'py, f64>,
    degree: usize,
) -> PyResult<usize> {
    let (parameters, knots) = (read(&parameters)?, read(&knots)?);
    run(py, || knots::count_determined(parameters, knots, degree))
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    let module = &add_module(parent, "fit")?;
    module.add_function(wrap_pyfunction!(normal_bands, module)?)?;
    module.add_function(wrap_pyfunction!(times, module)?)?;
    module.add_function(wrap_pyfunction!(transposed, module)?)?;
    let module = &add_module(parent, "knots")?;
    module.add_function(wrap_pyfunction!(count_determined, module)?)
}
