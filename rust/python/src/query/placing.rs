//! `patterndb._native.query.placing`.

use patterndb_query::placing::laplace::{self, Adjacency};
use patterndb_query::placing::untangle::{self, Movable, Tangle};
use patterndb_query::placing::{flow, region, strands};
use pyo3::prelude::*;

use crate::answers::{Answered, add_functions, compute};
use crate::arguments::{Blocks, Items, Rows, RowsMut, TableMut};

#[pyfunction]
fn measure_open_distance<'py>(
    py: Python<'py>,
    stroke: Rows<'py, f64, 3>,
    middle: Rows<'py, f64, 3>,
) -> Answered<'py> {
    compute!(py, stroke, middle => {
        let found = flow::measure_open_distance(stroke, middle);
        (found.integral, found.mean, found.most)
    })
}

#[pyfunction]
fn measure_loop_distance<'py>(
    py: Python<'py>,
    stroke: Rows<'py, f64, 3>,
    middle: Rows<'py, f64, 3>,
) -> Answered<'py> {
    compute!(py, stroke, middle => {
        let found = flow::measure_loop_distance(stroke, middle);
        let distance = found.distance;
        (distance.integral, distance.mean, distance.most, found.offset, found.against)
    })
}

#[pyfunction]
fn list_open_targets<'py>(
    py: Python<'py>,
    stroke: Rows<'py, f64, 3>,
    middle: Rows<'py, f64, 3>,
) -> Answered<'py> {
    compute!(py, stroke, middle => flow::list_open_targets(stroke, middle))
}

#[pyfunction]
fn list_loop_targets<'py>(
    py: Python<'py>,
    stroke: Rows<'py, f64, 3>,
    middle: Rows<'py, f64, 3>,
    offset: f64,
) -> Answered<'py> {
    compute!(py, stroke, middle => flow::list_loop_targets(stroke, middle, offset))
}

#[pyfunction]
fn relax_inside<'py>(
    py: Python<'py>,
    start: Items<'py, i32>,
    neighbour: Items<'py, i32>,
    fixed: usize,
    mut values: TableMut<'py, f64>,
) -> Answered<'py> {
    let width = values.shape()[1];
    let values = &mut *values;
    compute!(py, start, neighbour => {
        laplace::relax_inside(&Adjacency { start, neighbour, fixed }, width, values)
    })
}

#[pyfunction]
fn relax_within<'py>(
    py: Python<'py>,
    start: Items<'py, i32>,
    neighbour: Items<'py, i32>,
    fixed: usize,
    points: Rows<'py, f64, 3>,
    frames: Blocks<'py, f64, 2, 3>,
) -> Answered<'py> {
    compute!(py, start, neighbour, points, frames => {
        laplace::relax_within(&Adjacency { start, neighbour, fixed }, points, frames)
    })
}

#[pyfunction]
fn measure_edge_energy<'py>(
    py: Python<'py>,
    start: Items<'py, i32>,
    neighbour: Items<'py, i32>,
    points: Rows<'py, f64, 3>,
) -> Answered<'py> {
    compute!(py, start, neighbour, points => {
        laplace::measure_edge_energy(&Adjacency { start, neighbour, fixed: 0 }, points)
    })
}

#[pyfunction]
fn flood_left<'py>(
    py: Python<'py>,
    beside: Rows<'py, i32, 2>,
    barrier: Items<'py, bool>,
    voters: Items<'py, i32>,
    sides: Items<'py, i8>,
) -> Answered<'py> {
    compute!(py, beside, barrier, voters, sides => {
        region::flood_left(beside, barrier, voters, sides)
    })
}

#[pyfunction]
fn walk<'py>(py: Python<'py>, twin: Items<'py, i32>, first: i32) -> Answered<'py> {
    compute!(py, twin => strands::walk(twin, first))
}

#[pyfunction]
fn find_far_ends<'py>(
    py: Python<'py>,
    twin: Items<'py, i32>,
    border: Items<'py, i32>,
) -> Answered<'py> {
    compute!(py, twin, border => strands::find_far_ends(twin, border))
}

#[pyfunction]
fn find_pieces<'py>(
    py: Python<'py>,
    quads: Rows<'py, i32, 4>,
    free: Items<'py, bool>,
) -> Answered<'py> {
    compute!(py, quads, free => untangle::find_pieces(quads, free))
}

// The default of left_over is LEFT of the Python module.
#[pyfunction]
#[pyo3(signature = (quads, wanted, up, free, frames, size, points, left_over=0.75))]
fn minimise_energy<'py>(
    py: Python<'py>,
    quads: Rows<'py, i32, 4>,
    wanted: Rows<'py, bool, 4>,
    up: Rows<'py, f64, 3>,
    free: Items<'py, i32>,
    frames: Blocks<'py, f64, 2, 3>,
    size: f64,
    mut points: RowsMut<'py, f64, 3>,
    left_over: f64,
) -> Answered<'py> {
    let points = &mut *points;
    compute!(py, quads, wanted, up, free, frames => {
        let (tangle, movable) = (Tangle { quads, wanted, up }, Movable { free, frames });
        untangle::minimise_energy(&tangle, &movable, size, points, left_over)
    })
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "flow": measure_open_distance, measure_loop_distance,
        list_open_targets, list_loop_targets);
    add_functions!(parent, "laplace": relax_inside, relax_within, measure_edge_energy);
    add_functions!(parent, "region": flood_left);
    add_functions!(parent, "strands": walk, find_far_ends);
    add_functions!(parent, "untangle": find_pieces, minimise_energy);
    Ok(())
}
