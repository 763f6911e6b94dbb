//! Flags by which a caller cancels a computation.

use std::sync::atomic::{AtomicU8, Ordering};

use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A flag that another thread can set: a (1,) uint8 array, other than 0 once it is set.
pub struct CancelFlag<'py>(Bound<'py, PyArray1<u8>>);

impl<'py> CancelFlag<'py> {
    /// Take an array as a flag; ValueError where it has no item.
    pub fn new(array: Bound<'py, PyArray1<u8>>) -> PyResult<CancelFlag<'py>> {
        if array.is_empty() {
            return Err(PyValueError::new_err(
                "a cancel flag is an array of one item",
            ));
        }
        Ok(CancelFlag(array))
    }

    /// Return the flag, to be read without the interpreter's lock.
    pub fn atomic(&self) -> &AtomicU8 {
        // SAFETY: the array has an item, which lives as long as self does, and a byte is aligned
        // everywhere. No reference to it but this one is made: others write the byte through numpy.
        unsafe { AtomicU8::from_ptr(self.0.data()) }
    }
}

/// Return whether a flag is set.
pub fn is_set(flag: &AtomicU8) -> bool {
    flag.load(Ordering::Relaxed) != 0
}
