//! `patterndb._native.query.solving`.

use numpy::PyArray1;
use numpy::ndarray::Ix3;
use patterndb_query::solving::feasibility::{self, Lanes, Patterns};
use patterndb_query::solving::fractional_matching::{Scratch, Square};
use patterndb_query::solving::hall_conditions::{MOST_SIDES, list_hall_conditions};
use patterndb_query::solving::matching::{Verdict, decide};
use patterndb_query::solving::sieve::{self, Claims, Sieve};
use patterndb_query::solving::systems::{self, Graphs, Systems};
use patterndb_query::solving::widths::{self, Fits, Labels, WidthProblem};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::answers::{Answer, Answered, Shaped, add_functions, compute};
use crate::arguments::{Items, ItemsMut, Rows, Table, TableMut};
use crate::flag::{CancelFlag, is_set};
use crate::unlocked::run;

/// The Python class `Systems`.
#[derive(FromPyObject)]
struct SystemArrays<'py> {
    first: Items<'py, i32>,
    class_i: Items<'py, i16>,
    class_j: Items<'py, i16>,
    claim: Table<'py, i32>,
    claimant: Items<'py, i16>,
    near_first: Items<'py, i32>,
    near: Items<'py, i16>,
    base: Table<'py, i16>,
    pairs: Table<'py, u8>,
    perimeter: Items<'py, i32>,
    surplus: Table<'py, u8>,
    component: Table<'py, i16>,
    colour: Table<'py, i16>,
    parity: Items<'py, bool>,
    graph: Items<'py, i32>,
    hall_first: Items<'py, i32>,
    hall: Items<'py, i32>,
}

impl SystemArrays<'_> {
    /// Borrow the arrays.
    fn view(&self) -> Systems<'_> {
        Systems {
            graphs: Graphs {
                first: &self.first,
                class_i: &self.class_i,
                class_j: &self.class_j,
                claim: &self.claim,
                near_first: &self.near_first,
                near: &self.near,
                n_sides: self.claim.shape()[1],
            },
            base: &self.base,
            perimeter: &self.perimeter,
            component: &self.component,
            colour: &self.colour,
            parity: &self.parity,
            graph: &self.graph,
            hall_first: &self.hall_first,
            hall: &self.hall,
        }
    }
}

/// The Python class `Lanes`.
#[derive(FromPyObject)]
struct LaneArrays<'py> {
    lengths: Table<'py, i32>,
    lane_of: Items<'py, i32>,
    marks: Items<'py, i64>,
    compared: Items<'py, i64>,
}

impl LaneArrays<'_> {
    /// Borrow the arrays; `stated` is what [`state_claims`] wrote.
    fn view<'a>(&'a self, systems: &'a SystemArrays, stated: &'a Table<'_, i64>) -> Lanes<'a> {
        Lanes {
            sieve: Sieve {
                pairs: &systems.pairs,
                surplus: &systems.surplus,
                claim: &systems.claim,
                marks: self.marks.as_chunks().0,
                compared: self.compared.as_chunks().0,
                stated: stated.as_chunks().0,
                n_sides: systems.claim.shape()[1],
            },
            lengths: &self.lengths,
            lane_of: &self.lane_of,
        }
    }
}

/// The Python class `PatternRows`.
#[derive(FromPyObject)]
struct PatternArrays<'py> {
    rows: Items<'py, i64>,
    signature: Items<'py, i32>,
    rotation: Items<'py, i32>,
    reflected: Items<'py, bool>,
    allowed: Table<'py, u8>,
}

/// The Python class `Labels`.
#[derive(FromPyObject)]
struct LabelArrays<'py> {
    n_sides: usize,
    words: Items<'py, i16>,
    start: Items<'py, i64>,
}

impl LabelArrays<'_> {
    /// Borrow the arrays.
    fn view(&self) -> Labels<'_> {
        Labels {
            n_sides: self.n_sides,
            words: &self.words,
            start: &self.start,
        }
    }
}

/// The Python class `WidthProblem`.
#[derive(FromPyObject)]
struct ProblemArrays<'py> {
    lengths: Table<'py, i32>,
    weights: Items<'py, i32, Ix3>,
    strokes: Rows<'py, i32, 4, Ix3>,
    tolerance: i32,
}

impl ProblemArrays<'_> {
    /// Borrow the arrays.
    fn view(&self) -> WidthProblem<'_> {
        WidthProblem {
            lengths: &self.lengths,
            weights: &self.weights,
            strokes: &self.strokes,
            tolerance: self.tolerance,
            n_sides: self.lengths.shape()[1],
        }
    }
}

