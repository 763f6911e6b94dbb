//! `patterndb._native.query.identity`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_query::identity;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::read_rows;

#[pyfunction]
fn weld_quads<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray2<'py, i32>,
    n_vertices: usize,
    perimeter: i32,
) -> PyResult<(Bound<'py, PyArray1<i32>>, u8)> {
    let quads = read_rows(&quads)?;
    let (twin, fault) = run(py, || identity::weld_quads(quads, n_vertices, perimeter))?;
    Ok((twin.into_pyarray(py), fault as u8))
}

#[pyfunction]
fn read_code<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray2<'py, i32>,
    twin: PyReadonlyArray1<'py, i32>,
    closed: bool,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let (quads, twin) = (read_rows(&quads)?, read(&twin)?);
    let code = run(py, || identity::read_code(quads, twin, closed))?;
    Ok(code.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(read_code, module)?)?;
    module.add_function(wrap_pyfunction!(weld_quads, module)?)
}
