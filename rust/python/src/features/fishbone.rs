//! `patterndb._native.features.fishbone`: a submodule for each Python module there.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use patterndb_features::fishbone::cut::{self, Way};
use patterndb_features::fishbone::tracking::{self, Creases};
use patterndb_features::fishbone::{Ribs, backbone, terms};
use pyo3::prelude::*;

use crate::add_module;
use crate::arrays::{read, run};
use crate::rows::{from_rows, from_table, read_all, read_rows};

fn read_ribs<'a>(
    points: &'a PyReadonlyArray3<'_, f64>,
    first: &'a PyReadonlyArray1<'_, i64>,
    stop: &'a PyReadonlyArray1<'_, i64>,
) -> PyResult<Ribs<'a>> {
    Ok(Ribs {
        points: read_rows(points)?,
        n_rows: points.shape()[1],
        first: read(first)?,
        stop: read(stop)?,
    })
}

type WayArrays<'py> = (Bound<'py, PyArray1<i64>>, f64);

fn make_way(py: Python<'_>, way: Way) -> WayArrays<'_> {
    (way.rows.into_pyarray(py), way.cost)
}

#[pyfunction]
fn cheapest<'py>(
    py: Python<'py>,
    costs: PyReadonlyArray2<'py, f64>,
    cross: PyReadonlyArray1<'py, f64>,
) -> PyResult<WayArrays<'py>> {
    let n_rows = costs.shape()[1];
    let (costs, cross) = (read_all(&costs)?, read(&cross)?);
    let way = run(py, || cut::find_cheapest(costs, n_rows, cross))?;
    Ok(make_way(py, way))
}

#[pyfunction]
fn track<'py>(
    py: Python<'py>,
    costs: PyReadonlyArray2<'py, f64>,
    cross: PyReadonlyArray1<'py, f64>,
    bends: PyReadonlyArray3<'py, f64>,
    change: f64,
    reach: PyReadonlyArray1<'py, i64>,
    leap: f64,
) -> PyResult<WayArrays<'py>> {
    let creases = Creases {
        costs: read_all(&costs)?,
        bends: read_rows(&bends)?,
        n_rows: costs.shape()[1],
        cross: read(&cross)?,
        reach: read(&reach)?,
        change,
        leap,
    };
    let way = run(py, || tracking::track(&creases))?;
    Ok(make_way(py, way))
}

#[pyfunction]
fn carry_backbone<'py>(
    py: Python<'py>,
    points: PyReadonlyArray3<'py, f64>,
    first: PyReadonlyArray1<'py, i64>,
    stop: PyReadonlyArray1<'py, i64>,
    backbone: PyReadonlyArray1<'py, i64>,
    origins: PyReadonlyArray2<'py, f64>,
    start: usize,
    strayed: f64,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let ribs = read_ribs(&points, &first, &stop)?;
    let (backbone, origins) = (read(&backbone)?, read_rows(&origins)?);
    let rows = run(py, || {
        backbone::carry_backbone(&ribs, backbone, origins, start, strayed)
    })?;
    Ok(rows.into_pyarray(py))
}

#[pyfunction]
fn bends<'py>(
    py: Python<'py>,
    points: PyReadonlyArray3<'py, f64>,
    first: PyReadonlyArray1<'py, i64>,
    stop: PyReadonlyArray1<'py, i64>,
    spacing: PyReadonlyArray1<'py, f64>,
    window: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (ribs, spacing) = (read_ribs(&points, &first, &stop)?, read(&spacing)?);
    let bends = run(py, || terms::measure_bends(&ribs, spacing, window))?;
    from_table(py, spacing.len(), ribs.n_rows, bends)
}

#[pyfunction]
fn ways<'py>(
    py: Python<'py>,
    points: PyReadonlyArray3<'py, f64>,
    first: PyReadonlyArray1<'py, i64>,
    stop: PyReadonlyArray1<'py, i64>,
    spacing: PyReadonlyArray1<'py, f64>,
    window: f64,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let (ribs, spacing) = (read_ribs(&points, &first, &stop)?, read(&spacing)?);
    let ways = run(py, || terms::find_ways(&ribs, spacing, window))?;
    from_rows(py, ways)?.reshape([spacing.len(), ribs.n_rows, 3])
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    let module = &add_module(parent, "cut")?;
    module.add_function(wrap_pyfunction!(cheapest, module)?)?;
    let module = &add_module(parent, "fishbone")?;
    module.add_function(wrap_pyfunction!(carry_backbone, module)?)?;
    let module = &add_module(parent, "terms")?;
    module.add_function(wrap_pyfunction!(bends, module)?)?;
    module.add_function(wrap_pyfunction!(ways, module)?)?;
    let module = &add_module(parent, "tracking")?;
    module.add_function(wrap_pyfunction!(track, module)?)
}
