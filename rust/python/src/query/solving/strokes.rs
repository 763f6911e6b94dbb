//! `patterndb._native.query.solving.strokes`.

use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_query::solving::evenness::Best;
use patterndb_query::solving::strokes::{self, Label, Wish};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_table, read_rows};

fn label(edges: &[i32], side_start: &[i32]) -> Label {
    let places = |items: &[i32]| items.iter().map(|&item| item as usize).collect();
    Label::of_edges(places(edges), places(side_start))
}

#[pyfunction]
fn can_carry<'py>(
    py: Python<'py>,
    edges: PyReadonlyArray1<'py, i32>,
    side_start: PyReadonlyArray1<'py, i32>,
    lengths: PyReadonlyArray1<'py, i32>,
    flow: PyReadonlyArray2<'py, i32>,
    tolerance: i32,
) -> PyResult<bool> {
    let (edges, side_start) = (read(&edges)?, read(&side_start)?);
    let (lengths, strokes) = (read(&lengths)?, read_rows(&flow)?);
    run(py, || {
        let wish = Wish {
            lengths,
            weights: &vec![1; lengths.len() * lengths.len()],
            strokes,
            tolerance,
        };
        strokes::can_carry(&label(edges, side_start), &wish, &|| false)
    })
}

#[pyfunction]
fn find_carrying_widths<'py>(
    py: Python<'py>,
    edges: PyReadonlyArray1<'py, i32>,
    side_start: PyReadonlyArray1<'py, i32>,
    lengths: PyReadonlyArray1<'py, i32>,
    flow: PyReadonlyArray2<'py, i32>,
    tolerance: i32,
    keep: usize,
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    let (edges, side_start) = (read(&edges)?, read(&side_start)?);
    let (lengths, strokes) = (read(&lengths)?, read_rows(&flow)?);
    let best = run(py, || {
        let wish = Wish {
            lengths,
            weights: &vec![1; lengths.len() * lengths.len()],
            strokes,
            tolerance,
        };
        let mut best = Best {
            keep,
            ..Best::default()
        };
        strokes::carry_strokes(&label(edges, side_start), &wish, 0, &mut best, &|| false);
        best
    })?;
    let n = best.solutions.len();
    let widths = best.solutions.into_iter();
    from_table(
        py,
        n,
        edges.len() / 2,
        widths.flat_map(|solution| solution.widths).collect(),
    )
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(can_carry, module)?)?;
    module.add_function(wrap_pyfunction!(find_carrying_widths, module)?)
}
