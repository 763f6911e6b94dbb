//! `patterndb._native.surfacing.chords.subcycles`.

use numpy::PyReadonlyArray2;
use patterndb_surfacing::chords::subcycles::Subcycles;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::read_rows;

#[pyfunction]
fn counted(py: Python<'_>, n: usize, chords: PyReadonlyArray2<'_, i64>) -> PyResult<i64> {
    let chords = read_rows(&chords)?;
    run(py, || Subcycles::new(n, chords).n_all)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(counted, module)?)
}
