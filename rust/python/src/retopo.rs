//! `patterndb._native.retopo`.

use numpy::Complex64;
use patterndb_geometry::Point;
use patterndb_geometry::adjacency::{Edges, Surface};
use patterndb_retopo::counts::evening::{self, Sides};
use patterndb_retopo::counts::walks::{self, Halves, WalkGraph};
use patterndb_retopo::counts::{rules, tjoin};
use patterndb_retopo::draft::crossfield::Laplacian;
use patterndb_retopo::draft::remesh::{self, Collapse, Mesh};
use patterndb_retopo::draft::tracing::{self, CrossField, Limits, LineSegment, Start};
use patterndb_retopo::filling::edgecounts;
use patterndb_retopo::network::crossings::{self, Line};
use patterndb_retopo::network::samples::{self, Samples};
use patterndb_retopo::network::{attaching, flooding, patches};
use patterndb_retopo::quadgrids::{self, Quads, Separatrices};
use patterndb_retopo::tools::salience::Dots;
use patterndb_retopo::tracing::geodesic::{self, Place};
use patterndb_retopo::tracing::localmap::{self, Extent, Frame, Grid, Seeds, Stars};
use patterndb_retopo::tracing::planarcut;
use patterndb_retopo::tracing::shortening::{self, Gates, Step, Turn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::answers::{Answered, Shaped, add_functions, compute};
use crate::arguments::{Blocks, Items, ItemsMut, Rows, RowsMut, Table, take};

// Counts.

#[pyfunction]
fn tie_sides<'py>(
    py: Python<'py>,
    first_side: Items<'py, i32>,
    first_chain: Items<'py, i32>,
    chains: Items<'py, i32>,
    pinned: Items<'py, i32>,
    least: Items<'py, i32>,
) -> Answered<'py> {
    compute!(py, first_side, first_chain, chains, pinned, least => {
        evening::tie_sides(Sides { first_side, first_chain, chains }, pinned, least)
    })
}

#[pyfunction]
fn find_irregular<'py>(
    py: Python<'py>,
    first_side: Items<'py, i32>,
    lengths: Items<'py, i32>,
) -> Answered<'py> {
    compute!(py, first_side, lengths => rules::find_irregular(first_side, lengths))
}

#[pyfunction]
fn is_cheap<'py>(
    py: Python<'py>,
    lengths: Items<'py, i32>,
    low: usize,
    high: usize,
) -> Answered<'py> {
    compute!(py, lengths => rules::is_cheap(&lengths[low..high]))
}

#[pyfunction]
#[pyo3(name = "match")]
fn match_vertices<'py>(py: Python<'py>, weights: Table<'py, i64>) -> Answered<'py> {
    let n = weights.shape()[0];
    compute!(py, weights => tjoin::match_vertices(weights, n))
}

/// The arrays of a `WalkGraph` of Python that no kernel writes to.
#[derive(FromPyObject)]
struct HalfArrays<'py> {
    chain: Items<'py, i32>,
    patch: Items<'py, i32>,
    side: Items<'py, i32>,
    place: Items<'py, i32>,
    twin: Items<'py, i32>,
    first_half: Items<'py, i32>,
    first_side: Items<'py, i32>,
    first_after: Items<'py, i64>,
}

impl HalfArrays<'_> {
    /// Borrow the arrays.
    fn view(&self) -> Halves<'_> {
        Halves {
            chain: &self.chain,
            patch: &self.patch,
            side: &self.side,
            place: &self.place,
            twin: &self.twin,
            first_half: &self.first_half,
            first_side: &self.first_side,
            first_after: &self.first_after,
        }
    }
}

/// The tables of a `WalkGraph` of Python, to write to.
#[derive(FromPyObject)]
struct JudgedArrays<'py> {
    after: ItemsMut<'py, i8>,
    state: ItemsMut<'py, i8>,
}

