//! `patterndb._native.retopo.counts.walks`.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1, PyReadwriteArray2};
use patterndb_retopo::counts::walks::{self, Halves, WalkGraph};
use pyo3::prelude::*;

use crate::arrays::{read, run, write};
use crate::rows::{read_rows, write_rows};

/// The arrays of a `WalkGraph` of Python that no kernel writes to.
#[derive(FromPyObject)]
struct HalfArrays<'py> {
    chain: PyReadonlyArray1<'py, i32>,
    patch: PyReadonlyArray1<'py, i32>,
    side: PyReadonlyArray1<'py, i32>,
    place: PyReadonlyArray1<'py, i32>,
    twin: PyReadonlyArray1<'py, i32>,
    first_half: PyReadonlyArray1<'py, i32>,
    first_side: PyReadonlyArray1<'py, i32>,
    first_after: PyReadonlyArray1<'py, i64>,
}

impl HalfArrays<'_> {
    fn borrow(&self) -> PyResult<Halves<'_>> {
        Ok(Halves {
            chain: read(&self.chain)?,
            patch: read(&self.patch)?,
            side: read(&self.side)?,
            place: read(&self.place)?,
            twin: read(&self.twin)?,
            first_half: read(&self.first_half)?,
            first_side: read(&self.first_side)?,
            first_after: read(&self.first_after)?,
        })
    }
}

/// The tables of a `WalkGraph` of Python, to write to.
#[derive(FromPyObject)]
struct JudgedArrays<'py> {
    after: PyReadwriteArray1<'py, i8>,
    state: PyReadwriteArray1<'py, i8>,
}

/// The tables and costs of a `WalkGraph` of Python, to read.
#[derive(FromPyObject)]
struct CostArrays<'py> {
    after: PyReadonlyArray1<'py, i8>,
    state: PyReadonlyArray1<'py, i8>,
    step: PyReadonlyArray2<'py, f64>,
}

#[pyfunction]
fn judge_patches<'py>(
    py: Python<'py>,
    graph: Bound<'py, PyAny>,
    lengths: PyReadonlyArray1<'py, i32>,
    patches: PyReadonlyArray1<'py, i32>,
) -> PyResult<()> {
    let halves: HalfArrays = graph.extract()?;
    let mut judged: JudgedArrays = graph.extract()?;
    let halves = halves.borrow()?;
    let (lengths, patches) = (read(&lengths)?, read(&patches)?);
    let (state, after) = (write(&mut judged.state)?, write(&mut judged.after)?);
    run(py, || {
        walks::judge_patches(&halves, lengths, patches, state, after)
    })
}

#[pyfunction]
fn find_walk<'py>(
    py: Python<'py>,
    graph: Bound<'py, PyAny>,
    starts: PyReadonlyArray1<'py, i32>,
    begin: usize,
    most_steps: usize,
    regularity: f64,
    mut walk: PyReadwriteArray2<'py, i32>,
) -> PyResult<(usize, usize, f64)> {
    let halves: HalfArrays = graph.extract()?;
    let costs: CostArrays = graph.extract()?;
    let graph = WalkGraph {
        halves: halves.borrow()?,
        after: read(&costs.after)?,
        state: read(&costs.state)?,
        step: read_rows(&costs.step)?,
        regularity,
    };
    let (starts, walk) = (read(&starts)?, write_rows(&mut walk)?);
    run(py, || {
        walks::find_walk(&graph, starts, begin, most_steps, walk)
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(judge_patches, module)?)?;
    module.add_function(wrap_pyfunction!(find_walk, module)?)
}
