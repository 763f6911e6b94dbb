//! `patterndb._native.surfacing`.

use std::ops::ControlFlow;

use patterndb_geometry::tree::Tree;
use patterndb_surfacing::chords::search::CutProblem;
use patterndb_surfacing::chords::subcycles::Subcycles;
use patterndb_surfacing::chords::{candidates as chord_candidates, decompose, flatness};
use patterndb_surfacing::curvenetwork::meetings::{self, Boxes, Contact, Edge, Polylines};
use patterndb_surfacing::curvenetwork::survey::{self, Candidates, Curves, SeamJoins};
use patterndb_surfacing::cycles::bounding::{self, Incidence, Pairs};
use patterndb_surfacing::cycles::closing::{self, HalfCurves, Ways};
use patterndb_surfacing::cycles::measures::{SampledCurves, measure_cycle};
use patterndb_surfacing::tessellation::intersections;
use patterndb_surfacing::tessellation::piece::{self, Mesh};
use patterndb_surfacing::tessellation::planar::{self, Triangles};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

use crate::answers::{Answer, Answered, add_functions, compute};
use crate::arguments::{Blocks, Items, ItemsMut, Rows, RowsMut, TableMut};
use crate::unlocked::run;

/// Return places as numbers.
fn from_places(places: Vec<usize>) -> Vec<i64> {
    places.into_iter().map(|place| place as i64).collect()
}

// Chords.

#[pyfunction]
fn order_canonically<'py>(py: Python<'py>, points: Rows<'py, f64, 3>) -> Answered<'py> {
    compute!(py, points => from_places(chord_candidates::order_canonically(points)))
}

#[pyfunction]
fn endpoints<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    corners: Items<'py, bool>,
    bound: f64,
) -> Answered<'py> {
    compute!(py, points, corners => chord_candidates::find_endpoints(points, corners, bound))
}

#[pyfunction]
fn candidates<'py>(
    py: Python<'py>,
    given_points: Rows<'py, f64, 3>,
    given_corners: Items<'py, bool>,
    ends: Items<'py, i64>,
) -> Answered<'py> {
    compute!(py, given_points, given_corners, ends => {
        let found = chord_candidates::find_candidates(given_points, given_corners, ends);
        found.into_iter().map(|ends| ends.map(|v| v as i64)).collect::<Vec<_>>()
    })
}

#[pyfunction]
fn flatter<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    chords: Rows<'py, i64, 2>,
) -> Answered<'py> {
    compute!(py, points, chords => decompose::measure_gains(points, chords))
}

#[pyfunction]
fn standardised<'py>(py: Python<'py>, points: Rows<'py, f64, 3>) -> Answered<'py> {
    compute!(py, points => flatness::standardise(points))
}

#[pyfunction]
fn solve<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    own: Rows<'py, f64, 3>,
    chords: Rows<'py, i64, 2>,
    alpha: f64,
    printed: bool,
) -> Answered<'py> {
    let (points, own, chords) = (&*points, &*own, &*chords);
    let problem = CutProblem {
        points,
        own,
        chords,
        alpha,
        printed,
    };
    let cuts = run(py, || problem.solve())?;
    let cuts = cuts.map_err(|error| PyMemoryError::new_err(error.to_string()))?;
    let [chosen, bounds, positions] = [cuts.chosen, cuts.bounds, cuts.positions].map(from_places);
    (cuts.n_subproblems, cuts.cost, chosen, bounds, positions).answer(py)
}

#[pyfunction]
fn counted<'py>(py: Python<'py>, n: usize, chords: Rows<'py, i64, 2>) -> Answered<'py> {
    compute!(py, chords => Subcycles::new(n, chords).n_all)
}

// Curve networks.

#[pyfunction]
fn select_seam_joins<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    starts: Items<'py, i64>,
    along: Items<'py, f64>,
    closed: Items<'py, bool>,
    curves: Rows<'py, i64, 2>,
    lengths: Rows<'py, f64, 2>,
    gaps: Items<'py, f64>,
    ways: Rows<'py, f64, 2>,
    beside: Rows<'py, bool, 2>,
    some: Items<'py, i64>,
    by_pair: Items<'py, i64>,
    begin: Items<'py, i64>,
    end: Items<'py, i64>,
    reaches: Items<'py, f64>,
) -> Answered<'py> {
    let (curves, lengths, gaps) = (&*curves, &*lengths, &*gaps);
    let joins = SeamJoins {
        curves,
        lengths,
        gaps,
        ways: &ways,
        beside: &beside,
    };
    let (some, by_pair, begin, end) = (&*some, &*by_pair, &*begin, &*end);
    let candidates = Candidates {
        some,
        by_pair,
        begin,
        end,
    };
    compute!(py, points, starts, along, closed, reaches => {
        let curves = Curves { points, starts, along, closed, reaches };
        survey::select_seam_joins(curves, joins, candidates)
    })
}