/// The tables and costs of a `WalkGraph` of Python, to read.
#[derive(FromPyObject)]
struct CostArrays<'py> {
    after: Items<'py, i8>,
    state: Items<'py, i8>,
    step: Rows<'py, f64, 4>,
}

#[pyfunction]
fn judge_patches<'py>(
    py: Python<'py>,
    graph: Bound<'py, PyAny>,
    lengths: Items<'py, i32>,
    patches: Items<'py, i32>,
) -> Answered<'py> {
    let halves: HalfArrays = graph.extract()?;
    let mut judged: JudgedArrays = graph.extract()?;
    let halves = halves.view();
    let (state, after) = (&mut *judged.state, &mut *judged.after);
    compute!(py, lengths, patches => walks::judge_patches(&halves, lengths, patches, state, after))
}

#[pyfunction]
fn find_walk<'py>(
    py: Python<'py>,
    graph: Bound<'py, PyAny>,
    starts: Items<'py, i32>,
    begin: usize,
    most_steps: usize,
    regularity: f64,
    mut walk: RowsMut<'py, i32, 2>,
) -> Answered<'py> {
    let halves: HalfArrays = graph.extract()?;
    let costs: CostArrays = graph.extract()?;
    let graph = WalkGraph {
        halves: halves.view(),
        after: &costs.after,
        state: &costs.state,
        step: &costs.step,
        regularity,
    };
    let walk = &mut *walk;
    compute!(py, starts => walks::find_walk(&graph, starts, begin, most_steps, walk))
}

// Drafts.

#[pyfunction]
fn solve_laplacian<'py>(
    py: Python<'py>,
    across: Items<'py, i32>,
    weight: Items<'py, f64>,
    turned: Items<'py, Complex64>,
    pull: Items<'py, f64>,
    right: Items<'py, Complex64>,
    start: Items<'py, Complex64>,
) -> Answered<'py> {
    compute!(py, across, weight, turned, pull, right, start => {
        Laplacian { across, weight, turned, pull }.solve(right, start)
    })
}

#[pyfunction]
fn split_long<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    triangles: Rows<'py, i32, 3>,
    twin: Items<'py, i32>,
    longest: f64,
) -> Answered<'py> {
    compute!(py, points, triangles, twin => {
        let mut mesh = Mesh {
            points: points.to_vec(),
            triangles: triangles.to_vec(),
            twin: twin.to_vec(),
        };
        mesh.split_long(longest);
        (mesh.points, mesh.triangles, mesh.twin)
    })
}

#[pyfunction]
fn mark_border<'py>(
    py: Python<'py>,
    n: usize,
    triangles: Rows<'py, i32, 3>,
    twin: Items<'py, i32>,
) -> Answered<'py> {
    compute!(py, triangles, twin => remesh::mark_border(n, triangles, twin))
}

#[pyfunction]
fn collapse_short<'py>(
    py: Python<'py>,
    mut points: RowsMut<'py, f64, 3>,
    mut triangles: RowsMut<'py, i32, 3>,
    mut twin: ItemsMut<'py, i32>,
    shortest: f64,
    longest: f64,
) -> Answered<'py> {
    let (points, triangles, twin) = (&mut *points, &mut *triangles, &mut *twin);
    compute!(py, => Collapse { points, triangles, twin, shortest, longest }.run())
}

#[pyfunction]
fn flip_to_valence<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    mut triangles: RowsMut<'py, i32, 3>,
    mut twin: ItemsMut<'py, i32>,
    border: Items<'py, bool>,
) -> Answered<'py> {
    let (triangles, twin) = (&mut *triangles, &mut *twin);
    compute!(py, points, border => remesh::flip_to_valence(points, triangles, twin, border))
}

#[pyfunction]
fn relax<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    triangles: Rows<'py, i32, 3>,
    border: Items<'py, bool>,
) -> Answered<'py> {
    compute!(py, points, triangles, border => remesh::relax(points, triangles, border))
}

