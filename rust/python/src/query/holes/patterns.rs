//! `patterndb._native.query.holes.patterns`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray3};
use patterndb_query::holes::patterns::{self, Embedding, Tables};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

type EmbeddingArrays<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray2<i32>>,
);

fn from_embeddings<'py>(
    py: Python<'py>,
    embeddings: &[Embedding],
) -> PyResult<EmbeddingArrays<'py>> {
    fn column<T>(embeddings: &[Embedding], of: impl FnMut(&Embedding) -> T) -> Vec<T> {
        embeddings.iter().map(of).collect()
    }
    Ok((
        column(embeddings, |embedding| embedding.score).into_pyarray(py),
        column(embeddings, |embedding| embedding.pattern).into_pyarray(py),
        column(embeddings, |embedding| embedding.turn).into_pyarray(py),
        column(embeddings, |embedding| embedding.is_mirrored).into_pyarray(py),
        from_rows(py, column(embeddings, |embedding| embedding.widths))?,
    ))
}

#[pyfunction]
fn enumerate_embeddings<'py>(
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
) -> PyResult<EmbeddingArrays<'py>> {
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
    let embeddings = run(py, || {
        patterns::enumerate_embeddings(loss, n, &tables, most)
    })?;
    from_embeddings(py, &embeddings)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(enumerate_embeddings, module)?)
}
