//! `patterndb._native.retopo.ground.planarcut`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_retopo::ground::planarcut;
use patterndb_retopo::ground::topology::Surface;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::read_rows;

#[pyfunction]
fn find_cut_sides<'py>(
    py: Python<'py>,
    triangles: PyReadonlyArray2<'py, i32>,
    height: PyReadonlyArray1<'py, f64>,
    f: usize,
) -> PyResult<(i32, i32)> {
    let (triangles, height) = (read_rows(&triangles)?, read(&height)?);
    let found = run(py, || planarcut::find_cut_sides(triangles, height, f))?;
    Ok((found.out, found.into))
}

#[pyfunction]
fn place_crossing<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    triangles: PyReadonlyArray2<'py, i32>,
    height: PyReadonlyArray1<'py, f64>,
    side: i32,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let surface = Surface {
        vertices: read_rows(&vertices)?,
        triangles: read_rows(&triangles)?,
    };
    let height = read(&height)?;
    let place = run(py, || planarcut::place_crossing(surface, height, side))?;
    Ok(place.to_vec().into_pyarray(py))
}

#[pyfunction]
fn follow_cut<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    triangles: PyReadonlyArray2<'py, i32>,
    across: PyReadonlyArray1<'py, i32>,
    height: PyReadonlyArray1<'py, f64>,
    side: i32,
    most: f64,
) -> PyResult<(Bound<'py, PyArray1<i32>>, f64, bool)> {
    let surface = Surface {
        vertices: read_rows(&vertices)?,
        triangles: read_rows(&triangles)?,
    };
    let (across, height) = (read(&across)?, read(&height)?);
    let part = run(py, || {
        planarcut::follow_cut(surface, across, height, side, most)
    })?;
    Ok((part.sides.into_pyarray(py), part.length, part.closed))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(find_cut_sides, module)?)?;
    module.add_function(wrap_pyfunction!(place_crossing, module)?)?;
    module.add_function(wrap_pyfunction!(follow_cut, module)?)
}
