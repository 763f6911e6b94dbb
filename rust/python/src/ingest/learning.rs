//! `patterndb._native.ingest.learning`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use patterndb_ingest::learning;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::from_rows;

type RowArrays<'py> = (Bound<'py, PyArray1<u8>>, Bound<'py, PyArray1<i64>>);

#[pyfunction]
fn hash_rows<'py>(
    py: Python<'py>,
    raw: PyReadonlyArray1<'py, u8>,
    ends: PyReadonlyArray1<'py, i64>,
) -> PyResult<Bound<'py, PyArray2<u64>>> {
    let (raw, ends) = (read(&raw)?, read(&ends)?);
    let hashes = run(py, || learning::hash_rows(raw, ends))?;
    from_rows(py, hashes)
}

#[pyfunction]
fn pack_faces<'py>(
    py: Python<'py>,
    quads: PyReadonlyArray1<'py, i32>,
    sizes: PyReadonlyArray1<'py, i32>,
    faces: PyReadonlyArray1<'py, i64>,
) -> PyResult<RowArrays<'py>> {
    let (quads, sizes, faces) = (read(&quads)?, read(&sizes)?, read(&faces)?);
    let packed = run(py, || learning::pack_faces(quads, sizes, faces))?;
    Ok((packed.flat.into_pyarray(py), packed.ends.into_pyarray(py)))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(hash_rows, module)?)?;
    module.add_function(wrap_pyfunction!(pack_faces, module)?)
}
