//! `patterndb._native.geometry`.

use numpy::Complex64;
use patterndb_geometry::leastarea::{self, Polyline, Price};
use patterndb_geometry::relaxation::{self, Disk};
use patterndb_geometry::tree::{self, Tree};
use patterndb_geometry::triangulation::{self, Faces};
use patterndb_geometry::{adjacency, casting, earclipping, neighbours, proximity, quadshape};
use pyo3::prelude::*;

use crate::answers::{Answered, Shaped, add_functions, compute};
use crate::arguments::{Blocks, Items, ItemsMut, Rows, RowsMut, Table, check_lengths};

#[pyfunction]
fn build<'py>(py: Python<'py>, corners: Blocks<'py, f64, 3, 3>) -> Answered<'py> {
    compute!(py, corners => {
        let made = tree::build(corners);
        (made.boxes, made.nodes, made.order)
    })
}

/// Implements a binding of a question to a tree of triangles, which is asked with arrays of one
/// length.
macro_rules! bind_question {
    ($name:ident($($array:ident: $type:ty),*) => $tree:ident, $found:expr) => {
        #[pyfunction]
        fn $name<'py>(
            py: Python<'py>,
            corners: Blocks<'py, f64, 3, 3>,
            boxes: Blocks<'py, f64, 2, 3>,
            nodes: Rows<'py, i32, 2>,
            order: Items<'py, i32>,
            $($array: $type),*
        ) -> Answered<'py> {
            check_lengths(&[$($array.len()),*])?;
            compute!(py, corners, boxes, nodes, order, $($array),* => {
                let $tree = &Tree { corners, boxes, nodes, order };
                $found
            })
        }
    };
}

bind_question!(nearest(points: Rows<'py, f64, 3>) => tree, proximity::nearest(tree, points));
bind_question!(
    nearest_facing(points: Rows<'py, f64, 3>, normals: Rows<'py, f64, 3>) =>
    tree, proximity::nearest_facing(tree, points, normals)
);
bind_question!(
    first_along(points: Rows<'py, f64, 3>, normals: Rows<'py, f64, 3>, reach: Items<'py, f64>) =>
    tree, casting::first_along(tree, points, normals, reach)
);
bind_question!(
    first_hits(origins: Rows<'py, f64, 3>, directions: Rows<'py, f64, 3>) =>
    tree,
    {
        let found = casting::first_hits(tree, origins, directions);
        (found.triangle, found.weights, found.along)
    }
);
bind_question!(
    all_hits(origins: Rows<'py, f64, 3>, directions: Rows<'py, f64, 3>) =>
    tree,
    {
        let found = casting::all_hits(tree, origins, directions);
        (found.line, found.triangle, found.weights, found.along)
    }
);

#[pyfunction]
fn pair_sides<'py>(
    py: Python<'py>,
    vertices: Rows<'py, f64, 3>,
    triangles: Rows<'py, i32, 3>,
    start: Items<'py, i32>,
    sides: Items<'py, i32>,
) -> Answered<'py> {
    compute!(py, vertices, triangles, start, sides => {
        adjacency::pair_sides(vertices, triangles, start, sides)
    })
}

#[pyfunction]
fn walk_parts<'py>(
    py: Python<'py>,
    across: Items<'py, i32>,
    corner: Items<'py, i32>,
) -> Answered<'py> {
    compute!(py, across, corner => adjacency::walk_parts(across, corner))
}

#[pyfunction]
fn clip_ears<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    mut triangles: RowsMut<'py, i32, 3>,
) -> Answered<'py> {
    let triangles = &mut *triangles;
    compute!(py, points => triangles.copy_from_slice(&earclipping::clip_ears(points)))
}

#[pyfunction]
fn triangulate_cheapest<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    shorter: f64,
    thin: f64,
    mut triangles: RowsMut<'py, i64, 3>,
) -> Answered<'py> {
    let triangles = &mut *triangles;
    compute!(py, points => {
        let (made, cost) = leastarea::triangulate_cheapest(points, Price { shorter, thin });
        for (triangle, made) in triangles.iter_mut().zip(made) {
            *triangle = made.map(|corner| corner as i64);
        }
        cost
    })
}

