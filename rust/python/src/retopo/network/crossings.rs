//! `patterndb._native.retopo.network.crossings`.

use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_retopo::network::crossings::{self, Line};
use patterndb_retopo::network::samples::Samples;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

#[pyfunction]
fn cross_chains<'py>(
    py: Python<'py>,
    line: PyReadonlyArray2<'py, f64>,
    up: PyReadonlyArray2<'py, f64>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    starts: PyReadonlyArray1<'py, i32>,
    loose: PyReadonlyArray1<'py, bool>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let line = Line {
        points: read_rows(&line)?,
        normals: read_rows(&up)?,
    };
    let of = Samples {
        points: read_rows(&points)?,
        normals: read_rows(&normals)?,
        starts: read(&starts)?,
        loose: read(&loose)?,
    };
    let found = run(py, || crossings::cross_chains(line, &of))?;
    from_rows(py, found)
}

#[pyfunction]
fn cross_itself<'py>(
    py: Python<'py>,
    line: PyReadonlyArray2<'py, f64>,
    aside: PyReadonlyArray2<'py, f64>,
    up: PyReadonlyArray2<'py, f64>,
    closed: bool,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let line = Line {
        points: read_rows(&line)?,
        normals: read_rows(&up)?,
    };
    let aside = read_rows(&aside)?;
    let found = run(py, || crossings::cross_itself(line, aside, closed))?;
    from_rows(py, found)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(cross_chains, module)?)?;
    module.add_function(wrap_pyfunction!(cross_itself, module)?)
}
