//! `patterndb._native.core.reduction`.

use numpy::{PyArray1, PyReadonlyArray1, PyReadwriteArray1};
use patterndb_core::reduction::{self, Disk, ReductionWork};
use pyo3::prelude::*;

use crate::arrays::{read, run, write};

/// The arrays of a `ReductionWork` of Python.
#[derive(FromPyObject)]
pub struct WorkArrays<'py> {
    gone: PyReadwriteArray1<'py, i64>,
    seen: PyReadwriteArray1<'py, i64>,
    stamp: PyReadwriteArray1<'py, i64>,
    border: PyReadwriteArray1<'py, i32>,
    block: PyReadwriteArray1<'py, i32>,
    head: PyReadwriteArray1<'py, i32>,
    reduced: PyReadwriteArray1<'py, i32>,
    starts: PyReadwriteArray1<'py, i32>,
}

impl WorkArrays<'_> {
    pub fn slices(&mut self) -> PyResult<ReductionWork<'_>> {
        Ok(ReductionWork {
            gone: write(&mut self.gone)?,
            seen: write(&mut self.seen)?,
            stamp: write(&mut self.stamp)?,
            border: write(&mut self.border)?,
            block: write(&mut self.block)?,
            head: write(&mut self.head)?,
            reduced: write(&mut self.reduced)?,
            starts: write(&mut self.starts)?,
        })
    }
}

#[pyfunction]
pub fn reduction_work(
    py: Python<'_>,
    n_vertices: usize,
    max_quads: usize,
) -> PyResult<Bound<'_, PyAny>> {
    let stamps = |n: usize| PyArray1::<i64>::zeros(py, n, false);
    let sides = || PyArray1::<i32>::zeros(py, 4 * max_quads, false);
    let block = PyArray1::from_vec(py, vec![-1_i32; 4 * max_quads]);
    py.import("patterndb.core.reduction")?
        .getattr("ReductionWork")?
        .call1((
            stamps(n_vertices),
            stamps(n_vertices),
            stamps(2),
            sides(),
            block,
            sides(),
            sides(),
            sides(),
        ))
}

/// The arguments of a reduction.
struct Arguments<'py> {
    n_quads: usize,
    twin: PyReadonlyArray1<'py, i32>,
    vertex: PyReadonlyArray1<'py, i32>,
    count: PyReadonlyArray1<'py, i32>,
    full: PyReadonlyArray1<'py, i32>,
    work: WorkArrays<'py>,
}

impl Arguments<'_> {
    fn run(
        mut self,
        py: Python<'_>,
        reduce: fn(Disk, &mut ReductionWork) -> (usize, usize),
    ) -> PyResult<(usize, usize)> {
        let (twin, vertex) = (read(&self.twin)?, read(&self.vertex)?);
        let (count, full) = (read(&self.count)?, read(&self.full)?);
        let mut work = self.work.slices()?;
        run(py, || {
            let disk = Disk {
                twin: &twin[..4 * self.n_quads],
                vertex: &vertex[..4 * self.n_quads],
                count,
                full,
            };
            reduce(disk, &mut work)
        })
    }
}

#[pyfunction]
fn dissolve<'py>(
    py: Python<'py>,
    n_quads: usize,
    twin: PyReadonlyArray1<'py, i32>,
    vertex: PyReadonlyArray1<'py, i32>,
    count: PyReadonlyArray1<'py, i32>,
    full: PyReadonlyArray1<'py, i32>,
    work: WorkArrays<'py>,
) -> PyResult<(usize, usize)> {
    let arguments = Arguments {
        n_quads,
        twin,
        vertex,
        count,
        full,
        work,
    };
    arguments.run(py, reduction::dissolve)
}

#[pyfunction]
fn dissolve_straight<'py>(
    py: Python<'py>,
    n_quads: usize,
    twin: PyReadonlyArray1<'py, i32>,
    vertex: PyReadonlyArray1<'py, i32>,
    count: PyReadonlyArray1<'py, i32>,
    full: PyReadonlyArray1<'py, i32>,
    work: WorkArrays<'py>,
) -> PyResult<(usize, usize)> {
    let arguments = Arguments {
        n_quads,
        twin,
        vertex,
        count,
        full,
        work,
    };
    arguments.run(py, reduction::dissolve_straight)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(reduction_work, module)?)?;
    module.add_function(wrap_pyfunction!(dissolve, module)?)?;
    module.add_function(wrap_pyfunction!(dissolve_straight, module)?)
}