#[pyfunction]
fn tabulate_areas<'py>(
    py: Python<'py>,
    at: Table<'py, f64>,
    barred: Table<'py, bool>,
) -> Answered<'py> {
    compute!(py, at, barred => {
        let at = Polyline::new(at);
        Shaped(leastarea::tabulate_areas(&at, barred), [at.x.len(); 2])
    })
}

#[pyfunction]
fn choose_triangles<'py>(
    py: Python<'py>,
    at: Table<'py, f64>,
    least: Table<'py, f64>,
) -> Answered<'py> {
    compute!(py, at, least => leastarea::choose_triangles(&Polyline::new(at), least))
}

#[pyfunction]
fn tabulate_areas_around<'py>(py: Python<'py>, at: Table<'py, f64>) -> Answered<'py> {
    compute!(py, at => {
        let at = Polyline::new(at);
        Shaped(leastarea::tabulate_areas_around(&at), [at.x.len(); 2])
    })
}

#[pyfunction]
fn join<'py>(
    py: Python<'py>,
    quads: Rows<'py, i32, 4>,
    n_vertices: usize,
    perimeter: usize,
) -> Answered<'py> {
    compute!(py, quads => {
        let made = neighbours::join(quads, n_vertices, perimeter);
        (made.twin, made.start, made.neighbour, made.border)
    })
}

#[pyfunction]
fn squareness<'py>(
    py: Python<'py>,
    quads: Rows<'py, i32, 4>,
    vertices: Rows<'py, f64, 3>,
) -> Answered<'py> {
    compute!(py, quads, vertices => quadshape::squareness(quads, vertices))
}

#[pyfunction]
fn relax_points<'py>(
    py: Python<'py>,
    mut y: ItemsMut<'py, Complex64>,
    handles: usize,
    moving: bool,
    ends: Rows<'py, i32, 3>,
    weights: Rows<'py, f64, 3>,
    quads: Rows<'py, i32, 4>,
    angle: Rows<'py, f64, 4>,
    size: f64,
    rounds: usize,
    steps: usize,
    mut points: ItemsMut<'py, Complex64>,
) -> Answered<'py> {
    let (y, points): (&mut [Complex64], &mut [Complex64]) = (&mut y, &mut points);
    compute!(py, ends, weights, quads, angle => {
        let disk = Disk { handles, moving, ends, weights, quads, angles: angle, size };
        relaxation::relax_points(&disk, y, rounds, steps, points)
    })
}

#[pyfunction]
fn cut<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    corners: Items<'py, i32>,
    offsets: Items<'py, i64>,
) -> Answered<'py> {
    compute!(py, points, corners, offsets => triangulation::cut(points, Faces { corners, offsets }))
}

#[pyfunction]
fn cut_chosen<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    corners: Items<'py, i32>,
    offsets: Items<'py, i64>,
    rows: Items<'py, i64>,
    chosen: Items<'py, i64>,
    mut triangles: RowsMut<'py, i32, 3>,
) -> Answered<'py> {
    let triangles = &mut *triangles;
    compute!(py, points, corners, offsets, rows, chosen => {
        triangulation::cut_chosen(points, Faces { corners, offsets }, rows, chosen, triangles);
    })
}

#[pyfunction]
fn write_once<'py>(py: Python<'py>, face: Items<'py, i32>) -> Answered<'py> {
    compute!(py, face => triangulation::write_once(face))
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "tree": build);
    add_functions!(parent, "proximity": nearest, nearest_facing);
    add_functions!(parent, "casting": first_along, first_hits, all_hits);
    add_functions!(parent, "adjacency": pair_sides, walk_parts);
    add_functions!(parent, "earclipping": clip_ears);
    add_functions!(parent, "leastarea": triangulate_cheapest, tabulate_areas, choose_triangles,
        tabulate_areas_around);
    add_functions!(parent, "neighbours": join);
    add_functions!(parent, "quadshape": squareness);
    add_functions!(parent, "relaxation": relax_points);
    add_functions!(parent, "triangulation": cut, cut_chosen, write_once);
    Ok(())
}
