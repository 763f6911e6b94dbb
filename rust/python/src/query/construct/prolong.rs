//! `patterndb._native.query.construct.prolong`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use patterndb_query::construct::prolong;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::from_rows;

/// Cuts as rows, and guesses of their irregular vertices.
type Cuts<'py> = (Bound<'py, PyArray2<i64>>, Bound<'py, PyArray1<f64>>);

#[pyfunction]
fn list_prolongations<'py>(
    py: Python<'py>,
    lengths: PyReadonlyArray1<'py, i64>,
    counts: PyReadonlyArray1<'py, i64>,
    most_perimeter: i64,
) -> PyResult<Cuts<'py>> {
    let (lengths, counts) = (read(&lengths)?, read(&counts)?);
    let cuts = run(py, || {
        prolong::list_prolongations(lengths, counts, most_perimeter)
    })?;
    let rows = cuts.iter().map(|cut| {
        let (corner, far) = (cut.corner as i64, cut.far as i64);
        [corner, cut.back.into(), far, cut.place, cut.length]
    });
    let guesses: Vec<f64> = cuts.iter().map(|cut| cut.guess).collect();
    Ok((from_rows(py, rows.collect())?, guesses.into_pyarray(py)))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(list_prolongations, module)?)
}
