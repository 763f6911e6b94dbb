//! `patterndb._native.features`.

use numpy::ndarray::Ix3;
use patterndb_features::fishbone::cut::{self, Way};
use patterndb_features::fishbone::tracking::{self, Creases};
use patterndb_features::fishbone::{Ribs, backbone, terms};
use patterndb_features::ribs::raster::{self, Picture};
use patterndb_features::ribs::slicing::{self, Plane, Surface};
use patterndb_features::ribs::{Segments, polygon, rib};
use patterndb_features::splines::fit::Basis;
use patterndb_features::splines::knots;
use patterndb_geometry::tree::Tree;
use pyo3::prelude::*;

use crate::answers::{Answered, Shaped, add_functions, compute, place_or_none};
use crate::arguments::{Blocks, Items, Rows, RowsMut, Table, TableMut, take};

/// Return the rows and the cost of a way.
fn split_way(way: Way) -> (Vec<i64>, f64) {
    (way.rows, way.cost)
}

#[pyfunction]
fn cheapest<'py>(py: Python<'py>, costs: Table<'py, f64>, cross: Items<'py, f64>) -> Answered<'py> {
    let n_rows = costs.shape()[1];
    compute!(py, costs, cross => split_way(cut::find_cheapest(costs, n_rows, cross)))
}

#[pyfunction]
fn track<'py>(
    py: Python<'py>,
    costs: Table<'py, f64>,
    cross: Items<'py, f64>,
    bends: Rows<'py, f64, 3, Ix3>,
    change: f64,
    reach: Items<'py, i64>,
    leap: f64,
) -> Answered<'py> {
    let n_rows = costs.shape()[1];
    compute!(py, costs, cross, bends, reach => {
        split_way(tracking::track(&Creases { costs, bends, n_rows, cross, reach, change, leap }))
    })
}

#[pyfunction]
fn carry_backbone<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3, Ix3>,
    first: Items<'py, i64>,
    stop: Items<'py, i64>,
    backbone: Items<'py, i64>,
    origins: Rows<'py, f64, 3>,
    start: usize,
    strayed: f64,
) -> Answered<'py> {
    let n_rows = points.shape()[1];
    compute!(py, points, first, stop, backbone, origins => {
        let ribs = Ribs { points, n_rows, first, stop };
        backbone::carry_backbone(&ribs, backbone, origins, start, strayed)
    })
}

#[pyfunction]
fn bends<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3, Ix3>,
    first: Items<'py, i64>,
    stop: Items<'py, i64>,
    spacing: Items<'py, f64>,
    window: f64,
) -> Answered<'py> {
    let n_rows = points.shape()[1];
    compute!(py, points, first, stop, spacing => {
        let ribs = Ribs { points, n_rows, first, stop };
        Shaped(terms::measure_bends(&ribs, spacing, window), [spacing.len(), n_rows])
    })
}

#[pyfunction]
fn ways<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3, Ix3>,
    first: Items<'py, i64>,
    stop: Items<'py, i64>,
    spacing: Items<'py, f64>,
    window: f64,
) -> Answered<'py> {
    let n_rows = points.shape()[1];
    compute!(py, points, first, stop, spacing => {
        let ribs = Ribs { points, n_rows, first, stop };
        let ways = terms::find_ways(&ribs, spacing, window);
        Shaped(ways.into_flattened(), [spacing.len(), n_rows, 3])
    })
}

/// Return points, offsets, closed and rims of segments.
#[expect(clippy::type_complexity, reason = "the fields of Segments, for Python")]
fn split_segments(segments: Segments) -> (Vec<[f64; 2]>, Vec<i32>, Vec<bool>, Vec<[bool; 2]>) {
    let offsets = segments.offsets.iter().map(|&k| k as i32).collect();
    (segments.points, offsets, segments.closed, segments.rims)
}

#[pyfunction]
fn sample_polygon<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 2>,
    closed: bool,
    count: usize,
) -> Answered<'py> {
    compute!(py, points => {
        let samples = polygon::sample_polygon(points, closed, count);
        (samples.places, samples.normals, place_or_none(samples.nearest))
    })
}

/// Copy a picture.
fn read_picture(array: &Table<'_, u64>) -> Picture {
    Picture {
        n_rows: array.shape()[0],
        n_columns: array.shape()[1],
        cells: array.to_vec(),
    }
}

/// Return a picture as an array.
fn split_picture(picture: Picture) -> Shaped<u64, 2> {
    Shaped(picture.cells, [picture.n_rows, picture.n_columns])
}

