//! `patterndb._native.core.code`.

use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadwriteArray1};
use patterndb_core::code::{self, Reading, Sense};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{read, run, write};

fn sense(clockwise: bool) -> Sense {
    if clockwise {
        Sense::Clockwise
    } else {
        Sense::CounterClockwise
    }
}

#[pyfunction]
fn rooted_code<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    n_quads: usize,
    start: i32,
    clockwise: bool,
    code: Bound<'py, PyAny>,
    mut number: PyReadwriteArray1<'py, i32>,
    mut entry: PyReadwriteArray1<'py, i32>,
    mut order: PyReadwriteArray1<'py, i32>,
    best: bool,
) -> PyResult<i8> {
    let twin = read(&twin)?;
    let mut reading = Reading {
        number: write(&mut number)?,
        entry: write(&mut entry)?,
        order: write(&mut order)?,
    };
    let sense = sense(clockwise);
    // Codes of 16-bit symbols, or of 32-bit symbols for larger disks.
    let state = if let Ok(code) = code.cast::<PyArray1<u16>>() {
        let mut code = code.try_readwrite()?;
        let code = write(&mut code)?;
        run(py, || {
            code::rooted_code(twin, n_quads, start, sense, code, &mut reading, best)
        })
    } else {
        let mut code: PyReadwriteArray1<i32> = code.extract()?;
        let code = write(&mut code)?;
        run(py, || {
            code::rooted_code(twin, n_quads, start, sense, code, &mut reading, best)
        })
    };
    Ok(state? as i8)
}

#[pyfunction]
fn clockwise_start(py: Python<'_>, twin: PyReadonlyArray1<'_, i32>, h: i32) -> PyResult<i32> {
    let twin = read(&twin)?;
    run(py, || code::clockwise_start(twin, h))
}

#[pyfunction]
fn smallest_code<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    n_quads: usize,
    starts: PyReadonlyArray1<'py, i32>,
    n_starts: usize,
    clockwise: bool,
    mut code: PyReadwriteArray1<'py, u16>,
    mut number: PyReadwriteArray1<'py, i32>,
    mut entry: PyReadwriteArray1<'py, i32>,
    mut order: PyReadwriteArray1<'py, i32>,
) -> PyResult<(i64, usize)> {
    let (twin, starts, code) = (read(&twin)?, read(&starts)?, write(&mut code)?);
    let mut reading = Reading {
        number: write(&mut number)?,
        entry: write(&mut entry)?,
        order: write(&mut order)?,
    };
    let sense = sense(clockwise);
    let (winner, ties) = run(py, || {
        let starts = &starts[..n_starts];
        code::smallest_code(twin, n_quads, starts, sense, code, &mut reading)
    })?;
    Ok((winner.map_or(-1, |place| place as i64), ties))
}

#[pyfunction]
fn code_starts<'py>(
    py: Python<'py>,
    twin: PyReadonlyArray1<'py, i32>,
    mut starts: PyReadwriteArray1<'py, i32>,
) -> PyResult<usize> {
    let (twin, starts) = (read(&twin)?, write(&mut starts)?);
    let found = run(py, || code::code_starts(twin))?;
    let Some(places) = starts.get_mut(..found.len()) else {
        return Err(PyValueError::new_err(format!(
            "starts has {} places, and there are {} starts",
            starts.len(),
            found.len()
        )));
    };
    places.copy_from_slice(&found);
    Ok(found.len())
}

#[pyfunction]
fn border_count(py: Python<'_>, twin: PyReadonlyArray1<'_, i32>, h: i32) -> PyResult<i32> {
    let twin = read(&twin)?;
    run(py, || code::border_count(twin, h))
}

#[pyfunction]
fn is_disk_code(py: Python<'_>, twin: PyReadonlyArray1<'_, i32>) -> PyResult<bool> {
    let twin = read(&twin)?;
    run(py, || code::is_disk_code(twin))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(rooted_code, module)?)?;
    module.add_function(wrap_pyfunction!(clockwise_start, module)?)?;
    module.add_function(wrap_pyfunction!(smallest_code, module)?)?;
    module.add_function(wrap_pyfunction!(code_starts, module)?)?;
    module.add_function(wrap_pyfunction!(border_count, module)?)?;
    module.add_function(wrap_pyfunction!(is_disk_code, module)?)
}
