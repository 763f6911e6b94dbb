//! `patterndb._native.query.placing.untangle`.

use numpy::{
    IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, PyReadwriteArray2,
};
use patterndb_query::placing::untangle::{self, Movable, Tangle};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{read_blocks, read_rows, write_rows};

fn read_tangle<'a>(
    quads: &'a PyReadonlyArray2<'_, i32>,
    wanted: &'a PyReadonlyArray2<'_, bool>,
    up: &'a PyReadonlyArray2<'_, f64>,
) -> PyResult<Tangle<'a>> {
    Ok(Tangle {
        quads: read_rows(quads)?,
        wanted: read_rows(wanted)?,
        up: read_rows(up)?,
    })
}

#[pyfunction]
fn find_pieces<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray2<'py, i32>,
    free: PyReadonlyArray1<'py, bool>,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let (quads, free) = (read_rows(&quads)?, read(&free)?);
    let pieces = run(py, || untangle::find_pieces(quads, free))?;
    Ok(pieces.into_pyarray(py))
}

#[pyfunction]
fn compute_energy<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray2<'py, i32>,
    wanted: PyReadonlyArray2<'py, bool>,
    up: PyReadonlyArray2<'py, f64>,
    size: f64,
    epsilon: f64,
    points: PyReadonlyArray2<'py, f64>,
    mut force: PyReadwriteArray2<'py, f64>,
) -> PyResult<(f64, f64)> {
    let tangle = read_tangle(&quads, &wanted, &up)?;
    let (points, force) = (read_rows(&points)?, write_rows(&mut force)?);
    let measure = run(py, || {
        untangle::compute_energy(&tangle, size, epsilon, points, force)
    })?;
    Ok((measure.energy, measure.smallest))
}

#[pyfunction]
fn count_flipped_corners<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray2<'py, i32>,
    wanted: PyReadonlyArray2<'py, bool>,
    up: PyReadonlyArray2<'py, f64>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<usize> {
    let tangle = read_tangle(&quads, &wanted, &up)?;
    let points = read_rows(&points)?;
    run(py, || untangle::count_flipped_corners(&tangle, points))
}

// The default of left_over is LEFT of the Python module.
#[pyfunction]
#[pyo3(signature = (quads, wanted, up, free, frames, size, points, left_over=0.75))]
fn minimise_energy<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray2<'py, i32>,
    wanted: PyReadonlyArray2<'py, bool>,
    up: PyReadonlyArray2<'py, f64>,
    free: PyReadonlyArray1<'py, i32>,
    frames: PyReadonlyArray3<'py, f64>,
    size: f64,
    mut points: PyReadwriteArray2<'py, f64>,
    left_over: f64,
) -> PyResult<f64> {
    let tangle = read_tangle(&quads, &wanted, &up)?;
    let movable = Movable {
        free: read(&free)?,
        frames: read_blocks(&frames)?,
    };
    let points = write_rows(&mut points)?;
    run(py, || {
        untangle::minimise_energy(&tangle, &movable, size, points, left_over)
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(find_pieces, module)?)?;
    module.add_function(wrap_pyfunction!(compute_energy, module)?)?;
    module.add_function(wrap_pyfunction!(count_flipped_corners, module)?)?;
    module.add_function(wrap_pyfunction!(minimise_energy, module)?)
}
