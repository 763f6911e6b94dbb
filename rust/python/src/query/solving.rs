//! `patterndb._native.query.solving`.

mod batch;
mod evenness;
mod feasibility;
mod halves;
mod jointclaims;
mod matching;
mod sieve;
mod strokes;
mod systems;

use patterndb_query::solving::halves::Class;
use pyo3::prelude::*;

use crate::add_module;

/// Make classes of weight 1 of the sides that they join and their numbers of polychords.
pub fn list_classes(class_i: &[i32], class_j: &[i32], class_n: &[i32]) -> Vec<Class> {
    let columns = class_i.iter().zip(class_j).zip(class_n);
    let class = |((&i, &j), &n): ((&i32, &i32), &i32)| Class {
        i: i as usize,
        j: j as usize,
        n,
        weight: 1,
    };
    columns.map(class).collect()
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    batch::add(&add_module(module, "batch")?)?;
    evenness::add(&add_module(module, "evenness")?)?;
    feasibility::add(&add_module(module, "feasibility")?)?;
    halves::add(&add_module(module, "halves")?)?;
    jointclaims::add(&add_module(module, "jointclaims")?)?;
    matching::add(&add_module(module, "matching")?)?;
    sieve::add(&add_module(module, "sieve")?)?;
    strokes::add(&add_module(module, "strokes")?)?;
    systems::add(&add_module(module, "systems")?)
}