#[pyfunction]
fn list_systems<'py>(
    py: Python<'py>,
    base: Table<'py, i16>,
    joined: Items<'py, bool, Ix3>,
    with_hall: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let (n, w) = (joined.shape()[0], joined.shape()[1]);
    let (base, joined) = (&*base, &*joined);
    let (claims, classes, pairs, hall) = run(py, || {
        let claims = systems::number_claims(joined, w);
        let hall = (with_hall && w <= MOST_SIDES)
            .then(|| list_hall_conditions(&claims.claim, w, &claims.near_first, &claims.near));
        let classes = systems::list_classes(base, joined, w);
        (claims, classes, sieve::pair_sides(base, w), hall)
    })?;
    // Without conditions, all systems have one graph that has none.
    let (graph, hall_first, conditions) = match hall {
        Some(hall) => (hall.graph, hall.first, hall.conditions),
        None => (vec![0; n], vec![0, 0], Vec::new()),
    };
    let made = PyDict::new(py);
    made.set_item("first", classes.first.answer(py)?)?;
    made.set_item("class_i", classes.class_i.answer(py)?)?;
    made.set_item("class_j", classes.class_j.answer(py)?)?;
    made.set_item("claim", Shaped(claims.claim, [n, w]).answer(py)?)?;
    made.set_item("claimant", claims.claimant.answer(py)?)?;
    made.set_item("near_first", claims.near_first.answer(py)?)?;
    made.set_item("near", claims.near.answer(py)?)?;
    made.set_item("pairs", Shaped(pairs, [n, w.div_ceil(2)]).answer(py)?)?;
    made.set_item("surplus", Shaped(classes.surplus, [n, w]).answer(py)?)?;
    made.set_item("component", Shaped(classes.component, [n, w]).answer(py)?)?;
    made.set_item("colour", Shaped(classes.colour, [n, w]).answer(py)?)?;
    made.set_item("parity", classes.parity.answer(py)?)?;
    made.set_item("graph", graph.answer(py)?)?;
    made.set_item("hall_first", hall_first.answer(py)?)?;
    made.set_item("hall", conditions.answer(py)?)?;
    Ok(made)
}

/// Return whether there is a matching, and the sides of the cut.
#[pyfunction]
fn decide_matching<'py>(
    py: Python<'py>,
    systems: SystemArrays<'py>,
    row: usize,
    slack: Items<'py, i32>,
) -> PyResult<(bool, Vec<usize>)> {
    let (systems, slack) = (systems.view(), &*slack);
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

/// Return marks, and compared lengths.
#[pyfunction]
fn pack_lengths<'py>(py: Python<'py>, lengths: Table<'py, i32>) -> Answered<'py> {
    let n_sides = lengths.shape()[1];
    compute!(py, lengths => {
        let packed = sieve::pack_lengths(lengths, n_sides);
        (packed.marks, packed.compared)
    })
}

#[pyfunction]
fn state_claims<'py>(
    py: Python<'py>,
    systems: SystemArrays<'py>,
    lengths: Table<'py, i32>,
    claims: Items<'py, i32>,
    first: usize,
    mut stated: TableMut<'py, u8>,
) -> Answered<'py> {
    let of_class = Claims {
        lengths: &lengths,
        n_lanes: lengths.shape()[1],
        claimant: &systems.claimant,
        near_first: &systems.near_first,
        near: &systems.near,
    };
    let width = stated.shape()[1];
    let stated = &mut *stated;
    compute!(py, claims => sieve::state_claims(&of_class, claims, first, stated, width))
}

#[pyfunction]
fn mark<'py>(
    py: Python<'py>,
    systems: SystemArrays<'py>,
    lanes: LaneArrays<'py>,
    stated: Table<'py, i64>,
    patterns: PatternArrays<'py>,
    cancelled: Bound<'py, PyArray1<u8>>,
    mut fits: TableMut<'py, bool>,
) -> Answered<'py> {
    let lanes = lanes.view(&systems, &stated);
    let systems = systems.view();
    let patterns = Patterns {
        rows: &patterns.rows,
        signature: &patterns.signature,
        rotation: &patterns.rotation,
        reflected: &patterns.reflected,
        allowed: &patterns.allowed,
    };
    let cancelled = CancelFlag::new(cancelled)?;
    let cancelled = cancelled.atomic();
    let once = fits.shape()[1] == 1;
    let fits = &mut *fits;
    compute!(py, => {
        feasibility::mark(&systems, &lanes, &patterns, once, || is_set(cancelled), fits);
    })
}

#[pyfunction]
fn filter_stroke_feasible<'py>(
    py: Python<'py>,
    labels: LabelArrays<'py>,
    rows: Items<'py, i64>,
    mut allowed: TableMut<'py, bool>,
    problem: ProblemArrays<'py>,
    once: bool,
    cancelled: Bound<'py, PyArray1<u8>>,
) -> Answered<'py> {
    let (labels, problem, allowed) = (labels.view(), problem.view(), &mut *allowed);
    let cancelled = CancelFlag::new(cancelled)?;
    let cancelled = cancelled.atomic();
    compute!(py, rows => {
        let is_cancelled = || is_set(cancelled);
        widths::filter_stroke_feasible(&labels, rows, &problem, once, &is_cancelled, allowed);
    })
}

/// Counts, keys and fits of some rows, to be written.
type FitArrays<'py> = (
    ItemsMut<'py, i64>,
    TableMut<'py, i64>,
    ItemsMut<'py, i32, Ix3>,
);

#[pyfunction]
fn find_best_widths<'py>(
    py: Python<'py>,
    labels: LabelArrays<'py>,
    rows: Items<'py, i64>,
    allowed: Table<'py, bool>,
    problem: ProblemArrays<'py>,
    fits: FitArrays<'py>,
    cancelled: Bound<'py, PyArray1<u8>>,
) -> Answered<'py> {
    let (labels, problem) = (labels.view(), problem.view());
    let (mut count, mut key, mut best) = fits;
    let keep = key.shape()[1];
    let mut fits = Fits {
        count: &mut count,
        key: &mut key,
        best: &mut best,
        keep,
    };
    let cancelled = CancelFlag::new(cancelled)?;
    let cancelled = cancelled.atomic();
    compute!(py, rows, allowed => {
        let is_cancelled = || is_set(cancelled);
        widths::find_best_widths(&labels, rows, allowed, &problem, &is_cancelled, &mut fits);
    })
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "feasibility": mark, pack_lengths, state_claims);
    add_functions!(parent, "systems": decide_matching, list_systems);
    add_functions!(parent, "widths": filter_stroke_feasible, find_best_widths);
    Ok(())
}