#[pyfunction]
fn contacts<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    along: Items<'py, f64>,
    curve_of: Items<'py, i64>,
    edges: Items<'py, i64>,
    low: Rows<'py, f64, 3>,
    high: Rows<'py, f64, 3>,
    reaches: Items<'py, f64>,
    settled: Items<'py, bool>,
    limit: usize,
) -> Answered<'py> {
    compute!(py, points, along, curve_of, edges, low, high, reaches, settled => {
        let lines = Polylines { points, along, curve_of };
        let boxes = Boxes { edges, low, high };
        let found = meetings::find_contacts(lines, boxes, reaches, settled, limit);
        (
            found.iter().map(|contact| contact.edges).collect::<Vec<_>>(),
            found.iter().map(|contact| contact.places).collect::<Vec<_>>(),
            found.iter().map(|contact| contact.distance).collect::<Vec<_>>(),
        )
    })
}

#[pyfunction]
fn components<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    curve_of: Items<'py, i64>,
    key: Items<'py, i64>,
    pairs: Rows<'py, i64, 2>,
    reaches: Items<'py, f64>,
) -> Answered<'py> {
    compute!(py, points, curve_of, key, pairs, reaches => {
        meetings::find_components(points, curve_of, key, pairs, reaches)
    })
}

#[pyfunction]
fn joins<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    curve_of: Items<'py, i64>,
    along: Items<'py, f64>,
    lasts: Items<'py, f64>,
    pairs: Rows<'py, i64, 2>,
    places: Rows<'py, f64, 2>,
    distances: Items<'py, f64>,
    bounds: Items<'py, i64>,
    reaches: Items<'py, f64>,
    closed: Items<'py, bool>,
) -> Answered<'py> {
    let contact = |((&edges, &places), &distance)| Contact {
        edges,
        places,
        distance,
    };
    let each = pairs.iter().zip(&*places).zip(&*distances);
    let contacts: Vec<Contact> = each.map(contact).collect();
    compute!(py, points, curve_of, along, lasts, bounds, reaches, closed => {
        let lines = Polylines { points, along, curve_of };
        let made = meetings::choose_joins(lines, lasts, closed, &contacts, bounds, reaches);
        (made.curves, made.lengths, made.gaps, made.meetings)
    })
}

#[pyfunction]
fn find_nearest_of_edges<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    first: usize,
    second: usize,
    margin: f64,
) -> Answered<'py> {
    compute!(py, points => {
        let [first, second] = [first, second].map(|edge| Edge::new(points, edge));
        let ([s, u], gap) = meetings::find_nearest_of_edges(first, second, margin);
        (s, u, gap)
    })
}

#[pyfunction]
fn measure_deviation<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    other: Rows<'py, f64, 3>,
) -> Answered<'py> {
    compute!(py, points, other => meetings::measure_deviation(points, other))
}

// Cycles.

#[pyfunction]
fn spread_costs<'py>(
    py: Python<'py>,
    first: Items<'py, i64>,
    member: Items<'py, i64>,
    place: Items<'py, i64>,
    start: Items<'py, i64>,
    offset: Items<'py, i64>,
    one: Items<'py, i64>,
    other: Items<'py, i64>,
    price: Items<'py, f64>,
    mut cost: ItemsMut<'py, f64>,
) -> Answered<'py> {
    let cost = &mut *cost;
    compute!(py, first, member, place, start, offset, one, other, price => {
        let incidence = Incidence { first, member, place, start, offset };
        bounding::spread_costs(&incidence, &Pairs { one, other, price }, cost);
    })
}

#[pyfunction]
fn move_shares<'py>(
    py: Python<'py>,
    first: Items<'py, i64>,
    member: Items<'py, i64>,
    place: Items<'py, i64>,
    start: Items<'py, i64>,
    offset: Items<'py, i64>,
    cost: Items<'py, f64>,
    room: Items<'py, i64>,
    whole: Items<'py, bool>,
    mut shares: ItemsMut<'py, f64>,
    mut margin: ItemsMut<'py, f64>,
    sweeps: usize,
) -> Answered<'py> {
    let (shares, margin) = (&mut *shares, &mut *margin);
    compute!(py, first, member, place, start, offset, cost, room, whole => {
        let incidence = Incidence { first, member, place, start, offset };
        let curves = bounding::Curves { cost, room, whole };
        bounding::move_shares(&incidence, &curves, shares, margin, sweeps)
    })
}

