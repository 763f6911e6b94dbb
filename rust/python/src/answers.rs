//! What kernels return, as Python objects: lists of items become numpy arrays.

use numpy::ndarray::IxDyn;
use numpy::{Complex64, Element, IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// A Python object that a binding returns.
pub type Answered<'py> = PyResult<Bound<'py, PyAny>>;

/// A value that becomes a Python object.
pub trait Answer<'py> {
    /// Return the Python object.
    fn answer(self, py: Python<'py>) -> Answered<'py>;
}

/// An array of given sizes, by its items, the last axis first.
pub struct Shaped<T, const K: usize>(pub Vec<T>, pub [usize; K]);

/// A place in an array, or -1 for none.
pub fn place_or_none(place: Option<usize>) -> i64 {
    place.map_or(-1, |place| place as i64)
}

/// Implements `Answer` for numbers, and for vectors of numbers, rows and blocks as arrays of one,
/// two and three axes.
macro_rules! answer_numbers {
    ($($number:ty),*) => {$(
        impl<'py> Answer<'py> for $number {
            fn answer(self, py: Python<'py>) -> Answered<'py> {
                Ok(self.into_pyobject(py)?.to_owned().into_any())
            }
        }

        impl<'py> Answer<'py> for Vec<$number> {
            fn answer(self, py: Python<'py>) -> Answered<'py> {
                Ok(self.into_pyarray(py).into_any())
            }
        }

        impl<'py, const N: usize> Answer<'py> for Vec<[$number; N]> {
            fn answer(self, py: Python<'py>) -> Answered<'py> {
                let shape = [self.len(), N];
                Shaped(self.into_flattened(), shape).answer(py)
            }
        }

        impl<'py, const M: usize, const N: usize> Answer<'py> for Vec<[[$number; N]; M]> {
            fn answer(self, py: Python<'py>) -> Answered<'py> {
                let shape = [self.len(), M, N];
                Shaped(self.into_flattened().into_flattened(), shape).answer(py)
            }
        }
    )*};
}

answer_numbers!(bool, u8, i8, u16, i16, u32, i32, u64, i64, usize, f32, f64);

impl<'py, T: Element, const K: usize> Answer<'py> for Shaped<T, K> {
    fn answer(self, py: Python<'py>) -> Answered<'py> {
        let items = self.0.into_pyarray(py);
        Ok(items.reshape(IxDyn(&self.1))?.into_any())
    }
}

impl<'py> Answer<'py> for Vec<Complex64> {
    fn answer(self, py: Python<'py>) -> Answered<'py> {
        Ok(self.into_pyarray(py).into_any())
    }
}

impl<'py> Answer<'py> for () {
    fn answer(self, py: Python<'py>) -> Answered<'py> {
        Ok(py.None().into_bound(py))
    }
}

impl<'py> Answer<'py> for Bound<'py, PyAny> {
    fn answer(self, _: Python<'py>) -> Answered<'py> {
        Ok(self)
    }
}

impl<'py, A: Answer<'py>> Answer<'py> for Option<A> {
    fn answer(self, py: Python<'py>) -> Answered<'py> {
        self.map_or_else(|| ().answer(py), |found| found.answer(py))
    }
}

/// Implements `Answer` for tuples.
macro_rules! answer_tuples {
    ($(($($part:ident),*)),*) => {$(
        impl<'py, $($part: Answer<'py>),*> Answer<'py> for ($($part,)*) {
            #[allow(non_snake_case)]
            fn answer(self, py: Python<'py>) -> Answered<'py> {
                let ($($part,)*) = self;
                Ok(PyTuple::new(py, [$($part.answer(py)?),*])?.into_any())
            }
        }
    )*};
}

answer_tuples!(
    (A, B),
    (A, B, C),
    (A, B, C, D),
    (A, B, C, D, E),
    (A, B, C, D, E, F),
    (A, B, C, D, E, F, G),
    (A, B, C, D, E, F, G, H),
    (A, B, C, D, E, F, G, H, I, J, K)
);

/// Compute without the interpreter's lock and return the Python object of the value. The arrays
/// that are named first are read as slices within.
macro_rules! compute {
    ($py:ident, $($array:ident),* => $value:expr) => {{
        $(let $array = std::ops::Deref::deref(&$array);)*
        $crate::unlocked::run($py, || $value)
            .and_then(|found| $crate::answers::Answer::answer(found, $py))
    }};
}

/// Add functions to a submodule.
macro_rules! add_functions {
    ($parent:expr, $name:literal: $($function:ident),* $(,)?) => {{
        let module = $crate::add_module($parent, $name)?;
        $(module.add_function(pyo3::wrap_pyfunction!($function, &module)?)?;)*
    }};
}

pub(crate) use {add_functions, compute};
