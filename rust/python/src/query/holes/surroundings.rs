//! `patterndb._native.query.holes.surroundings`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_query::holes::surroundings::{self, Faces, Rim};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

#[pyfunction]
fn count_faces<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    following: PyReadonlyArray1<'py, i32>,
    h: i32,
) -> PyResult<i32> {
    let (twin, following) = (read(&twin)?, read(&following)?);
    run(py, || surroundings::count_faces(twin, following, h))
}

type FanArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);

#[pyfunction]
fn measure_fans<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    corners: PyReadonlyArray1<'py, i32>,
    offsets: PyReadonlyArray1<'py, i64>,
    n_loop: usize,
) -> PyResult<FanArrays<'py>> {
    let faces = Faces {
        points: read_rows(&points)?,
        corners: read(&corners)?,
        offsets: read(&offsets)?,
        n_loop,
    };
    let (normals, angles) = run(py, || surroundings::measure_fans(&faces))?;
    Ok((from_rows(py, normals)?, angles.into_pyarray(py)))
}

#[pyfunction]
fn find_normals_beyond<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    corners: PyReadonlyArray1<'py, i32>,
    offsets: PyReadonlyArray1<'py, i64>,
    n_loop: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let faces = Faces {
        points: read_rows(&points)?,
        corners: read(&corners)?,
        offsets: read(&offsets)?,
        n_loop,
    };
    let beyond = run(py, || surroundings::find_normals_beyond(&faces))?;
    from_rows(py, beyond)
}

#[pyfunction]
fn own_features<'py>(
    py: Python<'py>,
    r#loop: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    angle_outside: PyReadonlyArray1<'py, f64>,
    outside: PyReadonlyArray1<'py, i32>,
    clamped_valence: PyReadonlyArray1<'py, i32>,
    scale: f64,
    spokes: PyReadonlyArray1<'py, f64>,
    far: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rim = Rim {
        points: read_rows(&r#loop)?,
        normals: read_rows(&normals)?,
        angle_outside: read(&angle_outside)?,
        outside: read(&outside)?,
        clamped_valence: read(&clamped_valence)?,
        scale,
        spokes: read(&spokes)?,
        far: read(&far)?,
    };
    let rows = run(py, || surroundings::own_features(&rim))?;
    from_rows(py, rows)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(count_faces, module)?)?;
    module.add_function(wrap_pyfunction!(measure_fans, module)?)?;
    module.add_function(wrap_pyfunction!(find_normals_beyond, module)?)?;
    module.add_function(wrap_pyfunction!(own_features, module)?)
}
