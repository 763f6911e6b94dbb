//! `patterndb._native.query.holes.loops`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_query::holes::loops::{self, Faces};
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn turn_alike<'py>(
    py: Python<'py>,
    face: PyReadonlyArray1<'py, i32>,
    partner: PyReadonlyArray1<'py, i32>,
    same: PyReadonlyArray1<'py, bool>,
    start: PyReadonlyArray1<'py, i64>,
) -> PyResult<(Bound<'py, PyArray1<bool>>, i64)> {
    let faces = Faces {
        face: read(&face)?,
        twin: read(&partner)?,
        start: read(&start)?,
    };
    let same = read(&same)?;
    let (flip, torn) = run(py, || loops::turn_alike(faces, same))?;
    Ok((flip.into_pyarray(py), torn.map_or(-1, |h| h as i64)))
}

type LoopArrays<'py> = (Bound<'py, PyArray1<i32>>, Bound<'py, PyArray1<i64>>);

#[pyfunction]
fn walk_borders<'py>(
    py: Python<'py>,
    border: PyReadonlyArray1<'py, i32>,
    twin: PyReadonlyArray1<'py, i32>,
    previous: PyReadonlyArray1<'py, i32>,
    crowded: PyReadonlyArray1<'py, bool>,
) -> PyResult<LoopArrays<'py>> {
    let (border, twin) = (read(&border)?, read(&twin)?);
    let (previous, crowded) = (read(&previous)?, read(&crowded)?);
    let walk = || loops::walk_borders(border, twin, previous, crowded);
    let (loops, starts) = run(py, walk)?;
    Ok((loops.into_pyarray(py), starts.into_pyarray(py)))
}

#[pyfunction]
fn flood<'py>(
    py: Python<'py>,
    root: usize,
    face: PyReadonlyArray1<'py, i32>,
    twin: PyReadonlyArray1<'py, i32>,
    start: PyReadonlyArray1<'py, i64>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let faces = Faces {
        face: read(&face)?,
        twin: read(&twin)?,
        start: read(&start)?,
    };
    Ok(run(py, || loops::flood(root, faces))?.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(turn_alike, module)?)?;
    module.add_function(wrap_pyfunction!(walk_borders, module)?)?;
    module.add_function(wrap_pyfunction!(flood, module)?)
}
