//! `patterndb._native.features.ribs`.

mod polygon;
mod raster;
mod rib;
mod slicing;

use numpy::{IntoPyArray, PyArray1, PyArray2};
use patterndb_features::ribs::Segments;
use pyo3::prelude::*;

use crate::add_module;
use crate::rows::from_rows;

/// Points, offsets, closed and rims of segments.
type SegmentArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray2<bool>>,
);

fn make_segments(py: Python<'_>, segments: Segments) -> PyResult<SegmentArrays<'_>> {
    let offsets: Vec<i32> = segments.offsets.iter().map(|&k| k as i32).collect();
    Ok((
        from_rows(py, segments.points)?,
        offsets.into_pyarray(py),
        segments.closed.into_pyarray(py),
        from_rows(py, segments.rims)?,
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    polygon::add(&add_module(module, "polygon")?)?;
    raster::add(&add_module(module, "raster")?)?;
    rib::add(&add_module(module, "rib")?)?;
    slicing::add(&add_module(module, "slicing")?)
}