#[pyfunction]
fn read_ring<'py>(py: Python<'py>, picture: Table<'py, u64>, x: i32, y: i32) -> Answered<'py> {
    let picture = read_picture(&picture);
    compute!(py, => picture.read_ring([x, y]))
}

#[pyfunction]
fn dilate<'py>(py: Python<'py>, picture: Table<'py, u64>) -> Answered<'py> {
    let picture = read_picture(&picture);
    compute!(py, => split_picture(picture.dilate()))
}

#[pyfunction]
fn erode<'py>(
    py: Python<'py>,
    mut picture: TableMut<'py, u64>,
    first: Table<'py, u64>,
) -> Answered<'py> {
    let first = read_picture(&first);
    let (n_rows, n_columns) = (picture.shape()[0], picture.shape()[1]);
    let cells = &mut *picture;
    compute!(py, => {
        let mut eroded = Picture { n_rows, n_columns, cells: cells.to_vec() };
        eroded.erode(&first);
        cells.copy_from_slice(&eroded.cells);
    })
}

#[pyfunction]
fn render_edges<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 2>,
    first: Items<'py, i32>,
    rows: usize,
    columns: usize,
) -> Answered<'py> {
    compute!(py, points, first => {
        let first = first.iter().map(|&k| k as usize);
        let (picture, cells) = raster::render_edges(points, first, rows, columns);
        (split_picture(picture), cells.head, cells.edge, cells.link)
    })
}

#[pyfunction]
fn close_gaps<'py>(py: Python<'py>, picture: Table<'py, u64>, rounds: usize) -> Answered<'py> {
    let picture = read_picture(&picture);
    compute!(py, => split_picture(picture.close_gaps(rounds)))
}

#[pyfunction]
fn find_outer_contour<'py>(
    py: Python<'py>,
    picture: Table<'py, u64>,
    x: f64,
    y: f64,
) -> Answered<'py> {
    let picture = read_picture(&picture);
    compute!(py, => picture.find_outer_contour([x, y]))
}

#[pyfunction]
fn slice_segments<'py>(
    py: Python<'py>,
    corners: Blocks<'py, f64, 3, 3>,
    triangles: Rows<'py, i32, 3>,
    components: Items<'py, i32>,
    boxes: Blocks<'py, f64, 2, 3>,
    nodes: Rows<'py, i32, 2>,
    order: Items<'py, i32>,
    origin: Items<'py, f64>,
    axes: Rows<'py, f64, 3>,
    radius: f64,
    tolerance: f64,
) -> Answered<'py> {
    let plane = Plane {
        origin: take(&origin, "origin")?,
        axes: take(&axes, "axes")?,
    };
    compute!(py, corners, triangles, components, boxes, nodes, order => {
        let tree = Tree { corners, boxes, nodes, order };
        let surface = Surface { tree, triangles, components };
        let sliced = rib::slice_segments(&surface, &plane, radius, tolerance);
        let (points, offsets, closed, rims) = split_segments(sliced.segments);
        let (about, segment) = match sliced.nearest {
            Some(nearest) => (vec![nearest.foot, nearest.normal], nearest.segment as i64),
            None => (vec![[0.0; 2]; 2], -1),
        };
        let gap = sliced.gap.unwrap_or(-1.0);
        (points, offsets, closed, rims, gap, about, segment, sliced.is_mended)
    })
}

#[pyfunction]
fn count_rounds(gap: f64, scale: f64) -> usize {
    rib::count_rounds(gap, scale)
}

#[pyfunction]
fn trace_outline<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 2>,
    offsets: Items<'py, i32>,
    closed: Items<'py, bool>,
    rims: Rows<'py, bool, 2>,
    about: Rows<'py, f64, 2>,
    outward: f64,
    radius: f64,
    rounds: i64,
    gap: f64,
    tolerance: f64,
) -> Answered<'py> {
    let &[foot, normal] = take(&about, "about")?;
    let segments = Segments {
        points: points.to_vec(),
        offsets: offsets.iter().map(|&k| k as usize).collect(),
        closed: closed.to_vec(),
        rims: rims.to_vec(),
    };
    compute!(py, => {
        let about = [foot, normal.map(|x| outward * x)];
        let rounds = usize::try_from(rounds).ok().filter(|&rounds| rounds > 0);
        let outline = rib::trace_outline(&segments, about, radius, rounds, gap, tolerance);
        let [first, last] = outline.ends.map(|ended| ended as i64);
        (outline.polygon, outline.is_closed, outline.rounds, (first, last))
    })
}

