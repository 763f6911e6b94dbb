//! `patterndb._native.query.solving.batch`.

use numpy::{
    PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, PyReadwriteArray1,
    PyReadwriteArray2, PyReadwriteArray3, PyUntypedArrayMethods,
};
use patterndb_query::solving::batch::{self, Fits, Labels, Question};
use pyo3::prelude::*;

use crate::arrays::{read, run, write};
use crate::flag::{CancelFlag, is_set};
use crate::rows::{read_all, read_rows, write_all};

#[pyfunction]
fn keep_carrying<'py>(
    py: Python<'py>,
    words: PyReadonlyArray1<'py, i16>,
    start: PyReadonlyArray1<'py, i64>,
    rows: PyReadonlyArray1<'py, i64>,
    mut allowed: PyReadwriteArray2<'py, bool>,
    lengths: PyReadonlyArray2<'py, i32>,
    weights: PyReadonlyArray3<'py, i32>,
    flows: PyReadonlyArray3<'py, i32>,
    tolerance: i32,
    cancelled: Bound<'py, PyArray1<u8>>,
    once: bool,
) -> PyResult<()> {
    let n_sides = lengths.shape()[1];
    let labels = Labels {
        n_sides,
        words: read(&words)?,
        start: read(&start)?,
    };
    let question = Question {
        lengths: read_all(&lengths)?,
        weights: read_all(&weights)?,
        strokes: read_rows(&flows)?,
        tolerance,
        n_sides,
    };
    let (rows, allowed) = (read(&rows)?, write_all(&mut allowed)?);
    let cancelled = CancelFlag::new(cancelled)?;
    let cancelled = cancelled.atomic();
    run(py, || {
        batch::keep_carrying(
            &labels,
            rows,
            &question,
            once,
            &|| is_set(cancelled),
            allowed,
        );
    })
}

#[pyfunction]
fn solve_rows<'py>(
    py: Python<'py>,
    words: PyReadonlyArray1<'py, i16>,
    start: PyReadonlyArray1<'py, i64>,
    rows: PyReadonlyArray1<'py, i64>,
    allowed: PyReadonlyArray2<'py, bool>,
    lengths: PyReadonlyArray2<'py, i32>,
    weights: PyReadonlyArray3<'py, i32>,
    flows: PyReadonlyArray3<'py, i32>,
    tolerance: i32,
    mut count: PyReadwriteArray1<'py, i64>,
    mut key: PyReadwriteArray2<'py, i64>,
    mut best: PyReadwriteArray3<'py, i32>,
    cancelled: Bound<'py, PyArray1<u8>>,
) -> PyResult<()> {
    let n_sides = lengths.shape()[1];
    let labels = Labels {
        n_sides,
        words: read(&words)?,
        start: read(&start)?,
    };
    let question = Question {
        lengths: read_all(&lengths)?,
        weights: read_all(&weights)?,
        strokes: read_rows(&flows)?,
        tolerance,
        n_sides,
    };
    let (rows, allowed) = (read(&rows)?, read_all(&allowed)?);
    let keep = key.shape()[1];
    let mut fits = Fits {
        count: write(&mut count)?,
        key: write_all(&mut key)?,
        best: write_all(&mut best)?,
        keep,
    };
    let cancelled = CancelFlag::new(cancelled)?;
    let cancelled = cancelled.atomic();
    run(py, || {
        batch::solve_rows(
            &labels,
            rows,
            allowed,
            &question,
            &|| is_set(cancelled),
            &mut fits,
        );
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(keep_carrying, module)?)?;
    module.add_function(wrap_pyfunction!(solve_rows, module)?)
}
