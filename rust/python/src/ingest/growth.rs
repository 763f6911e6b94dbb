//! `patterndb._native.ingest.growth`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_ingest::growth::{self, Growth};
use patterndb_ingest::pulse::Pulse;
use pyo3::prelude::*;

use super::census::{BenchArrays, CensusArrays, MeshArrays, replace};
use super::pulse::share;
use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

type Grown<'py> = (
    i64,
    Bound<'py, PyArray2<u64>>,
    Bound<'py, PyArray2<u64>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyAny>,
);

#[pyfunction]
fn grow<'py>(
    py: Python<'py>,
    roots: PyReadonlyArray1<'py, i32>,
    limit: usize,
    convex: bool,
    smaller: usize,
    others: PyReadonlyArray2<'py, u64>,
    shard: PyReadonlyArray1<'py, i32>,
    mesh: MeshArrays<'py>,
    mut bench: BenchArrays<'py>,
    census: Bound<'py, PyAny>,
    pulse: Bound<'py, PyArray1<i64>>,
) -> PyResult<Grown<'py>> {
    let mut arrays: CensusArrays = census.extract()?;
    let (mesh, mut bench, mut tables) = (mesh.slices()?, bench.slices()?, arrays.slices()?);
    let [stop, met] = share(&pulse)?;
    let roots = read(&roots)?;
    let growth = Growth {
        limit,
        convex,
        smaller,
        others: read_rows(&others)?,
        shard: read(&shard)?,
    };
    let grown = run(py, || {
        let mut pulse = Pulse::new(stop, met);
        growth::grow(roots, growth, &mesh, &mut bench, &mut tables, &mut pulse)
    })?;
    Ok((
        grown.total,
        from_rows(py, grown.met)?,
        from_rows(py, grown.far_hash)?,
        grown.far_value.into_pyarray(py),
        replace(&census, tables)?,
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(grow, module)?)
}
