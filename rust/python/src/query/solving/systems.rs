//! `patterndb._native.query.solving.systems`.

use numpy::{
    IntoPyArray, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods,
};
use patterndb_query::solving::fractional_matching::{Scratch, Square};
use patterndb_query::solving::hall_conditions::{MOST_SIDES, Sums, list_hall_conditions};
use patterndb_query::solving::matching::{Verdict, decide};
use patterndb_query::solving::sieve;
use patterndb_query::solving::systems::{self, Graphs, Systems};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{read, run};
use crate::rows::{from_table, read_all};

/// The Python class `Systems`.
#[derive(FromPyObject)]
pub struct SystemArrays<'py> {
    first: PyReadonlyArray1<'py, i32>,
    class_i: PyReadonlyArray1<'py, i16>,
    class_j: PyReadonlyArray1<'py, i16>,
    claim: PyReadonlyArray2<'py, i32>,
    pub claimant: PyReadonlyArray1<'py, i16>,
    near_first: PyReadonlyArray1<'py, i32>,
    near: PyReadonlyArray1<'py, i16>,
    base: PyReadonlyArray2<'py, i16>,
    pub pairs: PyReadonlyArray2<'py, u8>,
    perimeter: PyReadonlyArray1<'py, i32>,
    pub surplus: PyReadonlyArray2<'py, u8>,
    component: PyReadonlyArray2<'py, i16>,
    colour: PyReadonlyArray2<'py, i16>,
    parity: PyReadonlyArray1<'py, bool>,
    graph: PyReadonlyArray1<'py, i32>,
    hall_first: PyReadonlyArray1<'py, i32>,
    hall: PyReadonlyArray1<'py, i32>,
}

impl SystemArrays<'_> {
    /// Borrow the arrays.
    pub fn borrow(&self) -> PyResult<Systems<'_>> {
        Ok(Systems {
            graphs: Graphs {
                first: read(&self.first)?,
                class_i: read(&self.class_i)?,
                class_j: read(&self.class_j)?,
                claim: read_all(&self.claim)?,
                near_first: read(&self.near_first)?,
                near: read(&self.near)?,
                n_sides: self.claim.shape()[1],
            },
            base: read_all(&self.base)?,
            perimeter: read(&self.perimeter)?,
            component: read_all(&self.component)?,
            colour: read_all(&self.colour)?,
            parity: read(&self.parity)?,
            graph: read(&self.graph)?,
            hall_first: read(&self.hall_first)?,
            hall: read(&self.hall)?,
        })
    }
}

#[pyfunction]
fn list_systems<'py>(
    py: Python<'py>,
    base: PyReadonlyArray2<'py, i16>,
    joined: PyReadonlyArray3<'py, bool>,
    with_hall: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let (n, w) = (joined.shape()[0], joined.shape()[1]);
    let (base, joined) = (read_all(&base)?, read_all(&joined)?);
    let (claims, classes, pairs, hall) = run(py, || {
        let claims = systems::number_claims(joined, w);
        let hall = (with_hall && w <= MOST_SIDES)
            .then(|| list_hall_conditions(&claims.claim, w, &claims.near_first, &claims.near));
        let classes = systems::list_classes(base, joined, w);
        (claims, classes, sieve::pair_sides(base, w), hall)
    })?;
    let made = PyDict::new(py);
    made.set_item("first", classes.first.into_pyarray(py))?;
    made.set_item("class_i", classes.class_i.into_pyarray(py))?;
    made.set_item("class_j", classes.class_j.into_pyarray(py))?;
    made.set_item("claim", from_table(py, n, w, claims.claim)?)?;
    made.set_item("claimant", claims.claimant.into_pyarray(py))?;
    made.set_item("near_first", claims.near_first.into_pyarray(py))?;
    made.set_item("near", claims.near.into_pyarray(py))?;
    made.set_item("pairs", from_table(py, n, w.div_ceil(2), pairs)?)?;
    made.set_item("surplus", from_table(py, n, w, classes.surplus)?)?;
    made.set_item("component", from_table(py, n, w, classes.component)?)?;
    made.set_item("colour", from_table(py, n, w, classes.colour)?)?;
    made.set_item("parity", classes.parity.into_pyarray(py))?;
    // Without conditions, all systems have one graph that has none.
    let (graph, first, conditions) = match hall {
        Some(hall) => (hall.graph, hall.first, hall.conditions),
        None => (vec![0; n], vec![0, 0], Vec::new()),
    };
    made.set_item("graph", graph.into_pyarray(py))?;
    made.set_item("hall_first", first.into_pyarray(py))?;
    made.set_item("hall", conditions.into_pyarray(py))?;
    Ok(made)
}

#[pyfunction]
fn breaks_hall_condition(
    py: Python<'_>,
    systems: SystemArrays<'_>,
    row: usize,
    need: PyReadonlyArray1<'_, i32>,
) -> PyResult<bool> {
    let (systems, need) = (systems.borrow()?, read(&need)?);
    if need.len() > MOST_SIDES {
        let wrong = format!("{} sides are more than {MOST_SIDES}", need.len());
        return Err(PyValueError::new_err(wrong));
    }
    run(py, || {
        let mut padded = [0; MOST_SIDES];
        padded[..need.len()].copy_from_slice(need);
        let mut sums = Sums::default();
        sums.fill(&padded);
        let graph = systems.graph[row] as usize;
        let [first, last] = [graph, graph + 1].map(|at| systems.hall_first[at] as usize);
        sums.break_any(&systems.hall[first..last])
    })
}

/// Whether there is a matching, and the sides of the cut.
type Decision = (bool, Vec<usize>);

#[pyfunction]
fn decide_matching(
    py: Python<'_>,
    systems: SystemArrays<'_>,
    row: usize,
    slack: PyReadonlyArray1<'_, i32>,
) -> PyResult<Decision> {
    let (systems, slack) = (systems.borrow()?, read(&slack)?);
    let n = systems.graphs.n_sides;
    run(py, || {
        let (mut flow, mut scratch) = (Square::new(n), Scratch::new(n));
        let graph = systems.graphs.graph(row);
        match decide(slack, &graph, &mut flow, &mut scratch) {
            Verdict::Matchable => (true, Vec::new()),
            Verdict::Halves => (false, Vec::new()),
            Verdict::Cut => (false, scratch.cut().to_vec()),
        }
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(breaks_hall_condition, module)?)?;
    module.add_function(wrap_pyfunction!(decide_matching, module)?)?;
    module.add_function(wrap_pyfunction!(list_systems, module)?)
}
