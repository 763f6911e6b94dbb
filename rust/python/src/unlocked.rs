//! Computing without the interpreter's lock, and panics as Python errors.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{self, AssertUnwindSafe, catch_unwind};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

thread_local! {
    /// Source file and line of this thread's last panic.
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Keep the place of a panic for the error that it becomes, and print nothing.
pub fn keep_places_of_panics() {
    panic::set_hook(Box::new(|panic| {
        let place = panic
            .location()
            .map(ToString::to_string)
            .unwrap_or_default();
        PLACE.with(|kept| kept.replace(place));
    }));
}

/// Compute without the interpreter's lock. A panic becomes RuntimeError: PyO3's PanicException does
/// not derive from Exception, so that callers would not catch it.
pub fn run<T: Send>(py: Python<'_>, compute: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(compute)))
        .map_err(|panic| PyRuntimeError::new_err(describe(&*panic)))
}

fn describe(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text
        .or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_default();
    let place = PLACE.with(RefCell::take);
    format!("internal error in the compiled core, at {place}: {text}")
}