/// Return the segments' lines, triangles, beginnings, ends, distances along and lengths, and the
/// traces' ways to end, lengths, what they met, how far along, and from which side.
#[pyfunction]
fn trace_all<'py>(
    py: Python<'py>,
    flat: Blocks<'py, f64, 3, 2>,
    side_angle: Rows<'py, f64, 3>,
    across: Items<'py, i32>,
    angle: Items<'py, f64>,
    quarters: Items<'py, i32>,
    start_triangle: Items<'py, i32>,
    start_corner: Items<'py, i32>,
    start_place: Rows<'py, f64, 2>,
    start_angle: Items<'py, f64>,
    start_direction: Items<'py, i32>,
    wall_line: Items<'py, i32>,
    wall_triangle: Items<'py, i32>,
    wall_begin: Rows<'py, f64, 2>,
    wall_end: Rows<'py, f64, 2>,
    wall_along: Items<'py, f64>,
    wall_reach: Items<'py, f64>,
    first: i32,
    longest: f64,
    stopping: bool,
) -> Answered<'py> {
    let starts: Vec<Start> = (0..start_triangle.len())
        .map(|i| Start {
            triangle: start_triangle[i],
            corner: start_corner[i],
            place: start_place[i],
            angle: start_angle[i],
            direction: start_direction[i],
        })
        .collect();
    let walls: Vec<LineSegment> = (0..wall_line.len())
        .map(|w| LineSegment {
            line: wall_line[w],
            triangle: wall_triangle[w],
            begin: wall_begin[w],
            end: wall_end[w],
            along: wall_along[w],
            reach: wall_reach[w],
        })
        .collect();
    compute!(py, flat, side_angle, across, angle, quarters => {
        let field = CrossField { flat, side_angle, across, angle, quarters };
        let limits = Limits { first, longest, stopping };
        let (segments, traces) = tracing::trace_all(&field, &starts, &walls, &limits);
        (
            of_each(&segments, |s| s.line),
            of_each(&segments, |s| s.triangle),
            of_each(&segments, |s| s.begin),
            of_each(&segments, |s| s.end),
            of_each(&segments, |s| s.along),
            of_each(&segments, |s| s.reach),
            of_each(&traces, |t| t.ended as i32),
            of_each(&traces, |t| t.length),
            of_each(&traces, |t| t.other),
            of_each(&traces, |t| t.there),
            of_each(&traces, |t| t.left),
        )
    })
}

/// Return a number, or a place, of each item.
fn of_each<S, T>(items: &[S], number: impl Fn(&S) -> T) -> Vec<T> {
    items.iter().map(number).collect()
}

#[pyfunction]
fn count_bend_edges<'py>(
    py: Python<'py>,
    line: Rows<'py, f64, 3>,
    closed: bool,
    steps: usize,
    edge: f64,
) -> Answered<'py> {
    compute!(py, line => edgecounts::count_bend_edges(line, closed, steps, edge))
}

// The base surface.

#[pyfunction]
fn search_route<'py>(
    py: Python<'py>,
    vertices: Rows<'py, f64, 3>,
    middles: Rows<'py, f64, 3>,
    ends: Rows<'py, i32, 2>,
    edges: Items<'py, i32>,
    side_start: Items<'py, i32>,
    sides: Items<'py, i32>,
    first: i32,
    start: Items<'py, f64>,
    last: i32,
    end: Items<'py, f64>,
) -> Answered<'py> {
    let start = Place {
        triangle: first,
        point: take(&start, "start")?,
    };
    let end = Place {
        triangle: last,
        point: take(&end, "end")?,
    };
    compute!(py, vertices, middles, ends, edges, side_start, sides => {
        let edges = Edges { middles, ends, edges, side_start, sides };
        let route = geodesic::search_route(vertices, edges, start, end);
        (route.before, route.leaves, route.via)
    })
}

