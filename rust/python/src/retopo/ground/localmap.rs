//! `patterndb._native.retopo.ground.localmap`.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1,
};
use patterndb_geometry::Point;
use patterndb_retopo::ground::localmap::{self, Extent, Frame, Grid, Seeds, Stars, Uv};
use patterndb_retopo::ground::topology::Surface;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::read_items;
use crate::arrays::{read, run, write};
use crate::rows::{from_rows, read_blocks, read_rows};

#[pyfunction]
fn propose<'py>(
    vertices: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    axes: PyReadonlyArray2<'py, f64>,
    p: usize,
    q: usize,
    mut out: PyReadwriteArray1<'py, f64>,
) -> PyResult<bool> {
    let (vertices, normals): (&[Point], &[Point]) = (read_rows(&vertices)?, read_rows(&normals)?);
    let axes = read_rows(&axes)?;
    let (Some(place), Some(normal), Some(axis)) = (vertices.get(p), normals.get(p), axes.get(p))
    else {
        return Err(PyValueError::new_err("no such vertex"));
    };
    let (Some(there), Some(up)) = (vertices.get(q), normals.get(q)) else {
        return Err(PyValueError::new_err("no such vertex"));
    };
    let from = Frame {
        place,
        normal,
        axis,
    };
    let [u, v, x, y, z] = write(&mut out)? else {
        return Err(PyValueError::new_err("a proposal has five items"));
    };
    let Some(made) = localmap::propose(from, there, up) else {
        return Ok(false);
    };
    [*u, *v] = made.step;
    [*x, *y, *z] = made.axis;
    Ok(true)
}

type SpreadArrays<'py> = (
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
);

#[pyfunction]
fn spread_front<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    star_start: PyReadonlyArray1<'py, i32>,
    star: PyReadonlyArray1<'py, i32>,
    seeds: PyReadonlyArray1<'py, i32>,
    seed_uv: PyReadonlyArray2<'py, f64>,
    seed_axes: PyReadonlyArray2<'py, f64>,
    seed_distance: PyReadonlyArray1<'py, f64>,
    distance: f64,
    low: PyReadonlyArray1<'py, f64>,
    high: PyReadonlyArray1<'py, f64>,
) -> PyResult<SpreadArrays<'py>> {
    let (vertices, normals) = (read_rows(&vertices)?, read_rows(&normals)?);
    let stars = Stars {
        start: read(&star_start)?,
        neighbours: read(&star)?,
    };
    let seeds = Seeds {
        vertices: read(&seeds)?,
        uv: read_rows(&seed_uv)?,
        axes: read_rows(&seed_axes)?,
        distance: read(&seed_distance)?,
    };
    let extent = Extent {
        distance,
        low: *read_items(&low)?,
        high: *read_items(&high)?,
    };
    let found = run(py, || {
        localmap::spread_front(vertices, normals, stars, seeds, &extent)
    })?;
    Ok((
        found.vertices.into_pyarray(py),
        from_rows(py, found.uv)?,
        found.distance.into_pyarray(py),
    ))
}

type MappedArrays<'py> = (Bound<'py, PyArray1<i32>>, Bound<'py, PyArray2<i32>>);

#[pyfunction]
fn find_mapped<'py>(
    py: Python<'py>,
    triangles: PyReadonlyArray2<'py, i32>,
    vertices: PyReadonlyArray2<'py, f64>,
    found: PyReadonlyArray1<'py, i32>,
    uv: PyReadonlyArray2<'py, f64>,
    torn: f64,
) -> PyResult<MappedArrays<'py>> {
    let surface = Surface {
        vertices: read_rows(&vertices)?,
        triangles: read_rows(&triangles)?,
    };
    let (found, uv) = (read(&found)?, read_rows(&uv)?);
    let (which, corners) = run(py, || localmap::find_mapped(surface, found, uv, torn))?;
    Ok((which.into_pyarray(py), from_rows(py, corners)?))
}

type GridArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
);

#[pyfunction]
fn file_triangles<'py>(
    py: Python<'py>,
    uv: PyReadonlyArray2<'py, f64>,
    corners: PyReadonlyArray2<'py, i32>,
) -> PyResult<GridArrays<'py>> {
    let (uv, corners) = (read_rows(&uv)?, read_rows(&corners)?);
    let filed = run(py, || localmap::file_triangles(uv, corners))?;
    Ok((
        from_rows(py, filed.frame.to_vec())?,
        filed.start.into_pyarray(py),
        filed.triangles.into_pyarray(py),
    ))
}

type HitArrays<'py> = (Bound<'py, PyArray1<i32>>, Bound<'py, PyArray2<f64>>);

#[pyfunction]
fn find_containing<'py>(
    py: Python<'py>,
    uv: PyReadonlyArray2<'py, f64>,
    corners: PyReadonlyArray2<'py, i32>,
    distance: PyReadonlyArray1<'py, f64>,
    frame: PyReadonlyArray2<'py, f64>,
    start: PyReadonlyArray1<'py, i32>,
    numbers: PyReadonlyArray1<'py, i32>,
    wanted: PyReadonlyArray2<'py, f64>,
) -> PyResult<HitArrays<'py>> {
    let (uv, corners) = (read_rows(&uv)?, read_rows(&corners)?);
    let (distance, wanted) = (read(&distance)?, read_rows(&wanted)?);
    let frame: &[[Uv; 3]] = read_blocks(&frame)?;
    let grid = Grid {
        frame: &frame[0],
        start: read(&start)?,
        triangles: read(&numbers)?,
    };
    let (triangle, weights) = run(py, || {
        localmap::find_containing(uv, corners, distance, grid, wanted)
    })?;
    Ok((triangle.into_pyarray(py), from_rows(py, weights)?))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(propose, module)?)?;
    module.add_function(wrap_pyfunction!(spread_front, module)?)?;
    module.add_function(wrap_pyfunction!(find_mapped, module)?)?;
    module.add_function(wrap_pyfunction!(file_triangles, module)?)?;
    module.add_function(wrap_pyfunction!(find_containing, module)?)
}