#[pyfunction]
fn measure_off_backbone<'py>(py: Python<'py>, points: Rows<'py, f64, 2>) -> Answered<'py> {
    compute!(py, points => rib::measure_off_backbone(points))
}

#[pyfunction]
fn set_axes<'py>(
    py: Python<'py>,
    normal: Items<'py, f64>,
    mut axes: RowsMut<'py, f64, 3>,
) -> Answered<'py> {
    let (normal, axes) = (take(&normal, "normal")?, &mut *axes);
    compute!(py, => axes.copy_from_slice(&slicing::find_axes(normal)))
}

#[pyfunction]
fn cut_edges<'py>(
    py: Python<'py>,
    corners: Blocks<'py, f64, 3, 3>,
    triangles: Rows<'py, i32, 3>,
    components: Items<'py, i32>,
    boxes: Blocks<'py, f64, 2, 3>,
    nodes: Rows<'py, i32, 2>,
    order: Items<'py, i32>,
    origin: Items<'py, f64>,
    axes: Rows<'py, f64, 3>,
    radius: f64,
) -> Answered<'py> {
    let plane = Plane {
        origin: take(&origin, "origin")?,
        axes: take(&axes, "axes")?,
    };
    compute!(py, corners, triangles, components, boxes, nodes, order => {
        let tree = Tree { corners, boxes, nodes, order };
        let surface = Surface { tree, triangles, components };
        let cut = slicing::cut_edges(&surface, &plane, radius);
        (cut.ends, cut.keys, cut.parts)
    })
}

#[pyfunction]
fn join_edges<'py>(
    py: Python<'py>,
    ends: Blocks<'py, f64, 2, 2>,
    keys: Rows<'py, i64, 2>,
    tolerance: f64,
) -> Answered<'py> {
    compute!(py, ends, keys => split_segments(slicing::join_edges(ends, keys, tolerance)))
}

#[pyfunction]
fn normal_bands<'py>(
    py: Python<'py>,
    values: Table<'py, f64>,
    first: Items<'py, i32>,
    n: usize,
) -> Answered<'py> {
    let width = values.shape()[1];
    compute!(py, values, first => {
        Shaped(Basis { values, width, first }.normal_bands(n), [width, n])
    })
}

#[pyfunction]
fn times<'py>(
    py: Python<'py>,
    values: Table<'py, f64>,
    first: Items<'py, i32>,
    control: Table<'py, f64>,
) -> Answered<'py> {
    let (width, n_columns) = (values.shape()[1], control.shape()[1]);
    compute!(py, values, first, control => {
        let product = Basis { values, width, first }.multiply(control, n_columns);
        Shaped(product, [first.len(), n_columns])
    })
}

#[pyfunction]
fn transposed<'py>(
    py: Python<'py>,
    values: Table<'py, f64>,
    first: Items<'py, i32>,
    n: usize,
    points: Table<'py, f64>,
) -> Answered<'py> {
    let (width, n_columns) = (values.shape()[1], points.shape()[1]);
    compute!(py, values, first, points => {
        let product = Basis { values, width, first }.multiply_transposed(n, points, n_columns);
        Shaped(product, [n, n_columns])
    })
}

#[pyfunction]
fn count_determined<'py>(
    py: Python<'py>,
    parameters: Items<'py, f64>,
    knots: Items<'py, f64>,
    degree: usize,
) -> Answered<'py> {
    compute!(py, parameters, knots => knots::count_determined(parameters, knots, degree))
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    let module = &crate::add_module(parent, "fishbone")?;
    add_functions!(module, "cut": cheapest);
    add_functions!(module, "fishbone": carry_backbone);
    add_functions!(module, "terms": bends, ways);
    add_functions!(module, "tracking": track);
    let module = &crate::add_module(parent, "ribs")?;
    add_functions!(module, "polygon": sample_polygon);
    add_functions!(module, "raster": read_ring, dilate, erode, render_edges, close_gaps,
        find_outer_contour);
    add_functions!(module, "rib": slice_segments, count_rounds, trace_outline,
        measure_off_backbone);
    add_functions!(module, "slicing": set_axes, cut_edges, join_edges);
    let module = &crate::add_module(parent, "splines")?;
    add_functions!(module, "fit": normal_bands, times, transposed);
    add_functions!(module, "knots": count_determined);
    Ok(())
}
