//! `patterndb._native.query.solving` and `patterndb._native.query.marks`.

use numpy::PyArray1;
use numpy::ndarray::Ix3;
use patterndb_query::marks::bestmarked::{self, ClassTable, MarkedIndex, MarkedRow, Outline};
use patterndb_query::marks::markplaces::{self, Parting, Records, Unmarked};
use patterndb_query::marks::patterntable;
use patterndb_query::solving::balance::Class;
use patterndb_query::solving::feasibility::{self, Lanes, Patterns};
use patterndb_query::solving::fractional_matching::{Scratch, Square};
use patterndb_query::solving::hall_conditions::{MOST_SIDES, Sums, list_hall_conditions};
use patterndb_query::solving::matching::{Verdict, decide};
use patterndb_query::solving::sieve::{self, Claims, Sieve};
use patterndb_query::solving::systems::{self, Graphs, Systems};
use patterndb_query::solving::widths::{self, Fits, Labels, WidthProblem};
use pyo3::exceptions::PyValueError;
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

#[pyfunction]
fn breaks_hall_condition<'py>(
    py: Python<'py>,
    systems: SystemArrays<'py>,
    row: usize,
    need: Items<'py, i32>,
) -> Answered<'py> {
    let systems = systems.view();
    if need.len() > MOST_SIDES {
        let wrong = format!("{} sides are more than {MOST_SIDES}", need.len());
        return Err(PyValueError::new_err(wrong));
    }
    compute!(py, need => {
        let mut padded = [0; MOST_SIDES];
        padded[..need.len()].copy_from_slice(need);
        let mut sums = Sums::default();
        sums.fill(&padded);
        let graph = systems.graph[row] as usize;
        let [first, last] = [graph, graph + 1].map(|at| systems.hall_first[at] as usize);
        sums.break_any(&systems.hall[first..last])
    })
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
fn sift_systems<'py>(
    py: Python<'py>,
    systems: SystemArrays<'py>,
    lanes: LaneArrays<'py>,
    stated: Table<'py, i64>,
    mut passing: TableMut<'py, bool>,
) -> Answered<'py> {
    let n_lanes = passing.shape()[1];
    let sieve = lanes.view(&systems, &stated).sieve;
    let passing = &mut *passing;
    compute!(py, => {
        let mut left = vec![[0; sieve::GROUP]; sieve.marks.len()];
        for (row, passing) in passing.chunks_exact_mut(n_lanes).enumerate() {
            sieve.sift(row, &mut left);
            for (lane, passes) in passing.iter_mut().enumerate() {
                *passes = sieve::has_lane(&left, lane);
            }
        }
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

/// Return components and colours.
#[pyfunction]
fn colours<'py>(
    py: Python<'py>,
    class_start: Items<'py, i64>,
    class_i: Items<'py, i32>,
    class_j: Items<'py, i32>,
    n_sides: usize,
) -> Answered<'py> {
    compute!(py, class_start, class_i, class_j => {
        let classes = ClassTable { start: class_start, i: class_i, j: class_j };
        let shape = [class_start.len() - 1, n_sides];
        let [component, colour] = bestmarked::colours(&classes, n_sides);
        (Shaped(component, shape), Shaped(colour, shape))
    })
}

/// The Python class `MarkedIndex`.
#[derive(FromPyObject)]
struct IndexArrays<'py> {
    base: Table<'py, i32>,
    start: Items<'py, i64>,
    unmarked: Items<'py, i32>,
    signature: Items<'py, i32>,
    counts: Table<'py, u8>,
    convex: Items<'py, i32>,
    reflex: Items<'py, i32>,
    class_start: Items<'py, i64>,
    class_i: Items<'py, i32>,
    class_j: Items<'py, i32>,
    component: Table<'py, i16>,
    colour: Table<'py, i16>,
}

impl IndexArrays<'_> {
    /// Borrow the arrays.
    fn view(&self) -> MarkedIndex<'_> {
        MarkedIndex {
            base: &self.base,
            start: &self.start,
            unmarked: &self.unmarked,
            signature: &self.signature,
            counts: &self.counts,
            convex: &self.convex,
            reflex: &self.reflex,
            classes: ClassTable {
                start: &self.class_start,
                i: &self.class_i,
                j: &self.class_j,
            },
            component: &self.component,
            colour: &self.colour,
        }
    }
}

