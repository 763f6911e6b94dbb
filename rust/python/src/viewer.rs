//! `patterndb._native.viewer`.

use numpy::ndarray::Ix3;
use patterndb_viewer::raster::{self, Shapes};
use patterndb_viewer::skin::{self, Crease, Faces, Light, View};
use patterndb_viewer::solid::{self, Canvas};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::answers::{Answered, add_functions, compute};
use crate::arguments::{Blocks, Items, Rows, RowsMut, TableMut};

#[pyfunction]
fn paint_shapes<'py>(
    py: Python<'py>,
    mut pixels: RowsMut<'py, f32, 3, Ix3>,
    points: Rows<'py, f64, 2>,
    contours: Items<'py, i64>,
    shapes: Items<'py, i64>,
    colours: Rows<'py, f32, 3>,
) -> Answered<'py> {
    let width = pixels.shape()[1];
    let pixels = &mut *pixels;
    compute!(py, points, contours, shapes, colours => {
        let shapes = Shapes { points, contours, shapes, colours };
        raster::paint_shapes(pixels, width, &shapes);
    })
}

#[pyfunction]
fn blended<'py>(
    py: Python<'py>,
    triangles: Rows<'py, i32, 3>,
    offsets: Items<'py, i64>,
    around: Items<'py, i32>,
    unit: Rows<'py, f64, 3>,
    area: Items<'py, f64>,
    smooth: f64,
    creased: f64,
) -> Answered<'py> {
    compute!(py, triangles, offsets, around, unit, area => {
        let faces = Faces { triangles, offsets, around, unit, area };
        skin::blend_normals(&faces, Crease { smooth, creased })
    })
}

#[pyfunction]
fn seen<'py>(
    py: Python<'py>,
    corners: Blocks<'py, f64, 3, 3>,
    normals: Blocks<'py, f64, 3, 3>,
    axes: [[f64; 3]; 3],
    focus: [f64; 3],
    scale: f64,
    key: [f64; 3],
    fill: [f64; 3],
    lights: (f64, f64, f64, f64),
) -> Answered<'py> {
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
    compute!(py, corners, normals => skin::shade(corners, normals, &view, &light))
}

#[pyfunction]
fn fill_triangles<'py>(
    py: Python<'py>,
    corners: Blocks<'py, f64, 3, 3>,
    colours: Blocks<'py, f32, 3, 3>,
    mut depth: TableMut<'py, f32>,
    mut image: RowsMut<'py, f32, 3, Ix3>,
) -> Answered<'py> {
    if image.shape()[..2] != *depth.shape() {
        return Err(PyValueError::new_err("image and depth differ in size"));
    }
    let width = depth.shape()[1];
    let (depth, image) = (&mut *depth, &mut *image);
    compute!(py, corners, colours => {
        solid::fill_triangles(corners, colours, Canvas { width, depth, image });
    })
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "raster": paint_shapes);
    add_functions!(parent, "skin": blended, seen);
    add_functions!(parent, "solid": fill_triangles);
    Ok(())
}
