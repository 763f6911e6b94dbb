//! `patterndb._native.store.ddqkey`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_core::code::Sense;
use patterndb_core::ddqkey;
use pyo3::prelude::*;

use crate::arrays::{read, run};

type Numbers<'py> = Bound<'py, PyArray1<i32>>;

#[pyfunction]
fn smallest_key<'py>(
    py: Python<'py>,
    code: PyReadonlyArray1<'py, u16>,
    clockwise: bool,
) -> PyResult<(Numbers<'py>, Numbers<'py>)> {
    let code = read(&code)?;
    let sense = if clockwise {
        Sense::Clockwise
    } else {
        Sense::CounterClockwise
    };
    let key = run(py, || ddqkey::smallest_key(code, sense))?;
    Ok((key.faces.into_pyarray(py), key.twin.into_pyarray(py)))
}

type Surveyed<'py> = (
    Numbers<'py>,
    Bound<'py, PyArray1<bool>>,
    Numbers<'py>,
    i32,
    i64,
);

#[pyfunction]
fn survey<'py>(py: Python<'py>, twin: PyReadonlyArray1<'py, i32>) -> PyResult<Surveyed<'py>> {
    let twin = read(&twin)?;
    let made = run(py, || ddqkey::survey(twin))?;
    Ok((
        made.chords.into_pyarray(py),
        made.corners.into_pyarray(py),
        made.valences.into_pyarray(py),
        made.n_vertices,
        made.n_concave,
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(smallest_key, module)?)?;
    module.add_function(wrap_pyfunction!(survey, module)?)
}
