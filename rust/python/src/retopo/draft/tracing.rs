//! `patterndb._native.retopo.draft.tracing`.

use numpy::{Element, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use patterndb_retopo::draft::tracing::{self, CrossField, Limits, LineSegment, Start, Trace};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_blocks, read_rows};

/// An array of one number for each segment or trace.
type Numbers<'py, T> = Bound<'py, PyArray1<T>>;

/// An array of one place for each segment.
type Places<'py> = Bound<'py, PyArray2<f64>>;

/// Of the segments their lines, triangles, beginnings, ends, distances along and lengths; of the
/// traces how they ended, their lengths, what they met, how far along, and from which side.
type Traced<'py> = (
    Numbers<'py, i32>,
    Numbers<'py, i32>,
    Places<'py>,
    Places<'py>,
    Numbers<'py, f64>,
    Numbers<'py, f64>,
    Numbers<'py, i32>,
    Numbers<'py, f64>,
    Numbers<'py, i32>,
    Numbers<'py, f64>,
    Numbers<'py, bool>,
);

#[pyfunction]
fn trace_all<'py>(
    py: Python<'py>,
    flat: PyReadonlyArray3<'py, f64>,
    side_angle: PyReadonlyArray2<'py, f64>,
    across: PyReadonlyArray1<'py, i32>,
    angle: PyReadonlyArray1<'py, f64>,
    quarters: PyReadonlyArray1<'py, i32>,
    start_triangle: PyReadonlyArray1<'py, i32>,
    start_corner: PyReadonlyArray1<'py, i32>,
    start_place: PyReadonlyArray2<'py, f64>,
    start_angle: PyReadonlyArray1<'py, f64>,
    start_direction: PyReadonlyArray1<'py, i32>,
    wall_line: PyReadonlyArray1<'py, i32>,
    wall_triangle: PyReadonlyArray1<'py, i32>,
    wall_begin: PyReadonlyArray2<'py, f64>,
    wall_end: PyReadonlyArray2<'py, f64>,
    wall_along: PyReadonlyArray1<'py, f64>,
    wall_reach: PyReadonlyArray1<'py, f64>,
    first: i32,
    longest: f64,
    stopping: bool,
) -> PyResult<Traced<'py>> {
    let field = CrossField {
        flat: read_blocks(&flat)?,
        side_angle: read_rows(&side_angle)?,
        across: read(&across)?,
        angle: read(&angle)?,
        quarters: read(&quarters)?,
    };
    let (triangle, corner) = (read(&start_triangle)?, read(&start_corner)?);
    let place = read_rows(&start_place)?;
    let (angle, direction) = (read(&start_angle)?, read(&start_direction)?);
    let starts: Vec<Start> = (0..triangle.len())
        .map(|i| Start {
            triangle: triangle[i],
            corner: corner[i],
            place: place[i],
            angle: angle[i],
            direction: direction[i],
        })
        .collect();
    let (line, triangle) = (read(&wall_line)?, read(&wall_triangle)?);
    let (begin, end) = (read_rows(&wall_begin)?, read_rows(&wall_end)?);
    let (along, reach) = (read(&wall_along)?, read(&wall_reach)?);
    let walls: Vec<LineSegment> = (0..line.len())
        .map(|w| LineSegment {
            line: line[w],
            triangle: triangle[w],
            begin: begin[w],
            end: end[w],
            along: along[w],
            reach: reach[w],
        })
        .collect();
    let limits = Limits {
        first,
        longest,
        stopping,
    };
    let (segments, traces) = run(py, || tracing::trace_all(&field, &starts, &walls, &limits))?;
    Ok((
        of_each(py, &segments, |s| s.line),
        of_each(py, &segments, |s| s.triangle),
        from_rows(py, segments.iter().map(|s| s.begin).collect())?,
        from_rows(py, segments.iter().map(|s| s.end).collect())?,
        of_each(py, &segments, |s| s.along),
        of_each(py, &segments, |s| s.reach),
        of_each(py, &traces, |t: &Trace| t.ended as i32),
        of_each(py, &traces, |t| t.length),
        of_each(py, &traces, |t| t.other),
        of_each(py, &traces, |t| t.there),
        of_each(py, &traces, |t| t.left),
    ))
}

/// Return a number of each item as an array.
fn of_each<'py, S, T: Element>(
    py: Python<'py>,
    items: &[S],
    number: impl Fn(&S) -> T,
) -> Numbers<'py, T> {
    PyArray1::from_iter(py, items.iter().map(number))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(trace_all, module)?)
}
