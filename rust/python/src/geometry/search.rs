//! `patterndb._native.geometry.tree`, `.proximity` and `.casting`: triangles, and questions to them.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
};
use patterndb_geometry::tree::{self, Boxes, Tree};
use patterndb_geometry::{Point, casting, proximity};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::add_module;
use crate::arrays::{read, run};
use crate::rows::{from_blocks, from_rows, read_blocks, read_rows};

/// Triangles and weights, an entry for each point or line.
type Places<'py> = (Bound<'py, PyArray1<i32>>, Bound<'py, PyArray2<f64>>);

/// Borrow the arrays of a tree.
fn read_tree<'a>(
    corners: &'a PyReadonlyArray3<'_, f64>,
    boxes: &'a PyReadonlyArray3<'_, f64>,
    nodes: &'a PyReadonlyArray2<'_, i32>,
    order: &'a PyReadonlyArray1<'_, i32>,
) -> PyResult<Tree<'a>> {
    Ok(Tree {
        corners: read_blocks(corners)?,
        boxes: read_blocks(boxes)?,
        nodes: read_rows(nodes)?,
        order: read(order)?,
    })
}

/// Return a pair of as many points and directions; ValueError where they are not.
fn pair<'a, T>(points: &'a [Point], others: &'a [T]) -> PyResult<(&'a [Point], &'a [T])> {
    if points.len() != others.len() {
        return Err(PyValueError::new_err("two arrays differ in length"));
    }
    Ok((points, others))
}

fn make_places(py: Python<'_>, found: (Vec<i32>, Vec<[f64; 3]>)) -> PyResult<Places<'_>> {
    Ok((found.0.into_pyarray(py), from_rows(py, found.1)?))
}

type TreeArrays<'py> = (
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray2<i32>>,
    Bound<'py, PyArray1<i32>>,
);

#[pyfunction]
fn build<'py>(py: Python<'py>, corners: PyReadonlyArray3<'py, f64>) -> PyResult<TreeArrays<'py>> {
    let corners = read_blocks(&corners)?;
    let Boxes {
        boxes,
        nodes,
        order,
    } = run(py, || tree::build(corners))?;
    Ok((
        from_blocks(py, boxes)?,
        from_rows(py, nodes)?,
        order.into_pyarray(py),
    ))
}

#[pyfunction]
fn nearest<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    boxes: PyReadonlyArray3<'py, f64>,
    nodes: PyReadonlyArray2<'py, i32>,
    order: PyReadonlyArray1<'py, i32>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<Places<'py>> {
    let tree = read_tree(&corners, &boxes, &nodes, &order)?;
    let points = read_rows(&points)?;
    let found = run(py, || proximity::nearest(&tree, points))?;
    make_places(py, found)
}

#[pyfunction]
fn nearest_facing<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    boxes: PyReadonlyArray3<'py, f64>,
    nodes: PyReadonlyArray2<'py, i32>,
    order: PyReadonlyArray1<'py, i32>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
) -> PyResult<Places<'py>> {
    let tree = read_tree(&corners, &boxes, &nodes, &order)?;
    let (points, normals) = pair(read_rows(&points)?, read_rows(&normals)?)?;
    let found = run(py, || proximity::nearest_facing(&tree, points, normals))?;
    make_places(py, found)
}

#[pyfunction]
fn within_box<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    boxes: PyReadonlyArray3<'py, f64>,
    nodes: PyReadonlyArray2<'py, i32>,
    order: PyReadonlyArray1<'py, i32>,
    low: [f64; 3],
    high: [f64; 3],
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let tree = read_tree(&corners, &boxes, &nodes, &order)?;
    let found = run(py, || proximity::within_box(&tree, &low, &high))?;
    Ok(found.into_pyarray(py))
}

#[pyfunction]
fn first_along<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    boxes: PyReadonlyArray3<'py, f64>,
    nodes: PyReadonlyArray2<'py, i32>,
    order: PyReadonlyArray1<'py, i32>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    reach: PyReadonlyArray1<'py, f64>,
) -> PyResult<Places<'py>> {
    let tree = read_tree(&corners, &boxes, &nodes, &order)?;
    let (points, normals) = pair(read_rows(&points)?, read_rows(&normals)?)?;
    let (_, reach) = pair(points, read(&reach)?)?;
    let found = run(py, || casting::first_along(&tree, points, normals, reach))?;
    make_places(py, found)
}

#[pyfunction]
fn first_ahead<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    boxes: PyReadonlyArray3<'py, f64>,
    nodes: PyReadonlyArray2<'py, i32>,
    order: PyReadonlyArray1<'py, i32>,
    origins: PyReadonlyArray2<'py, f64>,
    directions: PyReadonlyArray2<'py, f64>,
) -> PyResult<Places<'py>> {
    let tree = read_tree(&corners, &boxes, &nodes, &order)?;
    let (origins, directions) = pair(read_rows(&origins)?, read_rows(&directions)?)?;
    let found = run(py, || casting::first_ahead(&tree, origins, directions))?;
    make_places(py, found)
}

type FirstHitArrays<'py> = (
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
);

#[pyfunction]
fn first_hits<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    boxes: PyReadonlyArray3<'py, f64>,
    nodes: PyReadonlyArray2<'py, i32>,
    order: PyReadonlyArray1<'py, i32>,
    origins: PyReadonlyArray2<'py, f64>,
    directions: PyReadonlyArray2<'py, f64>,
) -> PyResult<FirstHitArrays<'py>> {
    let tree = read_tree(&corners, &boxes, &nodes, &order)?;
    let (origins, directions) = pair(read_rows(&origins)?, read_rows(&directions)?)?;
    let found = run(py, || casting::first_hits(&tree, origins, directions))?;
    Ok((
        found.triangle.into_pyarray(py),
        from_rows(py, found.weights)?,
        found.along.into_pyarray(py),
    ))
}

type HitArrays<'py> = (
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
);

#[pyfunction]
fn all_hits<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    boxes: PyReadonlyArray3<'py, f64>,
    nodes: PyReadonlyArray2<'py, i32>,
    order: PyReadonlyArray1<'py, i32>,
    origins: PyReadonlyArray2<'py, f64>,
    directions: PyReadonlyArray2<'py, f64>,
) -> PyResult<HitArrays<'py>> {
    let tree = read_tree(&corners, &boxes, &nodes, &order)?;
    let (origins, directions) = pair(read_rows(&origins)?, read_rows(&directions)?)?;
    let found = run(py, || casting::all_hits(&tree, origins, directions))?;
    Ok((
        found.line.into_pyarray(py),
        found.triangle.into_pyarray(py),
        from_rows(py, found.weights)?,
        found.along.into_pyarray(py),
    ))
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    let module = &add_module(parent, "tree")?;
    module.add_function(wrap_pyfunction!(build, module)?)?;
    let module = &add_module(parent, "proximity")?;
    module.add_function(wrap_pyfunction!(nearest, module)?)?;
    module.add_function(wrap_pyfunction!(nearest_facing, module)?)?;
    module.add_function(wrap_pyfunction!(within_box, module)?)?;
    let module = &add_module(parent, "casting")?;
    module.add_function(wrap_pyfunction!(first_along, module)?)?;
    module.add_function(wrap_pyfunction!(first_ahead, module)?)?;
    module.add_function(wrap_pyfunction!(first_hits, module)?)?;
    module.add_function(wrap_pyfunction!(all_hits, module)?)
}
