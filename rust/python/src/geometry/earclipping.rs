//! `patterndb._native.geometry.earclipping`.

use numpy::{PyReadonlyArray2, PyReadwriteArray2};
use patterndb_geometry::earclipping;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::{read_rows, write_rows};

#[pyfunction]
fn clip_ears<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    mut triangles: PyReadwriteArray2<'py, i32>,
) -> PyResult<()> {
    let (points, triangles) = (read_rows(&points)?, write_rows(&mut triangles)?);
    run(py, || {
        triangles.copy_from_slice(&earclipping::clip_ears(points));
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(clip_ears, module)?)
}
