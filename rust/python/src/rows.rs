//! Arrays of more than one axis as slices of small arrays, and back.

use numpy::ndarray::Dimension;
use numpy::{
    Element, IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray, PyReadwriteArray,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

fn refuse<T>(wrong: &str) -> PyResult<T> {
    Err(PyValueError::new_err(format!("an array is not {wrong}")))
}

/// Return the rows of an array to read; ValueError where it is not contiguous, or its last axis not
/// N long.
pub fn read_rows<'a, T: Element, D: Dimension, const N: usize>(
    array: &'a PyReadonlyArray<'_, T, D>,
) -> PyResult<&'a [[T; N]]> {
    if array.shape().last() != Some(&N) {
        return refuse(&format!("of {N} columns"));
    }
    Ok(read_all(array)?.as_chunks().0)
}

/// Return the items of an array to read, the last axis first; ValueError where it is not contiguous.
pub fn read_all<'a, T: Element, D: Dimension>(
    array: &'a PyReadonlyArray<'_, T, D>,
) -> PyResult<&'a [T]> {
    if !array.is_c_contiguous() {
        return refuse("contiguous");
    }
    array.as_slice().or_else(|_| refuse("contiguous"))
}

/// Return the (M, N) blocks of an array to read; ValueError where it is not contiguous, or its last
/// axes not M and N long.
pub fn read_blocks<'a, T: Element, D: Dimension, const M: usize, const N: usize>(
    array: &'a PyReadonlyArray<'_, T, D>,
) -> PyResult<&'a [[[T; N]; M]]> {
    if !array.shape().ends_with(&[M, N]) {
        return refuse(&format!("of {M} rows and {N} columns"));
    }
    Ok(read_rows(array)?.as_chunks().0)
}

/// Return the rows of an array to write to; ValueError as of [`read_rows`].
pub fn write_rows<'a, T: Element, D: Dimension, const N: usize>(
    array: &'a mut PyReadwriteArray<'_, T, D>,
) -> PyResult<&'a mut [[T; N]]> {
    if array.shape().last() != Some(&N) {
        return refuse(&format!("of {N} columns"));
    }
    Ok(write_all(array)?.as_chunks_mut().0)
}

/// Return the items of an array to write to, the last axis first; ValueError where it is not
/// contiguous.
pub fn write_all<'a, T: Element, D: Dimension>(
    array: &'a mut PyReadwriteArray<'_, T, D>,
) -> PyResult<&'a mut [T]> {
    if !array.is_c_contiguous() {
        return refuse("contiguous");
    }
    array.as_slice_mut().or_else(|_| refuse("contiguous"))
}

/// Return rows as an array (n, N).
pub fn from_rows<T: Element, const N: usize>(
    py: Python<'_>,
    rows: Vec<[T; N]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    from_table(py, rows.len(), N, rows.into_flattened())
}

/// Return rows of one length, given by the items of one after another, as an array.
pub fn from_table<T: Element>(
    py: Python<'_>,
    n_rows: usize,
    n_columns: usize,
    items: Vec<T>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    items.into_pyarray(py).reshape([n_rows, n_columns])
}
