//! `patterndb._native.surfacing.cycles.measures`.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1, PyReadwriteArray2};
use patterndb_surfacing::cycles::measures::{SampledCurves, measure_cycle};
use pyo3::prelude::*;

use crate::arrays::{read, run, write};
use crate::rows::{read_rows, write_rows};

#[pyfunction]
fn measure<'py>(
    py: Python<'py>,
    steps: PyReadonlyArray1<'py, i64>,
    samples: PyReadonlyArray2<'py, f64>,
    offsets: PyReadonlyArray1<'py, i64>,
    start: PyReadonlyArray1<'py, i64>,
    first: PyReadonlyArray1<'py, i64>,
    leaving: PyReadonlyArray1<'py, i64>,
    tangents: PyReadonlyArray2<'py, f64>,
    mut values: PyReadwriteArray1<'py, f64>,
    mut inward: PyReadwriteArray2<'py, f64>,
) -> PyResult<()> {
    let steps = read(&steps)?;
    let curves = SampledCurves {
        samples: read_rows(&samples)?,
        offsets: read(&offsets)?,
        start: read(&start)?,
        first: read(&first)?,
        leaving: read(&leaving)?,
        tangents: read_rows(&tangents)?,
    };
    let (values, inward) = (write(&mut values)?, write_rows(&mut inward)?);
    run(py, || {
        let found = measure_cycle(steps, &curves, inward);
        values.copy_from_slice(&[
            found.length,
            found.flatness,
            found.area,
            found.bending,
            found.corners,
            found.cuts,
            found.section,
            found.crossed,
        ]);
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(measure, module)?)
}