#[pyfunction]
fn propose<'py>(
    vertices: Rows<'py, f64, 3>,
    normals: Rows<'py, f64, 3>,
    axes: Rows<'py, f64, 3>,
    p: usize,
    q: usize,
    mut out: ItemsMut<'py, f64>,
) -> PyResult<bool> {
    let at = |rows: &[Point], number: usize| {
        let wrong = || PyValueError::new_err(format!("there is no vertex {number}"));
        rows.get(number).copied().ok_or_else(wrong)
    };
    let (place, normal, axis) = (at(&vertices, p)?, at(&normals, p)?, at(&axes, p)?);
    let from = Frame {
        place: &place,
        normal: &normal,
        axis: &axis,
    };
    let [u, v, x, y, z] = &mut *out else {
        return Err(PyValueError::new_err("a proposal has five items"));
    };
    let Some(made) = localmap::propose(from, &at(&vertices, q)?, &at(&normals, q)?) else {
        return Ok(false);
    };
    [*u, *v] = made.step;
    [*x, *y, *z] = made.axis;
    Ok(true)
}

#[pyfunction]
fn spread_front<'py>(
    py: Python<'py>,
    vertices: Rows<'py, f64, 3>,
    normals: Rows<'py, f64, 3>,
    star_start: Items<'py, i32>,
    star: Items<'py, i32>,
    seeds: Items<'py, i32>,
    seed_uv: Rows<'py, f64, 2>,
    seed_axes: Rows<'py, f64, 3>,
    seed_distance: Items<'py, f64>,
    distance: f64,
    low: Items<'py, f64>,
    high: Items<'py, f64>,
) -> Answered<'py> {
    let extent = Extent {
        distance,
        low: *take(&low, "low")?,
        high: *take(&high, "high")?,
    };
    compute!(py, vertices, normals, star_start, star, seeds, seed_uv, seed_axes, seed_distance => {
        let stars = Stars { start: star_start, neighbours: star };
        let seeds =
            Seeds { vertices: seeds, uv: seed_uv, axes: seed_axes, distance: seed_distance };
        let found = localmap::spread_front(vertices, normals, stars, seeds, &extent);
        (found.vertices, found.uv, found.distance)
    })
}

#[pyfunction]
fn find_mapped<'py>(
    py: Python<'py>,
    triangles: Rows<'py, i32, 3>,
    vertices: Rows<'py, f64, 3>,
    found: Items<'py, i32>,
    uv: Rows<'py, f64, 2>,
    torn: f64,
) -> Answered<'py> {
    compute!(py, triangles, vertices, found, uv => {
        localmap::find_mapped(Surface { vertices, triangles }, found, uv, torn)
    })
}

#[pyfunction]
fn file_triangles<'py>(
    py: Python<'py>,
    uv: Rows<'py, f64, 2>,
    corners: Rows<'py, i32, 3>,
) -> Answered<'py> {
    compute!(py, uv, corners => {
        let filed = localmap::file_triangles(uv, corners);
        (filed.frame.to_vec(), filed.start, filed.triangles)
    })
}

#[pyfunction]
fn find_containing<'py>(
    py: Python<'py>,
    uv: Rows<'py, f64, 2>,
    corners: Rows<'py, i32, 3>,
    distance: Items<'py, f64>,
    frame: Rows<'py, f64, 2>,
    start: Items<'py, i32>,
    numbers: Items<'py, i32>,
    wanted: Rows<'py, f64, 2>,
) -> Answered<'py> {
    let frame = take(&frame, "frame")?;
    compute!(py, uv, corners, distance, start, numbers, wanted => {
        let grid = Grid { frame, start, triangles: numbers };
        localmap::find_containing(uv, corners, distance, grid, wanted)
    })
}

#[pyfunction]
fn find_cut_sides<'py>(
    py: Python<'py>,
    triangles: Rows<'py, i32, 3>,
    height: Items<'py, f64>,
    f: usize,
) -> Answered<'py> {
    compute!(py, triangles, height => {
        let found = planarcut::find_cut_sides(triangles, height, f);
        (found.out, found.into)
    })
}

