//! `patterndb._native.retopo.ground.geodesic`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_retopo::ground::geodesic::{self, Place};
use patterndb_retopo::ground::topology::Edges;
use pyo3::prelude::*;

use super::read_items;
use crate::arrays::{read, run};
use crate::rows::read_rows;

type RouteArrays<'py> = (
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
);

#[pyfunction]
fn search_route<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    middles: PyReadonlyArray2<'py, f64>,
    ends: PyReadonlyArray2<'py, i32>,
    edges: PyReadonlyArray1<'py, i32>,
    side_start: PyReadonlyArray1<'py, i32>,
    sides: PyReadonlyArray1<'py, i32>,
    first: i32,
    start: PyReadonlyArray1<'py, f64>,
    last: i32,
    end: PyReadonlyArray1<'py, f64>,
) -> PyResult<RouteArrays<'py>> {
    let vertices = read_rows(&vertices)?;
    let edges = Edges {
        middles: read_rows(&middles)?,
        ends: read_rows(&ends)?,
        edges: read(&edges)?,
        side_start: read(&side_start)?,
        sides: read(&sides)?,
    };
    let start = Place {
        triangle: first,
        point: read_items(&start)?,
    };
    let end = Place {
        triangle: last,
        point: read_items(&end)?,
    };
    let route = run(py, || geodesic::search_route(vertices, edges, start, end))?;
    Ok((
        route.before.into_pyarray(py),
        route.leaves.into_pyarray(py),
        route.via.into_pyarray(py),
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(search_route, module)?)
}
