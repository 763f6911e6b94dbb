//! `patterndb._native.query.families.growing`.

use numpy::{IntoPyArray, PyArray1};
use patterndb_query::families::growing::{self, Bounds};
use pyo3::prelude::*;

use crate::arrays::run;

/// Codes one after the other, and where each begins and the last ends.
type Codes<'py> = (Bound<'py, PyArray1<u16>>, Bound<'py, PyArray1<i64>>);

#[pyfunction]
fn grow_patterns<'py>(
    py: Python<'py>,
    most: i32,
    valence: i32,
    max_quads: usize,
) -> PyResult<Codes<'py>> {
    let bounds = Bounds {
        most,
        valence,
        max_quads,
    };
    let grown = run(py, || growing::grow_patterns(bounds))?;
    Ok((grown.flat.into_pyarray(py), grown.offsets.into_pyarray(py)))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(grow_patterns, module)?)
}
