//! `patterndb._native.retopo.draft.remesh`.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1,
    PyReadwriteArray2,
};
use patterndb_retopo::draft::remesh::{self, Collapse, Mesh};
use pyo3::prelude::*;

use crate::arrays::{read, run, write};
use crate::rows::{from_rows, read_rows, write_rows};

type Points<'py> = Bound<'py, PyArray2<f64>>;

/// Vertices, triangles and twins.
type MeshArrays<'py> = (
    Points<'py>,
    Bound<'py, PyArray2<i32>>,
    Bound<'py, PyArray1<i32>>,
);

#[pyfunction]
fn split_long<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    triangles: PyReadonlyArray2<'py, i32>,
    twin: PyReadonlyArray1<'py, i32>,
    longest: f64,
) -> PyResult<MeshArrays<'py>> {
    let (points, triangles) = (read_rows(&points)?, read_rows(&triangles)?);
    let twin = read(&twin)?;
    let mesh = run(py, || {
        let mut mesh = Mesh {
            points: points.to_vec(),
            triangles: triangles.to_vec(),
            twin: twin.to_vec(),
        };
        mesh.split_long(longest);
        mesh
    })?;
    Ok((
        from_rows(py, mesh.points)?,
        from_rows(py, mesh.triangles)?,
        mesh.twin.into_pyarray(py),
    ))
}

#[pyfunction]
fn mark_border<'py>(
    py: Python<'py>,
    n: usize,
    triangles: PyReadonlyArray2<'py, i32>,
    twin: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let (triangles, twin) = (read_rows(&triangles)?, read(&twin)?);
    let found = run(py, || remesh::mark_border(n, triangles, twin))?;
    Ok(found.into_pyarray(py))
}

#[pyfunction]
fn collapse_short<'py>(
    py: Python<'py>,
    mut points: PyReadwriteArray2<'py, f64>,
    mut triangles: PyReadwriteArray2<'py, i32>,
    mut twin: PyReadwriteArray1<'py, i32>,
    shortest: f64,
    longest: f64,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let collapse = Collapse {
        points: write_rows(&mut points)?,
        triangles: write_rows(&mut triangles)?,
        twin: write(&mut twin)?,
        shortest,
        longest,
    };
    let alive = run(py, || collapse.run())?;
    Ok(alive.into_pyarray(py))
}

#[pyfunction]
fn flip_to_valence<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    mut triangles: PyReadwriteArray2<'py, i32>,
    mut twin: PyReadwriteArray1<'py, i32>,
    border: PyReadonlyArray1<'py, bool>,
) -> PyResult<()> {
    let (points, border) = (read_rows(&points)?, read(&border)?);
    let (triangles, twin) = (write_rows(&mut triangles)?, write(&mut twin)?);
    run(py, || {
        remesh::flip_to_valence(points, triangles, twin, border)
    })
}

#[pyfunction]
fn relax<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    triangles: PyReadonlyArray2<'py, i32>,
    border: PyReadonlyArray1<'py, bool>,
) -> PyResult<(Points<'py>, Points<'py>)> {
    let (points, triangles) = (read_rows(&points)?, read_rows(&triangles)?);
    let border = read(&border)?;
    let (moved, normals) = run(py, || remesh::relax(points, triangles, border))?;
    Ok((from_rows(py, moved)?, from_rows(py, normals)?))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(split_long, module)?)?;
    module.add_function(wrap_pyfunction!(mark_border, module)?)?;
    module.add_function(wrap_pyfunction!(collapse_short, module)?)?;
    module.add_function(wrap_pyfunction!(flip_to_valence, module)?)?;
    module.add_function(wrap_pyfunction!(relax, module)?)
}
