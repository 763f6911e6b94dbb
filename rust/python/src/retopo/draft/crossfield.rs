//! `patterndb._native.retopo.draft.crossfield`.

use numpy::{Complex64, IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_retopo::draft::crossfield::Laplacian;
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn solve_laplacian<'py>(
    py: Python<'py>,
    across: PyReadonlyArray1<'py, i32>,
    weight: PyReadonlyArray1<'py, f64>,
    turned: PyReadonlyArray1<'py, Complex64>,
    pull: PyReadonlyArray1<'py, f64>,
    right: PyReadonlyArray1<'py, Complex64>,
    start: PyReadonlyArray1<'py, Complex64>,
) -> PyResult<Bound<'py, PyArray1<Complex64>>> {
    let laplacian = Laplacian {
        across: read(&across)?,
        weight: read(&weight)?,
        turned: read(&turned)?,
        pull: read(&pull)?,
    };
    let (right, start) = (read(&right)?, read(&start)?);
    let found = run(py, || laplacian.solve(right, start))?;
    Ok(found.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(solve_laplacian, module)?)
}
