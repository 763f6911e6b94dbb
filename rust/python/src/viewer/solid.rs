//! `patterndb._native.viewer.solid`.

use numpy::{PyReadonlyArray3, PyReadwriteArray2, PyReadwriteArray3, PyUntypedArrayMethods};
use patterndb_viewer::solid::{self, Canvas};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::{read_blocks, write_all, write_rows};

#[pyfunction]
fn fill_triangles<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    colours: PyReadonlyArray3<'py, f32>,
    mut depth: PyReadwriteArray2<'py, f32>,
    mut image: PyReadwriteArray3<'py, f32>,
) -> PyResult<()> {
    if image.shape()[..2] != *depth.shape() {
        return Err(PyValueError::new_err("image and depth differ in size"));
    }
    let (corners, colours) = (read_blocks(&corners)?, read_blocks(&colours)?);
    let canvas = Canvas {
        width: depth.shape()[1],
        depth: write_all(&mut depth)?,
        image: write_rows(&mut image)?,
    };
    run(py, || solid::fill_triangles(corners, colours, canvas))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(fill_triangles, module)?)
}
