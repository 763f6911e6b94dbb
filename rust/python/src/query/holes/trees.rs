//! `patterndb._native.query.holes.trees`.

use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use patterndb_query::holes::trees::Trees;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_table, read_all};

#[pyfunction]
fn score_trees<'py>(
    py: Python<'py>,
    features: PyReadonlyArray2<'py, f64>,
    start: PyReadonlyArray1<'py, i32>,
    feature: PyReadonlyArray1<'py, i16>,
    threshold: PyReadonlyArray1<'py, f32>,
    child: PyReadonlyArray1<'py, i16>,
    value: PyReadonlyArray1<'py, f32>,
    base: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let &[n_rows, n_features] = features.shape() else {
        unreachable!("an array of two axes")
    };
    let trees = Trees {
        start: read(&start)?,
        feature: read(&feature)?,
        threshold: read(&threshold)?,
        child: read(&child)?,
        value: read(&value)?,
        base: read(&base)?,
    };
    let rows = read_all(&features)?;
    let scores = run(py, || trees.score(rows, n_features))?;
    from_table(py, n_rows, trees.base.len(), scores)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(score_trees, module)?)
}
