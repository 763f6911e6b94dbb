//! `patterndb._native.query`.

mod holes;
mod placing;
mod relaxed;
mod solving;

use patterndb_query::construct::{pentagon_cuts, plan, reflex_cuts};
use patterndb_query::{expand, recognition};
use pyo3::prelude::*;

use crate::add_module;
use crate::answers::{Answered, add_functions, compute};
use crate::arguments::{Items, Rows};

#[pyfunction]
fn find_pentagon_cuts<'py>(
    py: Python<'py>,
    lengths: Items<'py, i64>,
    counts: Items<'py, i64>,
    ample: i64,
) -> Answered<'py> {
    compute!(py, lengths, counts => {
        let cuts = pentagon_cuts::find_pentagon_cuts(lengths, counts, ample);
        let row = |cut: &pentagon_cuts::PentagonCut| [cut.side as i64, cut.before, cut.after, cut.chord];
        cuts.iter().map(row).collect::<Vec<_>>()
    })
}

#[pyfunction]
fn find_best_places<'py>(py: Python<'py>, gain: Items<'py, i64>) -> Answered<'py> {
    compute!(py, gain => {
        let best = plan::find_best_places(gain);
        (best.gain, best.p, best.a)
    })
}

/// Return the two loops into which a chord cuts one.
#[pyfunction]
#[pyo3(signature = (r#loop, start, end, inner))]
fn split_loop<'py>(
    py: Python<'py>,
    r#loop: Items<'py, i32>,
    start: i64,
    end: i64,
    inner: Items<'py, i32>,
) -> Answered<'py> {
    let vertices = r#loop;
    compute!(py, vertices, inner => {
        let [left, right] = plan::split_loop(vertices, start, end, inner);
        (left, right)
    })
}

/// Return cuts as rows, and guesses of their irregular vertices.
#[pyfunction]
fn list_prolongations<'py>(
    py: Python<'py>,
    lengths: Items<'py, i64>,
    counts: Items<'py, i64>,
    most_perimeter: i64,
) -> Answered<'py> {
    compute!(py, lengths, counts => {
        let cuts = reflex_cuts::list_prolongations(lengths, counts, most_perimeter);
        let rows: Vec<[i64; 5]> = cuts
            .iter()
            .map(|cut| [cut.corner as i64, cut.back.into(), cut.far as i64, cut.place, cut.length])
            .collect();
        (rows, cuts.iter().map(|cut| cut.guess).collect::<Vec<_>>())
    })
}

#[pyfunction]
fn expand_quads<'py>(
    py: Python<'py>,
    twin: Items<'py, i32>,
    across: Items<'py, i32>,
    perimeter: i32,
    first: i32,
    mirrored: bool,
) -> Answered<'py> {
    compute!(py, twin, across => expand::expand_quads(twin, across, perimeter, first, mirrored))
}

#[pyfunction]
fn weld_quads<'py>(
    py: Python<'py>,
    quads: Rows<'py, i32, 4>,
    n_vertices: usize,
    perimeter: i32,
) -> Answered<'py> {
    compute!(py, quads => {
        let (twin, fault) = recognition::weld_quads(quads, n_vertices, perimeter);
        (twin, fault as u8)
    })
}

#[pyfunction]
fn read_code<'py>(
    py: Python<'py>,
    quads: Rows<'py, i32, 4>,
    twin: Items<'py, i32>,
    closed: bool,
) -> Answered<'py> {
    compute!(py, quads, twin => recognition::read_code(quads, twin, closed))
}

#[pyfunction]
fn lengths<'py>(py: Python<'py>, twin: Items<'py, i32>, head: Items<'py, i32>) -> Answered<'py> {
    compute!(py, twin, head => recognition::lengths(twin, head))
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    let module = &add_module(parent, "construct")?;
    add_functions!(module, "pentagon_cuts": find_pentagon_cuts);
    add_functions!(module, "plan": find_best_places, split_loop);
    add_functions!(module, "reflex_cuts": list_prolongations);
    add_functions!(parent, "expand": expand_quads);
    add_functions!(parent, "recognition": lengths, read_code, weld_quads);
    holes::add(&add_module(parent, "holes")?)?;
    placing::add(&add_module(parent, "placing")?)?;
    relaxed::add(&add_module(parent, "relaxed")?)?;
    solving::add(&add_module(parent, "solving")?)
}
