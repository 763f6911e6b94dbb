//! `patterndb._native.features.ribs.rib`.

use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use patterndb_features::ribs::{Segments, rib};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::make_segments;
use super::slicing::{read_plane, read_surface};
use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

type SlicedArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray2<bool>>,
    f64,
    Bound<'py, PyArray2<f64>>,
    i64,
    bool,
);

#[pyfunction]
fn slice_segments<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    triangles: PyReadonlyArray2<'py, i32>,
    components: PyReadonlyArray1<'py, i32>,
    boxes: PyReadonlyArray3<'py, f64>,
    nodes: PyReadonlyArray2<'py, i32>,
    order: PyReadonlyArray1<'py, i32>,
    origin: PyReadonlyArray1<'py, f64>,
    axes: PyReadonlyArray2<'py, f64>,
    radius: f64,
    tolerance: f64,
) -> PyResult<SlicedArrays<'py>> {
    let surface = read_surface(&corners, &triangles, &components, &boxes, &nodes, &order)?;
    let plane = read_plane(&origin, &axes)?;
    let sliced = run(py, || {
        rib::slice_segments(&surface, &plane, radius, tolerance)
    })?;
    let (points, offsets, closed, rims) = make_segments(py, sliced.segments)?;
    let (about, segment) = match sliced.nearest {
        Some(nearest) => (vec![nearest.foot, nearest.normal], nearest.segment as i64),
        None => (vec![[0.0; 2]; 2], -1),
    };
    Ok((
        points,
        offsets,
        closed,
        rims,
        sliced.gap.unwrap_or(-1.0),
        from_rows(py, about)?,
        segment,
        sliced.is_mended,
    ))
}

#[pyfunction]
fn count_rounds(gap: f64, scale: f64) -> usize {
    rib::count_rounds(gap, scale)
}

type OutlineArrays<'py> = (Bound<'py, PyArray2<f64>>, bool, usize, (i64, i64));

#[pyfunction]
fn trace_outline<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    offsets: PyReadonlyArray1<'py, i32>,
    closed: PyReadonlyArray1<'py, bool>,
    rims: PyReadonlyArray2<'py, bool>,
    about: PyReadonlyArray2<'py, f64>,
    outward: f64,
    radius: f64,
    rounds: i64,
    gap: f64,
    tolerance: f64,
) -> PyResult<OutlineArrays<'py>> {
    let &[foot, normal] = read_rows(&about)? else {
        return Err(PyValueError::new_err("a foot and a normal are two rows"));
    };
    let segments = Segments {
        points: read_rows(&points)?.to_vec(),
        offsets: read(&offsets)?.iter().map(|&k| k as usize).collect(),
        closed: read(&closed)?.to_vec(),
        rims: read_rows(&rims)?.to_vec(),
    };
    let outline = run(py, || {
        let about = [foot, normal.map(|x| outward * x)];
        let rounds = usize::try_from(rounds).ok().filter(|&rounds| rounds > 0);
        rib::trace_outline(&segments, about, radius, rounds, gap, tolerance)
    })?;
    let [first, last] = outline.ends.map(|ended| ended as i64);
    Ok((
        from_rows(py, outline.polygon)?,
        outline.is_closed,
        outline.rounds,
        (first, last),
    ))
}

#[pyfunction]
fn measure_off_backbone<'py>(py: Python<'py>, points: PyReadonlyArray2<'py, f64>) -> PyResult<f64> {
    let points = read_rows(&points)?;
    run(py, || rib::measure_off_backbone(points))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(slice_segments, module)?)?;
    module.add_function(wrap_pyfunction!(count_rounds, module)?)?;
    module.add_function(wrap_pyfunction!(trace_outline, module)?)?;
    module.add_function(wrap_pyfunction!(measure_off_backbone, module)?)
}