#[pyfunction]
fn measure_ways<'py>(
    py: Python<'py>,
    end: Items<'py, i64>,
    length: Items<'py, f64>,
    first: Items<'py, i64>,
    leaving: Items<'py, i64>,
    target: usize,
    mut distance: ItemsMut<'py, f64>,
    mut near: ItemsMut<'py, i64>,
) -> Answered<'py> {
    let (distance, near) = (&mut *distance, &mut *near);
    compute!(py, end, length, first, leaving => {
        let halves = HalfCurves { start: &[], end, first, leaving };
        closing::measure_ways(&halves, length, target, distance, near)
    })
}

#[pyfunction]
fn find_closing_paths<'py>(
    py: Python<'py>,
    start: Items<'py, i64>,
    end: Items<'py, i64>,
    length: Items<'py, f64>,
    first: Items<'py, i64>,
    leaving: Items<'py, i64>,
    distance: Items<'py, f64>,
    farther: f64,
    out: usize,
    back: usize,
    mut paths: TableMut<'py, i64>,
    mut sizes: ItemsMut<'py, i64>,
    most: usize,
) -> Answered<'py> {
    let width = paths.shape()[1];
    let (paths, sizes) = (&mut *paths, &mut *sizes);
    compute!(py, start, end, length, first, leaving, distance => {
        let mut rows = paths.chunks_exact_mut(width).zip(sizes);
        let n = rows.len();
        if n == 0 {
            return (0, false);
        }
        let halves = HalfCurves { start, end, first, leaving };
        let (ways, pair) = (Ways { distance, farther }, [out, back]);
        let cut_short = closing::find_closing_paths(&halves, length, ways, pair, most, |cycle| {
            if let Some((row, size)) = rows.next() {
                for (written, &half) in row[..cycle.len()].iter_mut().zip(cycle) {
                    *written = half as i64;
                }
                *size = cycle.len() as i64;
            }
            if rows.len() == 0 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        (n - rows.len(), cut_short)
    })
}

#[pyfunction]
fn find_flat_polygon<'py>(
    py: Python<'py>,
    start: Items<'py, i64>,
    end: Items<'py, i64>,
    first: Items<'py, i64>,
    leaving: Items<'py, i64>,
    tangents: Rows<'py, f64, 3>,
    out: usize,
    back: usize,
    mut path: ItemsMut<'py, i64>,
) -> Answered<'py> {
    let path = &mut *path;
    compute!(py, start, end, first, leaving, tangents => {
        let halves = HalfCurves { start, end, first, leaving };
        let found = closing::find_flat_polygon(&halves, tangents, [out, back], path.len());
        let found = found.unwrap_or_default();
        for (written, &half) in path.iter_mut().zip(&found) {
            *written = half as i64;
        }
        found.len()
    })
}

#[pyfunction]
fn measure<'py>(
    py: Python<'py>,
    steps: Items<'py, i64>,
    samples: Rows<'py, f64, 3>,
    offsets: Items<'py, i64>,
    start: Items<'py, i64>,
    first: Items<'py, i64>,
    leaving: Items<'py, i64>,
    tangents: Rows<'py, f64, 3>,
    mut values: ItemsMut<'py, f64>,
    mut inward: RowsMut<'py, f64, 3>,
) -> Answered<'py> {
    let (values, inward) = (&mut *values, &mut *inward);
    compute!(py, steps, samples, offsets, start, first, leaving, tangents => {
        let curves = SampledCurves { samples, offsets, start, first, leaving, tangents };
        let found = measure_cycle(steps, &curves, inward);
        values.copy_from_slice(&[
            found.length,
            found.flatness,
            found.area,
            found.bending,
            found.corners,
            found.cuts,
            found.section,
            found.crossed,
        ]);
    })
}

// Tessellation.

#[pyfunction]
fn crossings<'py>(
    py: Python<'py>,
    corners: Blocks<'py, f64, 3, 3>,
    triangles: Rows<'py, i64, 3>,
    owner: Items<'py, i64>,
    boxes: Blocks<'py, f64, 2, 3>,
    nodes: Rows<'py, i32, 2>,
    order: Items<'py, i32>,
) -> Answered<'py> {
    compute!(py, corners, triangles, owner, boxes, nodes, order => {
        let tree = Tree { corners, boxes, nodes, order };
        intersections::find_crossings(&tree, triangles, owner)
    })
}

