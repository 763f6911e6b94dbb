//! `patterndb._native.surfacing.chords.search`.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use patterndb_surfacing::chords::search::CutProblem;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

use crate::arrays::run;
use crate::rows::read_rows;

type Positions<'py> = Bound<'py, PyArray1<i64>>;

#[pyfunction]
fn solve<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    own: PyReadonlyArray2<'py, f64>,
    chords: PyReadonlyArray2<'py, i64>,
    alpha: f64,
    printed: bool,
) -> PyResult<(i64, f64, Positions<'py>, Positions<'py>, Positions<'py>)> {
    let problem = CutProblem {
        points: read_rows(&points)?,
        own: read_rows(&own)?,
        chords: read_rows(&chords)?,
        alpha,
        printed,
    };
    let cuts = run(py, || problem.solve())?;
    let cuts = cuts.map_err(|error| PyMemoryError::new_err(error.to_string()))?;
    let from_places = |places: Vec<usize>| {
        let places: Vec<i64> = places.into_iter().map(|place| place as i64).collect();
        places.into_pyarray(py)
    };
    Ok((
        cuts.n_subproblems,
        cuts.cost,
        from_places(cuts.chosen),
        from_places(cuts.bounds),
        from_places(cuts.positions),
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(solve, module)?)
}
