//! `patterndb._native.query.solving.matching`.

use numpy::{
    PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2, PyUntypedArrayMethods,
};
use patterndb_query::solving::graphs::{Graphs, Square};
use patterndb_query::solving::halves::{Class, Scratch};
use patterndb_query::solving::matching::{self, Verdict};
use pyo3::prelude::*;

use super::list_classes;
use crate::arrays::{read, run};
use crate::rows::{from_table, read_all, write_all};

#[pyfunction]
fn is_matchable<'py>(
    py: Python<'py>,
    slack: PyReadonlyArray1<'py, i32>,
    row: usize,
    first: PyReadonlyArray1<'py, i32>,
    class_i: PyReadonlyArray1<'py, i16>,
    class_j: PyReadonlyArray1<'py, i16>,
    claim: PyReadonlyArray2<'py, i32>,
    near_first: PyReadonlyArray1<'py, i32>,
    near: PyReadonlyArray1<'py, i16>,
    mut flow: PyReadwriteArray2<'py, i32>,
    mut scratch: PyReadwriteArray2<'py, i32>,
) -> PyResult<i64> {
    let n_sides = claim.shape()[1];
    let graphs = Graphs {
        first: read(&first)?,
        class_i: read(&class_i)?,
        class_j: read(&class_j)?,
        claim: read_all(&claim)?,
        near_first: read(&near_first)?,
        near: read(&near)?,
        n_sides,
    };
    let (slack, flow) = (read(&slack)?, write_all(&mut flow)?);
    let scratch = write_all(&mut scratch)?;
    run(py, || {
        let mut made = Square::from_items(n_sides, flow);
        let mut reached = Scratch::new(n_sides);
        let verdict = matching::decide(slack, &graphs.graph(row), &mut made, &mut reached);
        flow.copy_from_slice(made.items());
        match verdict {
            Verdict::Matchable => 0,
            Verdict::Halves => -1,
            Verdict::Cut => {
                let rows: Vec<&mut [i32]> = scratch.chunks_exact_mut(n_sides).collect();
                // COPY_BY and QUEUE of the Python module `query.solving.halves`.
                let [_, _, _, copy_by, queue] = rows.try_into().expect("scratch has five rows");
                for (place, &side) in queue.iter_mut().zip(reached.cut()) {
                    *place = side as i32;
                }
                for (side, place) in copy_by.iter_mut().enumerate() {
                    *place = if reached.is_near_cut(side) { 0 } else { -1 };
                }
                reached.cut().len() as i64
            }
        }
    })
}

#[pyfunction]
fn is_soluble<'py>(
    py: Python<'py>,
    slack: PyReadonlyArray1<'py, i32>,
    class_i: PyReadonlyArray1<'py, i32>,
    class_j: PyReadonlyArray1<'py, i32>,
    n_classes: usize,
    closed: PyReadonlyArray1<'py, bool>,
) -> PyResult<bool> {
    let (class_i, class_j) = (read(&class_i)?, read(&class_j)?);
    let classes = list_classes(class_i, class_j, &vec![1; n_classes]);
    let (slack, closed) = (read(&slack)?, read(&closed)?);
    run(py, || {
        let open = classes.iter().zip(closed).filter(|(_, closed)| !**closed);
        let open: Vec<Class> = open.map(|(class, _)| *class).collect();
        matching::is_soluble(slack, &open)
    })
}

#[pyfunction]
fn count_splits(py: Python<'_>, value: i64, parts: i64) -> PyResult<i64> {
    run(py, || matching::count_splits(value, parts))
}

#[pyfunction]
fn search_matchings<'py>(
    py: Python<'py>,
    slack: PyReadonlyArray1<'py, i32>,
    class_i: PyReadonlyArray1<'py, i32>,
    class_j: PyReadonlyArray1<'py, i32>,
    class_n: PyReadonlyArray1<'py, i32>,
    limit: i64,
) -> PyResult<(Bound<'py, PyArray2<i32>>, i64)> {
    let slack = read(&slack)?;
    let classes = list_classes(read(&class_i)?, read(&class_j)?, read(&class_n)?);
    let m = classes.len();
    let found = run(py, || matching::search_matchings(slack, &classes, limit))?;
    let rows = from_table(py, found.rows.len() / m.max(1), m, found.rows)?;
    Ok((rows, found.n_widths))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(count_splits, module)?)?;
    module.add_function(wrap_pyfunction!(is_matchable, module)?)?;
    module.add_function(wrap_pyfunction!(is_soluble, module)?)?;
    module.add_function(wrap_pyfunction!(search_matchings, module)?)
}
