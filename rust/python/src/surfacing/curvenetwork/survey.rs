//! `patterndb._native.surfacing.curvenetwork.survey`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_surfacing::curvenetwork::survey::{self, Candidates, Curves, SeamJoins};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::read_rows;

#[pyfunction]
fn select_seam_joins<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    starts: PyReadonlyArray1<'py, i64>,
    along: PyReadonlyArray1<'py, f64>,
    closed: PyReadonlyArray1<'py, bool>,
    curves: PyReadonlyArray2<'py, i64>,
    lengths: PyReadonlyArray2<'py, f64>,
    gaps: PyReadonlyArray1<'py, f64>,
    ways: PyReadonlyArray2<'py, f64>,
    beside: PyReadonlyArray2<'py, bool>,
    some: PyReadonlyArray1<'py, i64>,
    by_pair: PyReadonlyArray1<'py, i64>,
    begin: PyReadonlyArray1<'py, i64>,
    end: PyReadonlyArray1<'py, i64>,
    reaches: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let joins = SeamJoins {
        curves: read_rows(&curves)?,
        lengths: read_rows(&lengths)?,
        gaps: read(&gaps)?,
        ways: read_rows(&ways)?,
        beside: read_rows(&beside)?,
    };
    let curves = Curves {
        points: read_rows(&points)?,
        starts: read(&starts)?,
        along: read(&along)?,
        closed: read(&closed)?,
        reaches: read(&reaches)?,
    };
    let candidates = Candidates {
        some: read(&some)?,
        by_pair: read(&by_pair)?,
        begin: read(&begin)?,
        end: read(&end)?,
    };
    let kept = run(py, || survey::select_seam_joins(curves, joins, candidates))?;
    Ok(kept.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(select_seam_joins, module)?)
}