/// Return the fields of [`bestmarked::BestRow`], the row -1 where there is none.
#[pyfunction]
fn find_best_row<'py>(
    py: Python<'py>,
    index: IndexArrays<'py>,
    lengths: Items<'py, i32>,
    asked: Items<'py, i32>,
    cap: i32,
    most: Option<i32>,
) -> Answered<'py> {
    let index = index.view();
    compute!(py, lengths, asked => {
        match bestmarked::find_best_row(&Outline { lengths, asked, cap, most }, &index) {
            Some(best) => {
                let on_boundary = best.n_on_boundary;
                (best.row as i64, best.orientation, best.n_irregular, on_boundary, best.slack)
            }
            None => (-1, 0, 0, 0, Vec::new()),
        }
    })
}

/// A label as a word, rotation, whether it is reflected, and the number of sides.
type Row<'py> = (Items<'py, i16>, usize, bool, usize);

/// The two sides of classes, and their numbers of strands.
type Classes<'py> = (Items<'py, i32>, Items<'py, i32>, Items<'py, i32>);

#[pyfunction]
fn spread_strand_widths<'py>(
    py: Python<'py>,
    row: Row<'py>,
    classes: Classes<'py>,
    slack: Items<'py, i32>,
) -> Answered<'py> {
    let (label, rotation, reflected, n_sides) = row;
    let columns = classes.0.iter().zip(&*classes.1);
    let class = |((&i, &j), &n): ((&i32, &i32), &i32)| Class {
        i: i as usize,
        j: j as usize,
        n,
        weight: 1,
    };
    let classes: Vec<Class> = columns.zip(&*classes.2).map(class).collect();
    compute!(py, label, slack => {
        let row = MarkedRow { label, rotation, reflected, n_sides };
        bestmarked::spread_strand_widths(&row, &classes, slack)
    })
}

/// Return the heads, labels and polychords of records.
#[pyfunction]
fn list_records<'py>(
    py: Python<'py>,
    flat: Items<'py, u16>,
    offsets: Items<'py, i64>,
    n_irregular: Items<'py, i32>,
    n_reflex: Items<'py, i32>,
    n_marks: usize,
    most: i32,
    free: bool,
    marks: Items<'py, i32>,
    slots: Items<'py, i32>,
    near: Items<'py, i32>,
    far: Items<'py, i32>,
) -> Answered<'py> {
    let partings: Vec<Parting> = (0..marks.len())
        .map(|k| Parting {
            marks: marks[k],
            slots: slots[k],
            near: near[k],
            far: far[k],
        })
        .collect();
    compute!(py, flat, offsets, n_irregular, n_reflex => {
        let patterns = offsets.windows(2).zip(n_irregular).zip(n_reflex);
        let patterns = patterns.map(|((ends, &n_irregular), &n_reflex)| Unmarked {
            code: &flat[ends[0] as usize..ends[1] as usize],
            n_irregular,
            n_reflex,
        });
        let bounds = markplaces::Bounds { n_marks, most, free };
        let records = markplaces::list_records(patterns, bounds, &partings);
        let width = Records::width(n_marks);
        let n_records = records.head.len() / width;
        (Shaped(records.head, [n_records, width]), records.label, records.chord)
    })
}

#[pyfunction]
fn meshes<'py>(py: Python<'py>, flat: Items<'py, u16>, offsets: Items<'py, i64>) -> Answered<'py> {
    compute!(py, flat, offsets => patterntable::meshes(flat, offsets))
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "feasibility": mark, pack_lengths, sift_systems, state_claims);
    add_functions!(parent, "systems": breaks_hall_condition, decide_matching, list_systems);
    add_functions!(parent, "widths": filter_stroke_feasible, find_best_widths);
    Ok(())
}

/// Add `patterndb._native.query.marks`.
pub fn add_marks(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "bestmarked": colours, find_best_row, spread_strand_widths);
    add_functions!(parent, "markplaces": list_records);
    add_functions!(parent, "patterntable": meshes);
    Ok(())
}
