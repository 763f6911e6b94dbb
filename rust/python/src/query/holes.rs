//! `patterndb._native.query.holes`.

use numpy::PyArray1;
use numpy::ndarray::Ix3;
use patterndb_query::holes::corners::{self as of_corners, Trees};
use patterndb_query::holes::features::{self, Rim};
use patterndb_query::holes::loops::{self, Faces};
use patterndb_query::holes::patterns::{self, Embedding, Tables};
use patterndb_query::holes::projection::{self, Around, Mesh};
use patterndb_query::holes::ranking::{self, Loop};
use patterndb_query::holes::regular::{self, Fill, Paving, TURNS};
use patterndb_query::holes::{candidates, neighbourhood};
use pyo3::prelude::*;

use crate::answers::{Answered, Shaped, add_functions, compute, place_or_none};
use crate::arguments::{Items, Rows, Table};
use crate::flag::{CancelFlag, is_set};

#[pyfunction]
fn measure<'py>(
    py: Python<'py>,
    logs: Rows<'py, f64, 4>,
    regular_valence: Items<'py, i32>,
    assignments: Table<'py, i32>,
) -> Answered<'py> {
    compute!(py, logs, regular_valence, assignments => {
        of_corners::measure(logs, regular_valence, assignments)
    })
}

#[pyfunction]
fn turn_quads<'py>(
    py: Python<'py>,
    quads: Rows<'py, i32, 4>,
    first: i32,
    n: usize,
) -> Answered<'py> {
    compute!(py, quads => candidates::turn_quads(quads, first, n))
}

#[pyfunction]
fn turn_alike<'py>(
    py: Python<'py>,
    face: Items<'py, i32>,
    partner: Items<'py, i32>,
    same: Items<'py, bool>,
    start: Items<'py, i64>,
) -> Answered<'py> {
    compute!(py, face, partner, same, start => {
        let (flip, torn) = loops::turn_alike(Faces { face, twin: partner, start }, same);
        (flip, place_or_none(torn))
    })
}

#[pyfunction]
fn walk_borders<'py>(
    py: Python<'py>,
    border: Items<'py, i32>,
    twin: Items<'py, i32>,
    previous: Items<'py, i32>,
    crowded: Items<'py, bool>,
) -> Answered<'py> {
    compute!(py, border, twin, previous, crowded => {
        loops::walk_borders(border, twin, previous, crowded)
    })
}

#[pyfunction]
fn flood<'py>(
    py: Python<'py>,
    root: usize,
    face: Items<'py, i32>,
    twin: Items<'py, i32>,
    start: Items<'py, i64>,
) -> Answered<'py> {
    compute!(py, face, twin, start => loops::flood(root, Faces { face, twin, start }))
}

/// The Python class `_Tables`.
#[derive(FromPyObject)]
struct TableArrays<'py> {
    first_side: Items<'py, i32>,
    corner: Items<'py, i32>,
    first_edge: Items<'py, i32>,
    chord: Items<'py, i32>,
    n_chords: Items<'py, i32>,
    chiral: Items<'py, bool>,
}

#[pyfunction]
fn enumerate_embeddings<'py>(
    py: Python<'py>,
    loss: Rows<'py, f64, 5, Ix3>,
    n: usize,
    tables: TableArrays<'py>,
    prior: Items<'py, f64>,
    most: usize,
    cancelled: Bound<'py, PyArray1<u8>>,
) -> Answered<'py> {
    /// Return a field of each embedding.
    fn of_each<T>(embeddings: &[Embedding], field: impl Fn(&Embedding) -> T) -> Vec<T> {
        embeddings.iter().map(field).collect()
    }
    let cancelled = CancelFlag::new(cancelled)?;
    let cancelled = cancelled.atomic();
    let tables = Tables {
        first_side: &tables.first_side,
        corner: &tables.corner,
        first_edge: &tables.first_edge,
        chord: &tables.chord,
        n_chords: &tables.n_chords,
        chiral: &tables.chiral,
        prior: &prior,
    };
    compute!(py, loss => {
        let found = patterns::enumerate_embeddings(loss, n, &tables, most, &|| is_set(cancelled));
        (
            of_each(&found, |embedding| embedding.score),
            of_each(&found, |embedding| embedding.pattern),
            of_each(&found, |embedding| embedding.turn),
            of_each(&found, |embedding| embedding.is_mirrored),
            of_each(&found, |embedding| embedding.widths),
        )
    })
}

#[pyfunction]
fn measure_quads<'py>(
    py: Python<'py>,
    quads: Rows<'py, i32, 4>,
    n_vertices: usize,
    regular_valence: Items<'py, i32>,
    clamped_valence: Items<'py, i32>,
    ahead: Rows<'py, f64, 3>,
    logs: Items<'py, f64>,
) -> Answered<'py> {
    compute!(py, quads, regular_valence, clamped_valence, ahead, logs => {
        let of_loop = Loop { regular_valence, clamped_valence, ahead, logs };
        ranking::measure_quads(quads, n_vertices, &of_loop).to_vec()
    })
}

#[pyfunction]
fn fill_walk<'py>(py: Python<'py>, corners: Items<'py, i32>) -> Answered<'py> {
    compute!(py, corners => {
        let none = || Fill { quads: Vec::new(), n_vertices: 0 };
        let fill = regular::fill_walk(corners).unwrap_or_else(none);
        (fill.quads, fill.n_vertices)
    })
}

