//! `patterndb._native.viewer.skin`.

use numpy::{PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use patterndb_viewer::skin::{self, Crease, Faces, Light, View};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_blocks, from_rows, read_blocks, read_rows};

#[pyfunction]
fn blended<'py>(
    py: Python<'py>,
    triangles: PyReadonlyArray2<'py, i32>,
    offsets: PyReadonlyArray1<'py, i64>,
    around: PyReadonlyArray1<'py, i32>,
    unit: PyReadonlyArray2<'py, f64>,
    area: PyReadonlyArray1<'py, f64>,
    smooth: f64,
    creased: f64,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let faces = Faces {
        triangles: read_rows(&triangles)?,
        offsets: read(&offsets)?,
        around: read(&around)?,
        unit: read_rows(&unit)?,
        area: read(&area)?,
    };
    let crease = Crease { smooth, creased };
    from_blocks(py, run(py, || skin::blend_normals(&faces, crease))?)
}

/// Corners as they are seen, and how bright each is.
type ShadedArrays<'py> = (Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<f32>>);

#[pyfunction]
fn seen<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    normals: PyReadonlyArray3<'py, f64>,
    axes: [[f64; 3]; 3],
    focus: [f64; 3],
    scale: f64,
    key: [f64; 3],
    fill: [f64; 3],
    lights: (f64, f64, f64, f64),
) -> PyResult<ShadedArrays<'py>> {
    let (corners, normals) = (read_blocks(&corners)?, read_blocks(&normals)?);
    let view = View { axes, focus, scale };
    let (ambient, of_key, of_fill, edge) = lights;
    let light = Light {
        key,
        fill,
        ambient,
        of_key,
        of_fill,
        edge,
    };
    let (seen, bright) = run(py, || skin::shade(corners, normals, &view, &light))?;
    Ok((from_blocks(py, seen)?, from_rows(py, bright)?))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(blended, module)?)?;
    module.add_function(wrap_pyfunction!(seen, module)?)
}
