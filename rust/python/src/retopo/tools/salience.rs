//! `patterndb._native.retopo.tools.salience`.

use numpy::{PyArray3, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_retopo::tools::salience::Dots;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_blocks, read_rows};

#[pyfunction]
fn sum_dots<'py>(
    py: Python<'py>,
    at: PyReadonlyArray2<'py, f64>,
    up: PyReadonlyArray2<'py, f64>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    tensors: PyReadonlyArray2<'py, f64>,
    low: PyReadonlyArray1<'py, f64>,
    keys: PyReadonlyArray1<'py, i64>,
    starts: PyReadonlyArray1<'py, i64>,
    width: f64,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let dots = Dots {
        points: read_rows(&points)?,
        normals: read_rows(&normals)?,
        tensors: read_rows(&tensors)?,
        low: read(&low)?
            .try_into()
            .map_err(|_| PyValueError::new_err("a point has three coordinates"))?,
        keys: read(&keys)?,
        starts: read(&starts)?,
        width,
    };
    let (at, up) = (read_rows(&at)?, read_rows(&up)?);
    let sums = run(py, || {
        at.iter().zip(up).map(|(at, up)| dots.sum(at, up)).collect()
    })?;
    from_blocks(py, sums)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(sum_dots, module)?)
}
