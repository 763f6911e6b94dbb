//! Arrays as arguments: each borrows a numpy array and derefs to a slice of its items.
//!
//! An array that is not contiguous, or that has other sizes than a kernel reads, raises `ValueError`
//! with the argument's name; one of another type raises `TypeError`.

use std::ops::{Deref, DerefMut};

use numpy::ndarray::{Dimension, Ix1, Ix2, Ix3};
use numpy::{
    Element, PyArray, PyArrayMethods, PyReadonlyArray, PyReadwriteArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The items of an array to read, the last axis first.
pub struct Items<'py, T: Element, D: Dimension = Ix1>(PyReadonlyArray<'py, T, D>);

/// The items of an array to write to.
pub struct ItemsMut<'py, T: Element, D: Dimension = Ix1>(PyReadwriteArray<'py, T, D>);

/// The rows of an array (n, N) to read, or with `Ix3` of an array (m, n, N).
pub struct Rows<'py, T: Element, const N: usize, D: Dimension = Ix2>(Items<'py, T, D>);

/// The rows of an array (n, N) to write to, or with `Ix3` of an array (m, n, N).
pub struct RowsMut<'py, T: Element, const N: usize, D: Dimension = Ix2>(ItemsMut<'py, T, D>);

/// The blocks of an array (n, M, N) to read.
pub struct Blocks<'py, T: Element, const M: usize, const N: usize>(Items<'py, T, Ix3>);

/// The items of an array (n, columns) to read.
pub type Table<'py, T> = Items<'py, T, Ix2>;

/// The items of an array (n, columns) to write to.
pub type TableMut<'py, T> = ItemsMut<'py, T, Ix2>;

/// Check that an array is contiguous, its last axis first, and that its last axes have some sizes.
fn check<'py>(array: &impl PyUntypedArrayMethods<'py>, last: &[usize]) -> PyResult<()> {
    let shape = array.shape();
    if !array.is_c_contiguous() {
        return Err(PyValueError::new_err(format!(
            "an array {shape:?} is not contiguous"
        )));
    }
    if !shape.ends_with(last) {
        let wanted = format!("its last sizes must be {last:?}");
        return Err(PyValueError::new_err(format!(
            "an array is {shape:?}; {wanted}"
        )));
    }
    Ok(())
}

impl<'py, T: Element, D: Dimension> Items<'py, T, D> {
    /// Return the sizes of the axes.
    pub fn shape(&self) -> &[usize] {
        self.0.shape()
    }
}

impl<'py, T: Element, D: Dimension> ItemsMut<'py, T, D> {
    /// Return the sizes of the axes.
    pub fn shape(&self) -> &[usize] {
        self.0.shape()
    }
}

impl<T: Element, const N: usize, D: Dimension> Rows<'_, T, N, D> {
    /// Return the sizes of the axes.
    pub fn shape(&self) -> &[usize] {
        self.0.shape()
    }
}

impl<'a, 'py, T: Element + 'py, D: Dimension + 'py> FromPyObject<'a, 'py> for Items<'py, T, D> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let array = object.cast::<PyArray<T, D>>()?;
        check(&*array, &[])?;
        Ok(Items(array.try_readonly()?))
    }
}

impl<'a, 'py, T: Element + 'py, D: Dimension + 'py> FromPyObject<'a, 'py> for ItemsMut<'py, T, D> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let array = object.cast::<PyArray<T, D>>()?;
        check(&*array, &[])?;
        Ok(ItemsMut(array.try_readwrite()?))
    }
}

impl<'a, 'py, T: Element + 'py, const N: usize, D: Dimension + 'py> FromPyObject<'a, 'py>
    for Rows<'py, T, N, D>
{
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let items = Items::<T, D>::extract(object)?;
        check(&*items.0, &[N])?;
        Ok(Rows(items))
    }
}

impl<'a, 'py, T: Element + 'py, const N: usize, D: Dimension + 'py> FromPyObject<'a, 'py>
    for RowsMut<'py, T, N, D>
{
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let items = ItemsMut::<T, D>::extract(object)?;
        check(&**items.0, &[N])?;
        Ok(RowsMut(items))
    }
}

impl<'a, 'py, T: Element + 'py, const M: usize, const N: usize> FromPyObject<'a, 'py>
    for Blocks<'py, T, M, N>
{
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let items = Items::<T, Ix3>::extract(object)?;
        check(&*items.0, &[M, N])?;
        Ok(Blocks(items))
    }
}

/// Why the slices below exist.
const CHECKED: &str = "arrays are contiguous when they are extracted";

impl<T: Element, D: Dimension> Deref for Items<'_, T, D> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.0.as_slice().expect(CHECKED)
    }
}

impl<T: Element, D: Dimension> Deref for ItemsMut<'_, T, D> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.0.as_slice().expect(CHECKED)
    }
}

impl<T: Element, D: Dimension> DerefMut for ItemsMut<'_, T, D> {
    fn deref_mut(&mut self) -> &mut [T] {
        self.0.as_slice_mut().expect(CHECKED)
    }
}

impl<T: Element, const N: usize, D: Dimension> Deref for Rows<'_, T, N, D> {
    type Target = [[T; N]];

    fn deref(&self) -> &[[T; N]] {
        self.0.as_chunks().0
    }
}

impl<T: Element, const N: usize, D: Dimension> Deref for RowsMut<'_, T, N, D> {
    type Target = [[T; N]];

    fn deref(&self) -> &[[T; N]] {
        self.0.as_chunks().0
    }
}

impl<T: Element, const N: usize, D: Dimension> DerefMut for RowsMut<'_, T, N, D> {
    fn deref_mut(&mut self) -> &mut [[T; N]] {
        self.0.as_chunks_mut().0
    }
}

impl<T: Element, const M: usize, const N: usize> Deref for Blocks<'_, T, M, N> {
    type Target = [[[T; N]; M]];

    fn deref(&self) -> &[[[T; N]; M]] {
        self.0.as_chunks().0.as_chunks().0
    }
}

/// Check that arrays that are read side by side have one length; raises `ValueError`.
pub fn check_lengths(lengths: &[usize]) -> PyResult<()> {
    if lengths.windows(2).all(|pair| pair[0] == pair[1]) {
        return Ok(());
    }
    Err(PyValueError::new_err(format!(
        "arrays that belong together differ in length: {lengths:?}"
    )))
}

/// Return the items of an array that has N of them; raises `ValueError` for another number.
pub fn take<'a, T, const N: usize>(items: &'a [T], name: &str) -> PyResult<&'a [T; N]> {
    let wrong = |_| PyValueError::new_err(format!("{name} has {} items, not {N}", items.len()));
    items.try_into().map_err(wrong)
}
