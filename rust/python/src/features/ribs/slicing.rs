//! `patterndb._native.features.ribs.slicing`.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyReadwriteArray2,
};
use patterndb_features::ribs::slicing::{self, Plane, Surface};
use patterndb_geometry::Point;
use patterndb_geometry::tree::Tree;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::{SegmentArrays, make_segments};
use crate::arrays::{read, run};
use crate::rows::{from_blocks, from_rows, read_blocks, read_rows, write_rows};

/// Return the numbers of an array (3,); ValueError where it has not three.
fn read_point<'a>(array: &'a PyReadonlyArray1<'_, f64>) -> PyResult<&'a Point> {
    let point = read(array)?.try_into();
    point.map_err(|_| PyValueError::new_err("an array is not of 3 numbers"))
}

/// Borrow an origin (3,) and axes (3, 3).
pub(super) fn read_plane<'a>(
    origin: &'a PyReadonlyArray1<'_, f64>,
    axes: &'a PyReadonlyArray2<'_, f64>,
) -> PyResult<Plane<'a>> {
    let axes = read_rows(axes)?.try_into();
    Ok(Plane {
        origin: read_point(origin)?,
        axes: axes.map_err(|_| PyValueError::new_err("a plane has 3 axes"))?,
    })
}

/// Borrow the arrays of a surface.
pub(super) fn read_surface<'a>(
    corners: &'a PyReadonlyArray3<'_, f64>,
    triangles: &'a PyReadonlyArray2<'_, i32>,
    components: &'a PyReadonlyArray1<'_, i32>,
    boxes: &'a PyReadonlyArray3<'_, f64>,
    nodes: &'a PyReadonlyArray2<'_, i32>,
    order: &'a PyReadonlyArray1<'_, i32>,
) -> PyResult<Surface<'a>> {
    Ok(Surface {
        tree: Tree {
            corners: read_blocks(corners)?,
            boxes: read_blocks(boxes)?,
            nodes: read_rows(nodes)?,
            order: read(order)?,
        },
        triangles: read_rows(triangles)?,
        components: read(components)?,
    })
}

#[pyfunction]
fn set_axes<'py>(
    py: Python<'py>,
    normal: PyReadonlyArray1<'py, f64>,
    mut axes: PyReadwriteArray2<'py, f64>,
) -> PyResult<()> {
    let (normal, axes) = (read_point(&normal)?, write_rows(&mut axes)?);
    run(py, || axes.copy_from_slice(&slicing::find_axes(normal)))
}

type CutArrays<'py> = (
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray2<i64>>,
    Bound<'py, PyArray1<i32>>,
);

#[pyfunction]
fn cut_edges<'py>(
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
) -> PyResult<CutArrays<'py>> {
    let surface = read_surface(&corners, &triangles, &components, &boxes, &nodes, &order)?;
    let plane = read_plane(&origin, &axes)?;
    let cut = run(py, || slicing::cut_edges(&surface, &plane, radius))?;
    Ok((
        from_blocks(py, cut.ends)?,
        from_rows(py, cut.keys)?,
        cut.parts.into_pyarray(py),
    ))
}

#[pyfunction]
fn join_edges<'py>(
    py: Python<'py>,
    ends: PyReadonlyArray3<'py, f64>,
    keys: PyReadonlyArray2<'py, i64>,
    tolerance: f64,
) -> PyResult<SegmentArrays<'py>> {
    let (ends, keys) = (read_blocks(&ends)?, read_rows(&keys)?);
    make_segments(py, run(py, || slicing::join_edges(ends, keys, tolerance))?)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(set_axes, module)?)?;
    module.add_function(wrap_pyfunction!(cut_edges, module)?)?;
    module.add_function(wrap_pyfunction!(join_edges, module)?)
}