#[pyfunction]
fn place_crossing<'py>(
    py: Python<'py>,
    vertices: Rows<'py, f64, 3>,
    triangles: Rows<'py, i32, 3>,
    height: Items<'py, f64>,
    side: i32,
) -> Answered<'py> {
    compute!(py, vertices, triangles, height => {
        planarcut::place_crossing(Surface { vertices, triangles }, height, side).to_vec()
    })
}

#[pyfunction]
fn follow_cut<'py>(
    py: Python<'py>,
    vertices: Rows<'py, f64, 3>,
    triangles: Rows<'py, i32, 3>,
    across: Items<'py, i32>,
    height: Items<'py, f64>,
    side: i32,
    most: f64,
) -> Answered<'py> {
    compute!(py, vertices, triangles, across, height => {
        let surface = Surface { vertices, triangles };
        let part = planarcut::follow_cut(surface, across, height, side, most);
        (part.sides, part.length, part.closed)
    })
}

/// Return the steps of a strip, of which there is one at least.
fn read_steps(out: &[i32], into: &[i32]) -> PyResult<Vec<Step>> {
    if out.is_empty() || out.len() != into.len() {
        return Err(PyValueError::new_err(
            "a strip has as many sides out as into, and one at least",
        ));
    }
    let step = |(&out, &into)| Step { out, into };
    Ok(out.iter().zip(into).map(step).collect())
}

/// Return the gates of a strip, of which there are two at least.
fn read_gates<'a>(
    vertices: &'a [[i32; 2]],
    places: &'a [[[f64; 2]; 2]],
    ends: &'a [[f64; 2]],
) -> PyResult<Gates<'a>> {
    if vertices.len() < 2 || vertices.len() != places.len() {
        return Err(PyValueError::new_err(
            "gates have as many vertices as places, and two rows at least",
        ));
    }
    Ok(Gates {
        vertices,
        places,
        ends: take(ends, "ends")?,
    })
}

#[pyfunction]
fn unfold_strip<'py>(
    py: Python<'py>,
    vertices: Rows<'py, f64, 3>,
    triangles: Rows<'py, i32, 3>,
    out: Items<'py, i32>,
    into: Items<'py, i32>,
    start: Items<'py, f64>,
    end: Items<'py, f64>,
) -> Answered<'py> {
    let steps = read_steps(&out, &into)?;
    let (start, end) = (take(&start, "start")?, take(&end, "end")?);
    compute!(py, vertices, triangles => {
        let made = shortening::unfold_strip(Surface { vertices, triangles }, &steps, start, end);
        (made.vertices, made.places, made.ends.to_vec())
    })
}

#[pyfunction]
fn pull_tight<'py>(
    py: Python<'py>,
    gate: Rows<'py, i32, 2>,
    flat: Blocks<'py, f64, 2, 2>,
    ends: Rows<'py, f64, 2>,
) -> Answered<'py> {
    let gates = read_gates(&gate, &flat, &ends)?;
    compute!(py, => {
        let (turns, length) = shortening::pull_tight(gates);
        let numbers = of_each(&turns, |turn| turn.gate as i32);
        (numbers, of_each(&turns, |turn| turn.side as i32), length)
    })
}

#[pyfunction]
fn shorten_strip<'py>(
    py: Python<'py>,
    vertices: Rows<'py, f64, 3>,
    triangles: Rows<'py, i32, 3>,
    across: Items<'py, i32>,
    out: Items<'py, i32>,
    into: Items<'py, i32>,
    start: Items<'py, f64>,
    end: Items<'py, f64>,
) -> Answered<'py> {
    let steps = read_steps(&out, &into)?;
    let (start, end) = (*take(&start, "start")?, *take(&end, "end")?);
    compute!(py, vertices, triangles, across => {
        let surface = Surface { vertices, triangles };
        let strip = shortening::shorten_strip(surface, across, steps, start, end);
        let out = of_each(&strip.steps, |step| step.out);
        let into = of_each(&strip.steps, |step| step.into);
        (strip.first, out, into, strip.start.to_vec(), strip.end.to_vec())
    })
}

