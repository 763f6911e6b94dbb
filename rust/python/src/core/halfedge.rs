//! `patterndb._native.core.halfedge`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_core::halfedge;
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn fans<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
) -> PyResult<(Bound<'py, PyArray1<i32>>, i32)> {
    let twin = read(&twin)?;
    let (vertex, count) = run(py, || halfedge::fans(twin))?;
    Ok((vertex.into_pyarray(py), count))
}

#[pyfunction]
fn border_vertices<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    vertex: PyReadonlyArray1<'py, i32>,
    n_vertices: usize,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let (twin, vertex) = (read(&twin)?, read(&vertex)?);
    let border = run(py, || halfedge::border_vertices(twin, vertex, n_vertices))?;
    Ok(border.into_pyarray(py))
}

#[pyfunction]
fn next_border_edge(py: Python<'_>, twin: PyReadonlyArray1<'_, i32>, h: i32) -> PyResult<i32> {
    let twin = read(&twin)?;
    run(py, || halfedge::next_border_edge(twin, h))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(fans, module)?)?;
    module.add_function(wrap_pyfunction!(border_vertices, module)?)?;
    module.add_function(wrap_pyfunction!(next_border_edge, module)?)
}
