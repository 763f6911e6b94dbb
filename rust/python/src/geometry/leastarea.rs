//! `patterndb._native.geometry.leastarea`.

use numpy::{PyArray2, PyReadonlyArray2, PyReadwriteArray2};
use patterndb_geometry::leastarea::{self, Polyline, Price};
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::{from_rows, from_table, read_all, read_rows, write_rows};

#[pyfunction]
fn triangulate_cheapest<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    shorter: f64,
    thin: f64,
    mut triangles: PyReadwriteArray2<'py, i64>,
) -> PyResult<f64> {
    let (points, triangles) = (read_rows(&points)?, write_rows(&mut triangles)?);
    run(py, || {
        let price = Price { shorter, thin };
        let (made, cost) = leastarea::triangulate_cheapest(points, price);
        for (triangle, made) in triangles.iter_mut().zip(made) {
            *triangle = made.map(|corner| corner as i64);
        }
        cost
    })
}

#[pyfunction]
fn tabulate_areas<'py>(
    py: Python<'py>,
    at: PyReadonlyArray2<'py, f64>,
    barred: PyReadonlyArray2<'py, bool>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (at, barred) = (Polyline::new(read_all(&at)?), read_all(&barred)?);
    let least = run(py, || leastarea::tabulate_areas(&at, barred))?;
    from_table(py, at.x.len(), at.x.len(), least)
}

#[pyfunction]
fn choose_triangles<'py>(
    py: Python<'py>,
    at: PyReadonlyArray2<'py, f64>,
    least: PyReadonlyArray2<'py, f64>,
) -> PyResult<(Bound<'py, PyArray2<i64>>, f64)> {
    let (at, least) = (Polyline::new(read_all(&at)?), read_all(&least)?);
    let (triangles, area) = run(py, || leastarea::choose_triangles(&at, least))?;
    Ok((from_rows(py, triangles)?, area))
}

#[pyfunction]
fn tabulate_areas_around<'py>(
    py: Python<'py>,
    at: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let at = Polyline::new(read_all(&at)?);
    let least = run(py, || leastarea::tabulate_areas_around(&at))?;
    from_table(py, at.x.len(), at.x.len(), least)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(triangulate_cheapest, module)?)?;
    module.add_function(wrap_pyfunction!(tabulate_areas, module)?)?;
    module.add_function(wrap_pyfunction!(choose_triangles, module)?)?;
    module.add_function(wrap_pyfunction!(tabulate_areas_around, module)?)
}