#[pyfunction]
fn cross_gates<'py>(
    py: Python<'py>,
    vertices: Rows<'py, f64, 3>,
    gate: Rows<'py, i32, 2>,
    flat: Blocks<'py, f64, 2, 2>,
    ends: Rows<'py, f64, 2>,
    numbers: Items<'py, i32>,
    which: Items<'py, i32>,
) -> Answered<'py> {
    let gates = read_gates(&gate, &flat, &ends)?;
    let turn = |(&gate, &side): (&i32, &i32)| Turn {
        gate: gate as usize,
        side: side as usize,
    };
    let turns: Vec<Turn> = numbers.iter().zip(&*which).map(turn).collect();
    compute!(py, vertices => shortening::cross_gates(vertices, gates, &turns))
}

// The network.

#[pyfunction]
fn find_departure<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    backwards: bool,
    reach: f64,
) -> Answered<'py> {
    compute!(py, points => attaching::find_departure(points, backwards, reach).to_vec())
}

#[pyfunction]
fn measure_turn<'py>(
    normal: Items<'py, f64>,
    one: Items<'py, f64>,
    two: Items<'py, f64>,
) -> PyResult<f64> {
    let (one, two) = (take(&one, "one")?, take(&two, "two")?);
    Ok(attaching::measure_turn(take(&normal, "normal")?, one, two))
}

#[pyfunction]
fn cross_chains<'py>(
    py: Python<'py>,
    line: Rows<'py, f64, 3>,
    up: Rows<'py, f64, 3>,
    points: Rows<'py, f64, 3>,
    normals: Rows<'py, f64, 3>,
    starts: Items<'py, i32>,
    loose: Items<'py, bool>,
) -> Answered<'py> {
    compute!(py, line, up, points, normals, starts, loose => {
        let line = Line { points: line, normals: up };
        crossings::cross_chains(line, &Samples { points, normals, starts, loose })
    })
}

#[pyfunction]
fn cross_itself<'py>(
    py: Python<'py>,
    line: Rows<'py, f64, 3>,
    aside: Rows<'py, f64, 3>,
    up: Rows<'py, f64, 3>,
    closed: bool,
) -> Answered<'py> {
    compute!(py, line, aside, up => {
        crossings::cross_itself(Line { points: line, normals: up }, aside, closed)
    })
}

#[pyfunction]
fn flood<'py>(
    py: Python<'py>,
    across: Items<'py, i32>,
    crossed: Items<'py, bool>,
    areas: Items<'py, f64>,
    seeds: Items<'py, i32>,
    most: f64,
) -> Answered<'py> {
    compute!(py, across, crossed, areas, seeds => {
        flooding::flood(across, crossed, areas, seeds, most)
    })
}

#[pyfunction]
fn sum_areas<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    normals: Rows<'py, f64, 3>,
) -> Answered<'py> {
    compute!(py, points, normals => {
        let found = patches::sum_areas(points, normals);
        (found.area, found.unsigned, found.length)
    })
}

#[pyfunction]
fn find_nearest<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    normals: Rows<'py, f64, 3>,
    starts: Items<'py, i32>,
    loose: Items<'py, bool>,
    at: Items<'py, f64>,
    up: Items<'py, f64>,
) -> Answered<'py> {
    let (at, up) = (take(&at, "at")?, take(&up, "up")?);
    compute!(py, points, normals, starts, loose => {
        let found = samples::find_nearest(&Samples { points, normals, starts, loose }, at, up);
        (found.sample, found.share, found.distance)
    })
}

// Meshes of quads, and tools.

