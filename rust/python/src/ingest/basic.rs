//! `patterndb._native.ingest.basic`.

use numpy::PyArray1;
use patterndb_ingest::basic;
use patterndb_ingest::pulse::Pulse;
use pyo3::prelude::*;

use super::census::{BenchArrays, CensusArrays, MeshArrays, replace};
use super::pulse::share;
use crate::arrays::run;

#[pyfunction]
fn count_basic<'py>(
    py: Python<'py>,
    first: i32,
    last: i32,
    limit: usize,
    mesh: MeshArrays<'py>,
    mut bench: BenchArrays<'py>,
    census: Bound<'py, PyAny>,
    pulse: Bound<'py, PyArray1<i64>>,
) -> PyResult<(i64, Bound<'py, PyAny>)> {
    let mut arrays: CensusArrays = census.extract()?;
    let (mesh, mut bench, mut tables) = (mesh.slices()?, bench.slices()?, arrays.slices()?);
    let [stop, met] = share(&pulse)?;
    let total = run(py, || {
        let mut pulse = Pulse::new(stop, met);
        basic::count_basic(
            first..last,
            limit,
            &mesh,
            &mut bench,
            &mut tables,
            &mut pulse,
        )
    })?;
    Ok((total, replace(&census, tables)?))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(count_basic, module)?)
}
