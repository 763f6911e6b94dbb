//! The Python module `patterndb._native`: arrays in and out of the concept crates.
//!
//! A submodule here has the name of the Python module that calls it (`_native.core.halfedge` is
//! called by `patterndb.core.halfedge`). Functions release the interpreter's lock while they
//! compute. A panic in a crate reaches Python as `RuntimeError`, see [`unlocked::run`].

mod answers;
mod arguments;
mod core;
mod features;
mod flag;
mod geometry;
mod ingest;
mod query;
mod retopo;
mod surfacing;
mod unlocked;

use pyo3::prelude::*;

/// Add a submodule, from which Python can import, and return it.
fn add_module<'py>(parent: &Bound<'py, PyModule>, name: &str) -> PyResult<Bound<'py, PyModule>> {
    let full = format!("{}.{name}", parent.name()?);
    let made = PyModule::new(parent.py(), &full)?;
    parent.add(name, &made)?;
    // Without this only attributes of the parent could be imported, no names of the module.
    let modules = parent.py().import("sys")?.getattr("modules")?;
    modules.set_item(full, &made)?;
    Ok(made)
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    unlocked::keep_places_of_panics();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    core::add(&add_module(module, "core")?)?;
    features::add(&add_module(module, "features")?)?;
    geometry::add(&add_module(module, "geometry")?)?;
    ingest::add(&add_module(module, "ingest")?)?;
    query::add(&add_module(module, "query")?)?;
    retopo::add(&add_module(module, "retopo")?)?;
    core::add_store(&add_module(module, "store")?)?;
    surfacing::add(&add_module(module, "surfacing")?)?;
    Ok(())
}
