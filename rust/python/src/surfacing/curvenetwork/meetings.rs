//! `patterndb._native.surfacing.curvenetwork.meetings`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_surfacing::curvenetwork::meetings::{self, Boxes, Contact, Edge, Polylines};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_rows, read_rows};

type ContactArrays<'py> = (
    Bound<'py, PyArray2<i64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
);

type JoinArrays<'py> = (
    Bound<'py, PyArray2<i64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i64>>,
);

#[pyfunction]
fn contacts<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    along: PyReadonlyArray1<'py, f64>,
    curve_of: PyReadonlyArray1<'py, i64>,
    edges: PyReadonlyArray1<'py, i64>,
    low: PyReadonlyArray2<'py, f64>,
    high: PyReadonlyArray2<'py, f64>,
    reaches: PyReadonlyArray1<'py, f64>,
    settled: PyReadonlyArray1<'py, bool>,
    limit: usize,
) -> PyResult<ContactArrays<'py>> {
    let lines = Polylines {
        points: read_rows(&points)?,
        along: read(&along)?,
        curve_of: read(&curve_of)?,
    };
    let boxes = Boxes {
        edges: read(&edges)?,
        low: read_rows(&low)?,
        high: read_rows(&high)?,
    };
    let (reaches, settled) = (read(&reaches)?, read(&settled)?);
    let (pairs, places, distances) = run(py, || {
        let found = meetings::find_contacts(lines, boxes, reaches, settled, limit);
        (
            found.iter().map(|contact| contact.edges).collect(),
            found.iter().map(|contact| contact.places).collect(),
            found
                .iter()
                .map(|contact| contact.distance)
                .collect::<Vec<_>>(),
        )
    })?;
    Ok((
        from_rows(py, pairs)?,
        from_rows(py, places)?,
        distances.into_pyarray(py),
    ))
}

#[pyfunction]
fn components<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    curve_of: PyReadonlyArray1<'py, i64>,
    key: PyReadonlyArray1<'py, i64>,
    pairs: PyReadonlyArray2<'py, i64>,
    reaches: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let (points, curve_of) = (read_rows(&points)?, read(&curve_of)?);
    let (keys, pairs, reaches) = (read(&key)?, read_rows(&pairs)?, read(&reaches)?);
    let roots = run(py, || {
        meetings::find_components(points, curve_of, keys, pairs, reaches)
    })?;
    Ok(roots.into_pyarray(py))
}

#[pyfunction]
fn joins<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    curve_of: PyReadonlyArray1<'py, i64>,
    along: PyReadonlyArray1<'py, f64>,
    lasts: PyReadonlyArray1<'py, f64>,
    pairs: PyReadonlyArray2<'py, i64>,
    places: PyReadonlyArray2<'py, f64>,
    distances: PyReadonlyArray1<'py, f64>,
    bounds: PyReadonlyArray1<'py, i64>,
    reaches: PyReadonlyArray1<'py, f64>,
    closed: PyReadonlyArray1<'py, bool>,
) -> PyResult<JoinArrays<'py>> {
    let lines = Polylines {
        points: read_rows(&points)?,
        along: read(&along)?,
        curve_of: read(&curve_of)?,
    };
    let (pairs, places, distances) = (read_rows(&pairs)?, read_rows(&places)?, read(&distances)?);
    let (lasts, closed) = (read(&lasts)?, read(&closed)?);
    let (bounds, reaches) = (read(&bounds)?, read(&reaches)?);
    let made = run(py, || {
        let each = pairs.iter().zip(places).zip(distances);
        let contacts: Vec<Contact> = each
            .map(|((&edges, &places), &distance)| Contact {
                edges,
                places,
                distance,
            })
            .collect();
        meetings::choose_joins(lines, lasts, closed, &contacts, bounds, reaches)
    })?;
    Ok((
        from_rows(py, made.curves)?,
        from_rows(py, made.lengths)?,
        made.gaps.into_pyarray(py),
        made.meetings.into_pyarray(py),
    ))
}

#[pyfunction]
fn find_nearest_of_edges<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    first: usize,
    second: usize,
    margin: f64,
) -> PyResult<(f64, f64, f64)> {
    let points = read_rows(&points)?;
    run(py, || {
        let [first, second] = [first, second].map(|edge| Edge::new(points, edge));
        let ([s, u], gap) = meetings::find_nearest_of_edges(first, second, margin);
        (s, u, gap)
    })
}

#[pyfunction]
fn measure_deviation<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    other: PyReadonlyArray2<'py, f64>,
) -> PyResult<f64> {
    let (points, other) = (read_rows(&points)?, read_rows(&other)?);
    run(py, || meetings::measure_deviation(points, other))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(contacts, module)?)?;
    module.add_function(wrap_pyfunction!(components, module)?)?;
    module.add_function(wrap_pyfunction!(joins, module)?)?;
    module.add_function(wrap_pyfunction!(find_nearest_of_edges, module)?)?;
    module.add_function(wrap_pyfunction!(measure_deviation, module)?)
}
