//! `patterndb._native.surfacing.tessellation.planar`.

use numpy::{PyArray2, PyReadonlyArray2, PyReadwriteArray1, PyReadwriteArray2};
use patterndb_surfacing::tessellation::planar::{self, Triangles};
use pyo3::prelude::*;

use crate::arrays::{run, write};
use crate::rows::{from_rows, read_rows, write_rows};

#[pyfunction]
fn doubled_area<'py>(py: Python<'py>, at: PyReadonlyArray2<'py, i64>) -> PyResult<f64> {
    let polygon = read_rows(&at)?;
    run(py, || planar::doubled_area(polygon))
}

#[pyfunction]
fn is_simple<'py>(py: Python<'py>, at: PyReadonlyArray2<'py, i64>) -> PyResult<bool> {
    let polygon = read_rows(&at)?;
    run(py, || planar::is_simple(polygon))
}

#[pyfunction]
fn clip_ears<'py>(
    py: Python<'py>,
    at: PyReadonlyArray2<'py, i64>,
    m: usize,
    mut tail: PyReadwriteArray1<'py, i64>,
    mut twin: PyReadwriteArray1<'py, i64>,
) -> PyResult<()> {
    let at = read_rows(&at)?;
    let (tail, twin) = (write(&mut tail)?, write(&mut twin)?);
    run(py, || {
        planar::clip_ears(&at[..m], &mut Triangles { tail, twin });
    })
}

#[pyfunction]
fn make_delaunay<'py>(
    py: Python<'py>,
    at: PyReadonlyArray2<'py, i64>,
    mut tail: PyReadwriteArray1<'py, i64>,
    mut twin: PyReadwriteArray1<'py, i64>,
    triangles: usize,
) -> PyResult<()> {
    let at = read_rows(&at)?;
    let (tail, twin) = (write(&mut tail)?, write(&mut twin)?);
    run(py, || {
        let first = 3 * triangles;
        let (tail, twin) = (&mut tail[..first], &mut twin[..first]);
        Triangles { tail, twin }.make_delaunay(at);
    })
}

#[pyfunction]
fn lay_lattice<'py>(
    py: Python<'py>,
    grid: PyReadonlyArray2<'py, i64>,
    spacing: f64,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let polygon = read_rows(&grid)?;
    let inner = run(py, || planar::lay_lattice(polygon, spacing))?;
    from_rows(py, inner)
}

#[pyfunction]
fn join<'py>(
    py: Python<'py>,
    at: PyReadonlyArray2<'py, i64>,
    m: usize,
    mut tail: PyReadwriteArray1<'py, i64>,
    mut twin: PyReadwriteArray1<'py, i64>,
) -> PyResult<usize> {
    let at = read_rows(&at)?;
    let (tail, twin) = (write(&mut tail)?, write(&mut twin)?);
    run(py, || Triangles { tail, twin }.join(at, m))
}

#[pyfunction]
fn smooth<'py>(
    py: Python<'py>,
    mut at: PyReadwriteArray2<'py, i64>,
    m: usize,
    mut tail: PyReadwriteArray1<'py, i64>,
    mut twin: PyReadwriteArray1<'py, i64>,
) -> PyResult<()> {
    let at = write_rows(&mut at)?;
    let (tail, twin) = (write(&mut tail)?, write(&mut twin)?);
    run(py, || Triangles { tail, twin }.smooth(at, m))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(doubled_area, module)?)?;
    module.add_function(wrap_pyfunction!(is_simple, module)?)?;
    module.add_function(wrap_pyfunction!(clip_ears, module)?)?;
    module.add_function(wrap_pyfunction!(make_delaunay, module)?)?;
    module.add_function(wrap_pyfunction!(lay_lattice, module)?)?;
    module.add_function(wrap_pyfunction!(join, module)?)?;
    module.add_function(wrap_pyfunction!(smooth, module)?)
}
