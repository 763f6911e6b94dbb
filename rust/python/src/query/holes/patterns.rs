//! `patterndb._native.query.holes.patterns`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray3};
use patterndb_query::holes::patterns::{self, Lie, Tables};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

type LieArrays<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray2<i32>>,
);

fn from_lies<'py>(py: Python<'py>, lies: &[Lie]) -> PyResult<LieArrays<'py>> {
    fn column<T>(lies: &[Lie], of: impl FnMut(&Lie) -> T) -> Vec<T> {
        lies.iter().map(of).collect()
    }
    Ok((
        column(lies, |lie| lie.score).into_pyarray(py),
        column(lies, |lie| lie.pattern).into_pyarray(py),
        column(lies, |lie| lie.turn).into_pyarray(py),
        column(lies, |lie| lie.is_mirrored).into_pyarray(py),
        from_rows(py, column(lies, |lie| lie.widths))?,
    ))
}

#[pyfunction]
fn find_lies<'py>(
    py: Python<'py>,
    loss: PyReadonlyArray3<'py, f64>,
    n: usize,
    first_side: PyReadonlyArray1<'py, i32>,
    corner: PyReadonlyArray1<'py, i32>,
    first_edge: PyReadonlyArray1<'py, i32>,
    chord: PyReadonlyArray1<'py, i32>,
    n_chords: PyReadonlyArray1<'py, i32>,
    chiral: PyReadonlyArray1<'py, bool>,
    prior: PyReadonlyArray1<'py, f64>,
    most: usize,
) -> PyResult<LieArrays<'py>> {
    let tables = Tables {
        first_side: read(&first_side)?,
        corner: read(&corner)?,
        first_edge: read(&first_edge)?,
        chord: read(&chord)?,
        n_chords: read(&n_chords)?,
        chiral: read(&chiral)?,
        prior: read(&prior)?,
    };
    let loss = read_rows(&loss)?;
    let lies = run(py, || patterns::find_lies(loss, n, &tables, most))?;
    from_lies(py, &lies)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(find_lies, module)?)
}
