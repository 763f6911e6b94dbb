//! `patterndb._native.retopo.network.patches`.

use numpy::PyReadonlyArray2;
use patterndb_retopo::network::patches;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::read_rows;

#[pyfunction]
fn sum_areas<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
) -> PyResult<(f64, f64, f64)> {
    let (points, normals) = (read_rows(&points)?, read_rows(&normals)?);
    let found = run(py, || patches::sum_areas(points, normals))?;
    Ok((found.area, found.unsigned, found.length))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(sum_areas, module)?)
}
