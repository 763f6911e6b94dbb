//! The pulse of searches: an array of two numbers that threads share.

use std::sync::atomic::AtomicI64;

use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The flag that stops searches, and the number of patches met so far.
///
/// Not a borrow of the array as others are: several searches, and Python, use it at a time.
#[expect(unsafe_code, reason = "numpy has no arrays of atomic numbers")]
pub fn share<'a>(pulse: &'a Bound<'_, PyArray1<i64>>) -> PyResult<[&'a AtomicI64; 2]> {
    if pulse.len() != 2 || !pulse.is_contiguous() {
        return Err(PyValueError::new_err("a pulse is an array (2,) of int64"));
    }
    let first = pulse.data();
    if !first.is_aligned() {
        return Err(PyValueError::new_err("a pulse is not aligned"));
    }
    // SAFETY: both numbers are aligned and live as long as the array, which the caller holds; no
    // Rust code reads or writes them but as atomic numbers.
    Ok(unsafe {
        [
            AtomicI64::from_ptr(first),
            AtomicI64::from_ptr(first.add(1)),
        ]
    })
}
