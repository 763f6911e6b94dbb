//! `patterndb._native.query.solving.feasibility`.

use numpy::{
    IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2,
    PyUntypedArrayMethods,
};
use patterndb_query::solving::feasibility::{self, Lanes, Patterns};
use patterndb_query::solving::sieve::{self, Claims, Sieve};
use pyo3::prelude::*;

use super::systems::SystemArrays;
use crate::arrays::{read, run};
use crate::flag::{CancelFlag, is_set};
use crate::rows::{read_all, write_all};

/// The Python class `Lanes`.
#[derive(FromPyObject)]
struct LaneArrays<'py> {
    lengths: PyReadonlyArray2<'py, i32>,
    lane_of: PyReadonlyArray1<'py, i32>,
    marks: PyReadonlyArray1<'py, i64>,
    compared: PyReadonlyArray1<'py, i64>,
}

impl LaneArrays<'_> {
    /// Borrow the arrays; `stated` is what [`state_claims`] wrote.
    fn borrow<'a>(
        &'a self,
        systems: &'a SystemArrays,
        stated: &'a PyReadonlyArray2<'_, i64>,
    ) -> PyResult<Lanes<'a>> {
        let graphs = systems.borrow()?.graphs;
        Ok(Lanes {
            sieve: Sieve {
                pairs: read_all(&systems.pairs)?,
                surplus: read_all(&systems.surplus)?,
                claim: graphs.claim,
                marks: read(&self.marks)?.as_chunks().0,
                compared: read(&self.compared)?.as_chunks().0,
                stated: read_all(stated)?.as_chunks().0,
                n_sides: graphs.n_sides,
            },
            lengths: read_all(&self.lengths)?,
            lane_of: read(&self.lane_of)?,
        })
    }
}

/// Marks, and compared lengths.
type Packed<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>);

#[pyfunction]
fn pack_lengths<'py>(
    py: Python<'py>,
    lengths: PyReadonlyArray2<'py, i32>,
) -> PyResult<Packed<'py>> {
    let n_sides = lengths.shape()[1];
    let lengths = read_all(&lengths)?;
    let packed = run(py, || sieve::pack_lengths(lengths, n_sides))?;
    Ok((
        packed.marks.into_pyarray(py),
        packed.compared.into_pyarray(py),
    ))
}

#[pyfunction]
fn state_claims<'py>(
    py: Python<'py>,
    systems: SystemArrays<'py>,
    lengths: PyReadonlyArray2<'py, i32>,
    claims: PyReadonlyArray1<'py, i32>,
    first: usize,
    mut stated: PyReadwriteArray2<'py, u8>,
) -> PyResult<()> {
    let graphs = systems.borrow()?.graphs;
    let of_class = Claims {
        lengths: read_all(&lengths)?,
        n_lanes: lengths.shape()[1],
        claimant: read(&systems.claimant)?,
        near_first: graphs.near_first,
        near: graphs.near,
    };
    let claims = read(&claims)?;
    let width = stated.shape()[1];
    let stated = write_all(&mut stated)?;
    run(py, || {
        sieve::state_claims(&of_class, claims, first, stated, width)
    })
}

/// The Python class `PatternRows`.
#[derive(FromPyObject)]
struct PatternArrays<'py> {
    rows: PyReadonlyArray1<'py, i64>,
    signature: PyReadonlyArray1<'py, i32>,
    rotation: PyReadonlyArray1<'py, i32>,
    reflected: PyReadonlyArray1<'py, bool>,
    allowed: PyReadonlyArray2<'py, u8>,
}

#[pyfunction]
fn mark<'py>(
    py: Python<'py>,
    systems: SystemArrays<'py>,
    lanes: LaneArrays<'py>,
    stated: PyReadonlyArray2<'py, i64>,
    patterns: PatternArrays<'py>,
    cancelled: Bound<'py, PyArray1<u8>>,
    mut fits: PyReadwriteArray2<'py, bool>,
) -> PyResult<()> {
    let lanes = lanes.borrow(&systems, &stated)?;
    let systems = systems.borrow()?;
    let patterns = Patterns {
        rows: read(&patterns.rows)?,
        signature: read(&patterns.signature)?,
        rotation: read(&patterns.rotation)?,
        reflected: read(&patterns.reflected)?,
        allowed: read_all(&patterns.allowed)?,
    };
    let cancelled = CancelFlag::new(cancelled)?;
    let cancelled = cancelled.atomic();
    let once = fits.shape()[1] == 1;
    let fits = write_all(&mut fits)?;
    run(py, || {
        feasibility::mark(
            &systems,
            &lanes,
            &patterns,
            once,
            || is_set(cancelled),
            fits,
        );
    })
}

#[pyfunction]
fn sift_systems<'py>(
    py: Python<'py>,
    systems: SystemArrays<'py>,
    lanes: LaneArrays<'py>,
    stated: PyReadonlyArray2<'py, i64>,
    mut passing: PyReadwriteArray2<'py, bool>,
) -> PyResult<()> {
    let n_lanes = passing.shape()[1];
    let sieve = lanes.borrow(&systems, &stated)?.sieve;
    let passing = write_all(&mut passing)?;
    run(py, || {
        let mut left = vec![[0; sieve::GROUP]; sieve.marks.len()];
        for (row, passing) in passing.chunks_exact_mut(n_lanes).enumerate() {
            sieve.sift(row, &mut left);
            for (lane, passes) in passing.iter_mut().enumerate() {
                *passes = sieve::has_lane(&left, lane);
            }
        }
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(mark, module)?)?;
    module.add_function(wrap_pyfunction!(pack_lengths, module)?)?;
    module.add_function(wrap_pyfunction!(sift_systems, module)?)?;
    module.add_function(wrap_pyfunction!(state_claims, module)?)
}
