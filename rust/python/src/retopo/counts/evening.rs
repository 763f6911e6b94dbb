//! `patterndb._native.retopo.counts.evening`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use patterndb_retopo::counts::evening::{self, Sides};
use pyo3::prelude::*;

use crate::arrays::{read, run};

#[pyfunction]
fn tie_sides<'py>(
    py: Python<'py>,
    first_side: PyReadonlyArray1<'py, i32>,
    first_chain: PyReadonlyArray1<'py, i32>,
    chains: PyReadonlyArray1<'py, i32>,
    pinned: PyReadonlyArray1<'py, i32>,
    least: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let sides = Sides {
        first_side: read(&first_side)?,
        first_chain: read(&first_chain)?,
        chains: read(&chains)?,
    };
    let (pinned, least) = (read(&pinned)?, read(&least)?);
    let strips = run(py, || evening::tie_sides(sides, pinned, least))?;
    Ok(strips.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(tie_sides, module)?)
}