/// Implements a binding that marks half-edges of a mesh of quads.
macro_rules! bind_separatrices {
    ($name:ident) => {
        #[pyfunction]
        fn $name<'py>(
            py: Python<'py>,
            twin: Items<'py, i32>,
            tail: Items<'py, i32>,
            irregular: Items<'py, bool>,
            border: Items<'py, bool>,
            mut marked: ItemsMut<'py, bool>,
        ) -> Answered<'py> {
            let marked = &mut *marked;
            compute!(py, twin, tail, irregular, border => {
                Separatrices::new(Quads { twin, tail }, irregular, border, marked).$name()
            })
        }
    };
}

bind_separatrices!(run_all);
bind_separatrices!(cut_regular);

#[pyfunction]
fn follow_marked<'py>(
    py: Python<'py>,
    twin: Items<'py, i32>,
    tail: Items<'py, i32>,
    marked: Items<'py, bool>,
    corner: Items<'py, bool>,
) -> Answered<'py> {
    compute!(py, twin, tail, marked, corner => {
        let found = quadgrids::follow_marked(Quads { twin, tail }, marked, corner);
        (found.edges, found.start, found.half)
    })
}

#[pyfunction]
fn read_grid<'py>(
    py: Python<'py>,
    twin: Items<'py, i32>,
    tail: Items<'py, i32>,
    h: i32,
    w: usize,
    n: usize,
) -> Answered<'py> {
    compute!(py, twin, tail => {
        Shaped(quadgrids::read_grid(Quads { twin, tail }, h, w, n), [n + 1, w + 1])
    })
}

#[pyfunction]
fn sum_dots<'py>(
    py: Python<'py>,
    at: Rows<'py, f64, 3>,
    up: Rows<'py, f64, 3>,
    points: Rows<'py, f64, 3>,
    normals: Rows<'py, f64, 3>,
    tensors: Rows<'py, f64, 6>,
    low: Items<'py, f64>,
    keys: Items<'py, i64>,
    starts: Items<'py, i64>,
    width: f64,
) -> Answered<'py> {
    let low = take(&low, "low")?;
    compute!(py, at, up, points, normals, tensors, keys, starts => {
        let dots = Dots { points, normals, tensors, low, keys, starts, width };
        at.iter().zip(up).map(|(at, up)| dots.sum(at, up)).collect::<Vec<_>>()
    })
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    let module = &crate::add_module(parent, "counts")?;
    add_functions!(module, "evening": tie_sides);
    add_functions!(module, "rules": find_irregular, is_cheap);
    add_functions!(module, "tjoin": match_vertices);
    add_functions!(module, "walks": judge_patches, find_walk);
    let module = &crate::add_module(parent, "draft")?;
    add_functions!(module, "crossfield": solve_laplacian);
    add_functions!(module, "remesh": split_long, mark_border, collapse_short, flip_to_valence,
        relax);
    add_functions!(module, "tracing": trace_all);
    let module = &crate::add_module(parent, "filling")?;
    add_functions!(module, "edgecounts": count_bend_edges);
    let module = &crate::add_module(parent, "tracing")?;
    add_functions!(module, "geodesic": search_route);
    add_functions!(module, "localmap": propose, spread_front, find_mapped, file_triangles,
        find_containing);
    add_functions!(module, "planarcut": find_cut_sides, place_crossing, follow_cut);
    add_functions!(module, "shortening": unfold_strip, pull_tight, shorten_strip, cross_gates);
    let module = &crate::add_module(parent, "network")?;
    add_functions!(module, "attaching": find_departure, measure_turn);
    add_functions!(module, "crossings": cross_chains, cross_itself);
    add_functions!(module, "flooding": flood);
    add_functions!(module, "patches": sum_areas);
    add_functions!(module, "samples": find_nearest);
    add_functions!(parent, "quadgrids": run_all, cut_regular, follow_marked, read_grid);
    let module = &crate::add_module(parent, "tools")?;
    add_functions!(module, "salience": sum_dots);
    Ok(())
}
