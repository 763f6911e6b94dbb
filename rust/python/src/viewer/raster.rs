//! `patterndb._native.viewer.raster`.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray3, PyUntypedArrayMethods};
use patterndb_viewer::raster::{self, Shapes};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{read_rows, write_rows};

#[pyfunction]
fn paint_shapes<'py>(
    py: Python<'py>,
    mut pixels: PyReadwriteArray3<'py, f32>,
    points: PyReadonlyArray2<'py, f64>,
    contours: PyReadonlyArray1<'py, i64>,
    shapes: PyReadonlyArray1<'py, i64>,
    colours: PyReadonlyArray2<'py, f32>,
) -> PyResult<()> {
    let shapes = Shapes {
        points: read_rows(&points)?,
        contours: read(&contours)?,
        shapes: read(&shapes)?,
        colours: read_rows(&colours)?,
    };
    let width = pixels.shape()[1];
    let pixels = write_rows(&mut pixels)?;
    run(py, || raster::paint_shapes(pixels, width, &shapes))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(paint_shapes, module)?)
}