#[pyfunction]
fn tabulate_rest<'py>(py: Python<'py>, logs: Rows<'py, f64, 4>) -> Answered<'py> {
    compute!(py, logs => {
        let size = logs.len() + 1;
        Shaped(regular::tabulate_rest(logs).into_flattened(), [size, size, size, TURNS])
    })
}

#[pyfunction]
fn pave<'py>(py: Python<'py>, corners: Items<'py, i32>, rings: usize) -> Answered<'py> {
    compute!(py, corners => {
        let none = || Paving {
            quads: Vec::new(),
            inner: Vec::new(),
            counts: Vec::new(),
            n_vertices: 0,
        };
        let paving = regular::pave(corners, rings).unwrap_or_else(none);
        (paving.quads, paving.inner, paving.counts, paving.n_vertices)
    })
}

#[pyfunction]
fn neighbours<'py>(
    py: Python<'py>,
    corners: Items<'py, i64>,
    offsets: Items<'py, i64>,
    quads: Rows<'py, i64, 4>,
    n_points: usize,
) -> Answered<'py> {
    compute!(py, corners, offsets, quads => {
        let made = projection::neighbours(&Mesh { quads, corners, offsets }, n_points);
        (made.start, made.beside)
    })
}

#[pyfunction]
fn laplacian_rows<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    start: Items<'py, i64>,
    beside: Items<'py, i64>,
    n_outer: usize,
    n_loop: usize,
) -> Answered<'py> {
    compute!(py, points, start, beside => {
        let made = projection::laplacian_rows(points, start, beside, n_outer, n_loop);
        (made.row, made.column, made.weight, made.right)
    })
}

#[pyfunction]
fn measure_fill<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    quads: Rows<'py, i64, 4>,
    corners: Items<'py, i64>,
    offsets: Items<'py, i64>,
    normals: Rows<'py, f64, 3>,
    beyond: Rows<'py, f64, 3>,
    n_loop: usize,
    n_outer: usize,
    scale: f64,
    area: f64,
) -> Answered<'py> {
    compute!(py, points, quads, corners, offsets, normals, beyond => {
        let mesh = Mesh { quads, corners, offsets };
        let around = Around { normals, beyond, n_loop, n_outer, scale, area };
        let (measures, flipped) = projection::measure_fill(points, mesh, around);
        (measures.to_vec(), flipped)
    })
}

#[pyfunction]
fn count_faces<'py>(
    py: Python<'py>,
    twin: Items<'py, i32>,
    following: Items<'py, i32>,
    h: i32,
) -> Answered<'py> {
    compute!(py, twin, following => neighbourhood::count_faces(twin, following, h))
}

#[pyfunction]
fn measure_fans<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    corners: Items<'py, i32>,
    offsets: Items<'py, i64>,
    n_loop: usize,
) -> Answered<'py> {
    compute!(py, points, corners, offsets => {
        neighbourhood::measure_fans(&neighbourhood::Faces { points, corners, offsets, n_loop })
    })
}

#[pyfunction]
fn find_normals_beyond<'py>(
    py: Python<'py>,
    points: Rows<'py, f64, 3>,
    corners: Items<'py, i32>,
    offsets: Items<'py, i64>,
    n_loop: usize,
) -> Answered<'py> {
    compute!(py, points, corners, offsets => {
        neighbourhood::find_normals_beyond(&neighbourhood::Faces { points, corners, offsets, n_loop })
    })
}

#[pyfunction]
fn own_features<'py>(
    py: Python<'py>,
    r#loop: Rows<'py, f64, 3>,
    normals: Rows<'py, f64, 3>,
    angle_outside: Items<'py, f64>,
    outside: Items<'py, i32>,
    clamped_valence: Items<'py, i32>,
    scale: f64,
    spokes: Items<'py, f64>,
    far: Items<'py, f64>,
) -> Answered<'py> {
    let points = r#loop;
    compute!(py, points, normals, angle_outside, outside, clamped_valence, spokes, far => {
        features::own_features(&Rim {
            points,
            normals,
            angle_outside,
            outside,
            clamped_valence,
            scale,
            spokes,
            far,
        })
    })
}

#[pyfunction]
fn score_trees<'py>(
    py: Python<'py>,
    features: Table<'py, f64>,
    start: Items<'py, i32>,
    feature: Items<'py, i16>,
    threshold: Items<'py, f32>,
    child: Items<'py, i16>,
    value: Items<'py, f32>,
    base: Items<'py, f64>,
) -> Answered<'py> {
    let (n_rows, n_features) = (features.shape()[0], features.shape()[1]);
    compute!(py, features, start, feature, threshold, child, value, base => {
        let trees = Trees { start, feature, threshold, child, value, base };
        Shaped(trees.score(features, n_features), [n_rows, base.len()])
    })
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "candidates": turn_quads);
    add_functions!(parent, "corners": measure, score_trees);
    add_functions!(parent, "features": own_features);
    add_functions!(parent, "loops": turn_alike, walk_borders, flood);
    add_functions!(parent, "neighbourhood": count_faces, measure_fans, find_normals_beyond);
    add_functions!(parent, "patterns": enumerate_embeddings);
    add_functions!(parent, "projection": neighbours, laplacian_rows, measure_fill);
    add_functions!(parent, "ranking": measure_quads);
    add_functions!(parent, "regular": fill_walk, tabulate_rest, pave);
    Ok(())
}
