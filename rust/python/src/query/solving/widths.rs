//! `patterndb._native.query.solving.widths`.

use numpy::{
    PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, PyReadwriteArray1,
    PyReadwriteArray2, PyReadwriteArray3, PyUntypedArrayMethods,
};
use patterndb_query::solving::widths::{self, Fits, Labels, WidthProblem};
use pyo3::prelude::*;

use crate::arrays::{read, run, write};
use crate::flag::{CancelFlag, is_set};
use crate::rows::{read_all, read_rows, write_all};

/// The Python class `Labels`.
#[derive(FromPyObject)]
struct LabelArrays<'py> {
    n_sides: usize,
    words: PyReadonlyArray1<'py, i16>,
    start: PyReadonlyArray1<'py, i64>,
}

impl LabelArrays<'_> {
    fn borrow(&self) -> PyResult<Labels<'_>> {
        Ok(Labels {
            n_sides: self.n_sides,
            words: read(&self.words)?,
            start: read(&self.start)?,
        })
    }
}

/// The Python class `WidthProblem`.
#[derive(FromPyObject)]
struct ProblemArrays<'py> {
    lengths: PyReadonlyArray2<'py, i32>,
    weights: PyReadonlyArray3<'py, i32>,
    strokes: PyReadonlyArray3<'py, i32>,
    tolerance: i32,
}

impl ProblemArrays<'_> {
    fn borrow(&self) -> PyResult<WidthProblem<'_>> {
        Ok(WidthProblem {
            lengths: read_all(&self.lengths)?,
            weights: read_all(&self.weights)?,
            strokes: read_rows(&self.strokes)?,
            tolerance: self.tolerance,
            n_sides: self.lengths.shape()[1],
        })
    }
}

#[pyfunction]
fn filter_stroke_feasible<'py>(
    py: Python<'py>,
    labels: LabelArrays<'py>,
    rows: PyReadonlyArray1<'py, i64>,
    mut allowed: PyReadwriteArray2<'py, bool>,
    problem: ProblemArrays<'py>,
    once: bool,
    cancelled: Bound<'py, PyArray1<u8>>,
) -> PyResult<()> {
    let (labels, problem) = (labels.borrow()?, problem.borrow()?);
    let (rows, allowed) = (read(&rows)?, write_all(&mut allowed)?);
    let cancelled = CancelFlag::new(cancelled)?;
    let cancelled = cancelled.atomic();
    run(py, || {
        widths::filter_stroke_feasible(
            &labels,
            rows,
            &problem,
            once,
            &|| is_set(cancelled),
            allowed,
        );
    })
}

/// Counts, keys and fits of some rows, to be written.
type FitArrays<'py> = (
    PyReadwriteArray1<'py, i64>,
    PyReadwriteArray2<'py, i64>,
    PyReadwriteArray3<'py, i32>,
);

#[pyfunction]
fn find_best_widths<'py>(
    py: Python<'py>,
    labels: LabelArrays<'py>,
    rows: PyReadonlyArray1<'py, i64>,
    allowed: PyReadonlyArray2<'py, bool>,
    problem: ProblemArrays<'py>,
    fits: FitArrays<'py>,
    cancelled: Bound<'py, PyArray1<u8>>,
) -> PyResult<()> {
    let (labels, problem) = (labels.borrow()?, problem.borrow()?);
    let (rows, allowed) = (read(&rows)?, read_all(&allowed)?);
    let (mut count, mut key, mut best) = fits;
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
        widths::find_best_widths(
            &labels,
            rows,
            allowed,
            &problem,
            &|| is_set(cancelled),
            &mut fits,
        );
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(filter_stroke_feasible, module)?)?;
    module.add_function(wrap_pyfunction!(find_best_widths, module)?)
}
