//! `patterndb._native.query.marks.markplaces`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use patterndb_query::marks::markplaces::{self, Bounds, Parting, Records, Unmarked};
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::from_table;

/// The head, labels and polychords of records.
type RecordArrays<'py> = (
    Bound<'py, PyArray2<i32>>,
    Bound<'py, PyArray1<i16>>,
    Bound<'py, PyArray1<i16>>,
);

#[pyfunction]
fn list_records<'py>(
    py: Python<'py>,
    flat: PyReadonlyArray1<'py, u16>,
    offsets: PyReadonlyArray1<'py, i64>,
    n_irregular: PyReadonlyArray1<'py, i32>,
    n_reflex: PyReadonlyArray1<'py, i32>,
    n_marks: usize,
    most: i32,
    free: bool,
    marks: PyReadonlyArray1<'py, i32>,
    slots: PyReadonlyArray1<'py, i32>,
    near: PyReadonlyArray1<'py, i32>,
    far: PyReadonlyArray1<'py, i32>,
) -> PyResult<RecordArrays<'py>> {
    let (flat, offsets) = (read(&flat)?, read(&offsets)?);
    let (n_irregular, n_reflex) = (read(&n_irregular)?, read(&n_reflex)?);
    let [marks, slots, near, far] = [&marks, &slots, &near, &far].map(read);
    let (marks, slots, near, far) = (marks?, slots?, near?, far?);
    let bounds = Bounds {
        n_marks,
        most,
        free,
    };
    let records = run(py, || {
        let partings: Vec<Parting> = (0..marks.len())
            .map(|k| Parting {
                marks: marks[k],
                slots: slots[k],
                near: near[k],
                far: far[k],
            })
            .collect();
        let patterns = offsets.windows(2).zip(n_irregular).zip(n_reflex);
        let patterns = patterns.map(|((ends, &n_irregular), &n_reflex)| Unmarked {
            code: &flat[ends[0] as usize..ends[1] as usize],
            n_irregular,
            n_reflex,
        });
        markplaces::list_records(patterns, bounds, &partings)
    })?;
    let width = Records::width(n_marks);
    Ok((
        from_table(py, records.head.len() / width, width, records.head)?,
        records.label.into_pyarray(py),
        records.chord.into_pyarray(py),
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(list_records, module)?)
}
