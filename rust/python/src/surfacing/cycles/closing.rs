//! `patterndb._native.surfacing.cycles.closing`.

use std::ops::ControlFlow;

use numpy::{
    PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1, PyReadwriteArray2, PyUntypedArrayMethods,
};
use patterndb_surfacing::cycles::closing::{self, HalfCurves, Ways};
use pyo3::prelude::*;

use crate::arrays::{read, run, write};
use crate::rows::{read_rows, write_all};

#[pyfunction]
fn measure_ways<'py>(
    py: Python<'py>,
    end: PyReadonlyArray1<'py, i64>,
    length: PyReadonlyArray1<'py, f64>,
    first: PyReadonlyArray1<'py, i64>,
    leaving: PyReadonlyArray1<'py, i64>,
    target: usize,
    mut distance: PyReadwriteArray1<'py, f64>,
    mut near: PyReadwriteArray1<'py, i64>,
) -> PyResult<(usize, f64)> {
    let halves = HalfCurves {
        start: &[],
        end: read(&end)?,
        first: read(&first)?,
        leaving: read(&leaving)?,
    };
    let lengths = read(&length)?;
    let (distance, near) = (write(&mut distance)?, write(&mut near)?);
    run(py, || {
        closing::measure_ways(&halves, lengths, target, distance, near)
    })
}

#[pyfunction]
fn find_closing_paths<'py>(
    py: Python<'py>,
    start: PyReadonlyArray1<'py, i64>,
    end: PyReadonlyArray1<'py, i64>,
    length: PyReadonlyArray1<'py, f64>,
    first: PyReadonlyArray1<'py, i64>,
    leaving: PyReadonlyArray1<'py, i64>,
    distance: PyReadonlyArray1<'py, f64>,
    farther: f64,
    out: usize,
    back: usize,
    mut paths: PyReadwriteArray2<'py, i64>,
    mut sizes: PyReadwriteArray1<'py, i64>,
    most: usize,
) -> PyResult<(usize, bool)> {
    let halves = HalfCurves {
        start: read(&start)?,
        end: read(&end)?,
        first: read(&first)?,
        leaving: read(&leaving)?,
    };
    let lengths = read(&length)?;
    let ways = Ways {
        distance: read(&distance)?,
        farther,
    };
    let width = paths.shape()[1];
    let (paths, sizes) = (write_all(&mut paths)?, write(&mut sizes)?);
    run(py, || {
        let mut rows = paths.chunks_exact_mut(width).zip(sizes);
        let n = rows.len();
        if n == 0 {
            return (0, false);
        }
        let pair = [out, back];
        let cut_short = closing::find_closing_paths(&halves, lengths, ways, pair, most, |cycle| {
            if let Some((row, size)) = rows.next() {
                for (written, &half) in row[..cycle.len()].iter_mut().zip(cycle) {
                    *written = half as i64;
                }
                *size = cycle.len() as i64;
            }
            if rows.len() == 0 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        (n - rows.len(), cut_short)
    })
}

#[pyfunction]
fn find_flat_polygon<'py>(
    py: Python<'py>,
    start: PyReadonlyArray1<'py, i64>,
    end: PyReadonlyArray1<'py, i64>,
    first: PyReadonlyArray1<'py, i64>,
    leaving: PyReadonlyArray1<'py, i64>,
    tangents: PyReadonlyArray2<'py, f64>,
    out: usize,
    back: usize,
    mut path: PyReadwriteArray1<'py, i64>,
) -> PyResult<usize> {
    let halves = HalfCurves {
        start: read(&start)?,
        end: read(&end)?,
        first: read(&first)?,
        leaving: read(&leaving)?,
    };
    let tangents = read_rows(&tangents)?;
    let path = write(&mut path)?;
    run(py, || {
        let found = closing::find_flat_polygon(&halves, tangents, [out, back], path.len());
        let found = found.unwrap_or_default();
        for (written, &half) in path.iter_mut().zip(&found) {
            *written = half as i64;
        }
        found.len()
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(measure_ways, module)?)?;
    module.add_function(wrap_pyfunction!(find_closing_paths, module)?)?;
    module.add_function(wrap_pyfunction!(find_flat_polygon, module)?)
}
