//! `patterndb._native.query.construct.parts`.

use numpy::{PyArray2, PyReadonlyArray1};
use patterndb_query::construct::parts;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::from_rows;

#[pyfunction]
fn find_pentagon_cuts<'py>(
    py: Python<'py>,
    lengths: PyReadonlyArray1<'py, i64>,
    counts: PyReadonlyArray1<'py, i64>,
    ample: i64,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let (lengths, counts) = (read(&lengths)?, read(&counts)?);
    let cuts = run(py, || parts::find_pentagon_cuts(lengths, counts, ample))?;
    let rows = cuts.iter();
    let rows = rows.map(|cut| [cut.side as i64, cut.before, cut.after, cut.chord]);
    from_rows(py, rows.collect())
}

#[pyfunction]
fn find_best_places(py: Python<'_>, gain: PyReadonlyArray1<'_, i64>) -> PyResult<(i64, i64, i64)> {
    let gain = read(&gain)?;
    let best = run(py, || parts::find_best_places(gain))?;
    Ok((best.gain, best.p, best.a))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(find_pentagon_cuts, module)?)?;
    module.add_function(wrap_pyfunction!(find_best_places, module)?)
}
