//! `patterndb._native.ingest`.

mod basic;
mod census;
mod growth;
mod hashing;
mod learning;
mod prepare;
mod pulse;
mod shards;

use pyo3::prelude::*;

use crate::add_module;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    basic::add(&add_module(module, "basic")?)?;
    census::add(&add_module(module, "census")?)?;
    growth::add(&add_module(module, "growth")?)?;
    hashing::add(&add_module(module, "hashing")?)?;
    learning::add(&add_module(module, "learning")?)?;
    prepare::add(&add_module(module, "prepare")?)?;
    shards::add(&add_module(module, "shards")?)
}
