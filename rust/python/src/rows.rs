//! Arrays (n, W) as slices of rows.

use numpy::{Element, IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

fn refuse<const W: usize>() -> PyErr {
    PyValueError::new_err(format!("an array is not contiguous, or not (n, {W})"))
}

/// Return the rows of an array to read; ValueError where it has another width or is not contiguous.
pub fn read_rows<'a, T: Element, const W: usize>(
    array: &'a PyReadonlyArray2<'_, T>,
) -> PyResult<&'a [[T; W]]> {
    let wide = array.as_array().ncols() == W;
    let flat = array.as_slice().ok().filter(|_| wide);
    flat.map(|flat| flat.as_chunks().0).ok_or_else(refuse::<W>)
}

/// Return the rows of an array to write to; ValueError as for [`read_rows`].
pub fn write_rows<'a, T: Element, const W: usize>(
    array: &'a mut PyReadwriteArray2<'_, T>,
) -> PyResult<&'a mut [[T; W]]> {
    let wide = array.as_array().ncols() == W;
    let flat = array.as_slice_mut().ok().filter(|_| wide);
    flat.map(|flat| flat.as_chunks_mut().0)
        .ok_or_else(refuse::<W>)
}

/// Return rows as an array (n, W).
pub fn from_rows<T: Element, const W: usize>(
    py: Python<'_>,
    rows: Vec<[T; W]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let n = rows.len();
    rows.into_flattened().into_pyarray(py).reshape([n, W])
}
