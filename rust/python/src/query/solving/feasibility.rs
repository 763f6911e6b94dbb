//! `patterndb._native.query.solving.feasibility`.

use numpy::{
    PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, PyReadwriteArray2,
    PyUntypedArrayMethods,
};
use patterndb_query::solving::feasibility::{self, Patterns, Question};
use patterndb_query::solving::sieve::Sieve;
use pyo3::prelude::*;

use super::systems::SystemArrays;
use crate::arrays::{read, run};
use crate::flag::{CancelFlag, is_set};
use crate::rows::{read_all, write_all};

/// The Python class `FeasibilityQuery`.
#[derive(FromPyObject)]
struct QueryArrays<'py> {
    lengths: PyReadonlyArray2<'py, i32>,
    compared: PyReadonlyArray3<'py, i64>,
    marks: PyReadonlyArray1<'py, i64>,
    stated: PyReadonlyArray2<'py, i64>,
    kinds: PyReadonlyArray2<'py, i32>,
    lane: PyReadonlyArray1<'py, i32>,
    perimeter: i64,
    convex: bool,
}

impl QueryArrays<'_> {
    fn borrow<'a>(&'a self, systems: &'a SystemArrays) -> PyResult<Question<'a>> {
        let graphs = systems.graphs.borrow()?;
        Ok(Question {
            sieve: Sieve {
                pairs: read_all(&systems.pairs)?,
                surplus: read_all(&systems.surplus)?,
                claim: graphs.claim,
                marks: read(&self.marks)?.as_chunks().0,
                compared: read_all(&self.compared)?.as_chunks().0,
                stated: read_all(&self.stated)?.as_chunks().0,
                n_sides: graphs.n_sides,
            },
            lengths: read_all(&self.lengths)?,
            kinds: read_all(&self.kinds)?,
            n_corners: self.kinds.shape()[1],
            lane_of: read(&self.lane)?,
            perimeter: self.perimeter,
        })
    }
}

#[pyfunction]
fn mark<'py>(
    py: Python<'py>,
    systems: SystemArrays<'py>,
    query: QueryArrays<'py>,
    rows: PyReadonlyArray1<'py, i64>,
    signature: PyReadonlyArray1<'py, i32>,
    rotation: PyReadonlyArray1<'py, i32>,
    reflected: PyReadonlyArray1<'py, bool>,
    corners: PyReadonlyArray2<'py, u8>,
    every: bool,
    cancel: Bound<'py, PyArray1<u8>>,
    mut fits: PyReadwriteArray2<'py, bool>,
) -> PyResult<()> {
    let question = query.borrow(&systems)?;
    let systems = systems.borrow()?;
    let corners = read_all(&corners)?;
    let patterns = Patterns {
        rows: read(&rows)?,
        signature: read(&signature)?,
        rotation: read(&rotation)?,
        reflected: read(&reflected)?,
        corners: (!query.convex).then_some(corners),
    };
    let cancel = CancelFlag::new(cancel)?;
    let cancel = cancel.atomic();
    let fits = write_all(&mut fits)?;
    run(py, || {
        feasibility::mark(
            &systems,
            &question,
            &patterns,
            every,
            || is_set(cancel),
            fits,
        );
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(mark, module)?)
}
