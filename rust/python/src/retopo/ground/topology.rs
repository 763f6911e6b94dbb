//! `patterndb._native.retopo.ground.topology`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_retopo::ground::topology;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::read_rows;

#[pyfunction]
fn pair_sides<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    triangles: PyReadonlyArray2<'py, i32>,
    start: PyReadonlyArray1<'py, i32>,
    sides: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let (vertices, triangles) = (read_rows(&vertices)?, read_rows(&triangles)?);
    let (start, sides) = (read(&start)?, read(&sides)?);
    let across = run(py, || {
        topology::pair_sides(vertices, triangles, start, sides)
    })?;
    Ok(across.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(pair_sides, module)?)
}