#[pyfunction]
fn solve_heights<'py>(
    py: Python<'py>,
    at: Rows<'py, i64, 2>,
    tail: Items<'py, i64>,
    twin: Items<'py, i64>,
    boundary: Items<'py, f64>,
) -> Answered<'py> {
    compute!(py, at, tail, twin, boundary => piece::solve_heights(Mesh { at, tail, twin }, boundary))
}

#[pyfunction]
fn measure_stretch<'py>(
    py: Python<'py>,
    at: Rows<'py, i64, 2>,
    tail: Items<'py, i64>,
    heights: Items<'py, f64>,
    step: f64,
) -> Answered<'py> {
    compute!(py, at, tail, heights => piece::measure_stretch(at, tail, heights, step))
}

#[pyfunction]
fn doubled_area<'py>(py: Python<'py>, at: Rows<'py, i64, 2>) -> Answered<'py> {
    compute!(py, at => planar::doubled_area(at))
}

#[pyfunction]
fn is_simple<'py>(py: Python<'py>, at: Rows<'py, i64, 2>) -> Answered<'py> {
    compute!(py, at => planar::is_simple(at))
}

#[pyfunction]
fn clip_ears<'py>(
    py: Python<'py>,
    at: Rows<'py, i64, 2>,
    m: usize,
    mut tail: ItemsMut<'py, i64>,
    mut twin: ItemsMut<'py, i64>,
) -> Answered<'py> {
    let (tail, twin) = (&mut *tail, &mut *twin);
    compute!(py, at => planar::clip_ears(&at[..m], &mut Triangles { tail, twin }))
}

#[pyfunction]
fn make_delaunay<'py>(
    py: Python<'py>,
    at: Rows<'py, i64, 2>,
    mut tail: ItemsMut<'py, i64>,
    mut twin: ItemsMut<'py, i64>,
    triangles: usize,
) -> Answered<'py> {
    let sides = ..3 * triangles;
    let (tail, twin) = (&mut tail[sides], &mut twin[sides]);
    compute!(py, at => Triangles { tail, twin }.make_delaunay(at))
}

#[pyfunction]
fn lay_lattice<'py>(py: Python<'py>, grid: Rows<'py, i64, 2>, spacing: f64) -> Answered<'py> {
    compute!(py, grid => planar::lay_lattice(grid, spacing))
}

#[pyfunction]
fn join<'py>(
    py: Python<'py>,
    at: Rows<'py, i64, 2>,
    m: usize,
    mut tail: ItemsMut<'py, i64>,
    mut twin: ItemsMut<'py, i64>,
) -> Answered<'py> {
    let (tail, twin) = (&mut *tail, &mut *twin);
    compute!(py, at => Triangles { tail, twin }.join(at, m))
}

#[pyfunction]
fn smooth<'py>(
    py: Python<'py>,
    mut at: RowsMut<'py, i64, 2>,
    m: usize,
    mut tail: ItemsMut<'py, i64>,
    mut twin: ItemsMut<'py, i64>,
) -> Answered<'py> {
    let (at, tail, twin) = (&mut *at, &mut *tail, &mut *twin);
    compute!(py, => Triangles { tail, twin }.smooth(at, m))
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    let module = &crate::add_module(parent, "chords")?;
    add_functions!(module, "candidates": order_canonically, endpoints, candidates);
    add_functions!(module, "decompose": flatter);
    add_functions!(module, "flatness": standardised);
    add_functions!(module, "search": solve);
    add_functions!(module, "subcycles": counted);
    let module = &crate::add_module(parent, "curvenetwork")?;
    add_functions!(module, "meetings": contacts, components, joins, find_nearest_of_edges,
        measure_deviation);
    add_functions!(module, "survey": select_seam_joins);
    let module = &crate::add_module(parent, "cycles")?;
    add_functions!(module, "bounding": spread_costs, move_shares);
    add_functions!(module, "closing": measure_ways, find_closing_paths, find_flat_polygon);
    add_functions!(module, "measures": measure);
    let module = &crate::add_module(parent, "tessellation")?;
    add_functions!(module, "intersections": crossings);
    add_functions!(module, "piece": solve_heights, measure_stretch);
    add_functions!(module, "planar": doubled_area, is_simple, clip_ears, make_delaunay,
        lay_lattice, join, smooth);
    Ok(())
}
