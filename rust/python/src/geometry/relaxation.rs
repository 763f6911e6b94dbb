//! `patterndb._native.geometry.relaxation`.

use numpy::{Complex64, PyReadonlyArray2, PyReadwriteArray1};
use patterndb_geometry::relaxation::{self, Disk};
use pyo3::prelude::*;

use crate::arrays::{run, write};
use crate::rows::read_rows;

#[pyfunction]
fn relax_points<'py>(
    py: Python<'py>,
    mut y: PyReadwriteArray1<'py, Complex64>,
    handles: usize,
    moving: bool,
    ends: PyReadonlyArray2<'py, i32>,
    weights: PyReadonlyArray2<'py, f64>,
    quads: PyReadonlyArray2<'py, i32>,
    angle: PyReadonlyArray2<'py, f64>,
    size: f64,
    rounds: usize,
    steps: usize,
    mut points: PyReadwriteArray1<'py, Complex64>,
) -> PyResult<f64> {
    let disk = Disk {
        handles,
        moving,
        ends: read_rows(&ends)?,
        weights: read_rows(&weights)?,
        quads: read_rows(&quads)?,
        angles: read_rows(&angle)?,
        size,
    };
    let (y, points) = (write(&mut y)?, write(&mut points)?);
    run(py, || {
        relaxation::relax_points(&disk, y, rounds, steps, points)
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(relax_points, module)?)
}
