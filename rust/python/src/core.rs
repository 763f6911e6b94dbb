//! `patterndb._native.core`.

use numpy::PyArray1;
use patterndb_core::code::{self, Reading, Sense};
use patterndb_core::description::{self, LISTS};
use patterndb_core::reduction::{self, Disk, ReductionWork};
use patterndb_core::{ddqkey, halfedge, polychord, quadmesh, shortcode};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::answers::{Answered, add_functions, compute, place_or_none};
use crate::arguments::{Items, ItemsMut, Rows, RowsMut};
use crate::unlocked::run;

/// Return the sense in which a code is read.
pub fn sense(clockwise: bool) -> Sense {
    if clockwise {
        Sense::Clockwise
    } else {
        Sense::CounterClockwise
    }
}

/// A code to write: 16-bit symbols, or 32-bit symbols for larger disks.
#[derive(FromPyObject)]
enum Symbols<'py> {
    Short(ItemsMut<'py, u16>),
    Long(ItemsMut<'py, i32>),
}

#[pyfunction]
fn rooted_code<'py>(
    py: Python<'py>,
    twin: Items<'py, i32>,
    n_quads: usize,
    start: i32,
    clockwise: bool,
    mut code: Symbols<'py>,
    mut number: ItemsMut<'py, i32>,
    mut entry: ItemsMut<'py, i32>,
    mut order: ItemsMut<'py, i32>,
    best: bool,
) -> PyResult<i8> {
    let twin = &*twin;
    let mut reading = Reading {
        number: &mut number,
        entry: &mut entry,
        order: &mut order,
    };
    let sense = sense(clockwise);
    let state = match &mut code {
        Symbols::Short(code) => {
            let code = &mut **code;
            run(py, || {
                code::rooted_code(twin, n_quads, start, sense, code, &mut reading, best)
            })
        }
        Symbols::Long(code) => {
            let code = &mut **code;
            run(py, || {
                code::rooted_code(twin, n_quads, start, sense, code, &mut reading, best)
            })
        }
    };
    Ok(state? as i8)
}

#[pyfunction]
fn clockwise_start<'py>(py: Python<'py>, twin: Items<'py, i32>, h: i32) -> Answered<'py> {
    compute!(py, twin => code::clockwise_start(twin, h))
}

#[pyfunction]
fn smallest_code<'py>(
    py: Python<'py>,
    twin: Items<'py, i32>,
    n_quads: usize,
    starts: Items<'py, i32>,
    n_starts: usize,
    clockwise: bool,
    mut code: ItemsMut<'py, u16>,
    mut number: ItemsMut<'py, i32>,
    mut entry: ItemsMut<'py, i32>,
    mut order: ItemsMut<'py, i32>,
) -> Answered<'py> {
    let code = &mut *code;
    let mut reading = Reading {
        number: &mut number,
        entry: &mut entry,
        order: &mut order,
    };
    compute!(py, twin, starts => {
        let starts = &starts[..n_starts];
        let (winner, ties) =
            code::smallest_code(twin, n_quads, starts, sense(clockwise), code, &mut reading);
        (place_or_none(winner), ties)
    })
}

#[pyfunction]
fn code_starts<'py>(
    py: Python<'py>,
    twin: Items<'py, i32>,
    mut starts: ItemsMut<'py, i32>,
) -> PyResult<usize> {
    let twin = &*twin;
    let found = run(py, || code::code_starts(twin))?;
    let n_places = starts.len();
    let Some(places) = starts.get_mut(..found.len()) else {
        return Err(PyValueError::new_err(format!(
            "starts has {n_places} places, and there are {} starts",
            found.len()
        )));
    };
    places.copy_from_slice(&found);
    Ok(found.len())
}

#[pyfunction]
fn is_disk_code<'py>(py: Python<'py>, twin: Items<'py, i32>) -> Answered<'py> {
    compute!(py, twin => code::is_disk_code(twin))
}

#[pyfunction]
fn describe<'py>(
    py: Python<'py>,
    flat: Items<'py, u16>,
    offsets: Items<'py, i64>,
) -> Answered<'py> {
    compute!(py, flat, offsets => {
        let mut rows = description::describe(flat, offsets);
        if rows.bad.is_some() {
            // The Python function returns its array uncut then.
            let n = (rows.ends.len() - 1) / LISTS;
            rows.lists.resize(7 * (2 * (flat.len() / 4) + 3 * n), 0);
        }
        (rows.counts, rows.lists, rows.ends, place_or_none(rows.bad))
    })
}

#[pyfunction]
fn fans<'py>(py: Python<'py>, twin: Items<'py, i32>) -> Answered<'py> {
    compute!(py, twin => halfedge::fans(twin))
}

#[pyfunction]
fn border_vertices<'py>(
    py: Python<'py>,
    twin: Items<'py, i32>,
    vertex: Items<'py, i32>,
    n_vertices: usize,
) -> Answered<'py> {
    compute!(py, twin, vertex => halfedge::border_vertices(twin, vertex, n_vertices))
}

#[pyfunction]
fn next_border_edge<'py>(py: Python<'py>, twin: Items<'py, i32>, h: i32) -> Answered<'py> {
    compute!(py, twin => halfedge::next_border_edge(twin, h))
}

#[pyfunction]
fn trace<'py>(py: Python<'py>, twin: Items<'py, i32>) -> Answered<'py> {
    compute!(py, twin => {
        let found = polychord::trace(twin);
        (found.of_edge, found.n_open, found.n)
    })
}

#[pyfunction]
fn flip_to_agree<'py>(
    py: Python<'py>,
    mut quads: RowsMut<'py, i32, 4>,
    start: Items<'py, i64>,
    pairs: Rows<'py, i64, 2>,
) -> Answered<'py> {
    let quads = &mut *quads;
    compute!(py, start, pairs => quadmesh::flip_to_agree(quads, start, pairs))
}

#[pyfunction]
fn components<'py>(py: Python<'py>, twin: Items<'py, i32>) -> Answered<'py> {
    compute!(py, twin => quadmesh::components(twin))
}

/// The arrays of a `ReductionWork` of Python.
#[derive(FromPyObject)]
pub struct WorkArrays<'py> {
    gone: ItemsMut<'py, i64>,
    seen: ItemsMut<'py, i64>,
    stamp: ItemsMut<'py, i64>,
    border: ItemsMut<'py, i32>,
    block: ItemsMut<'py, i32>,
    head: ItemsMut<'py, i32>,
    reduced: ItemsMut<'py, i32>,
    starts: ItemsMut<'py, i32>,
}

impl WorkArrays<'_> {
    /// Borrow the arrays.
    pub fn view(&mut self) -> ReductionWork<'_> {
        ReductionWork {
            gone: &mut self.gone,
            seen: &mut self.seen,
            stamp: &mut self.stamp,
            border: &mut self.border,
            block: &mut self.block,
            head: &mut self.head,
            reduced: &mut self.reduced,
            starts: &mut self.starts,
        }
    }
}

#[pyfunction]
pub fn reduction_work(py: Python<'_>, n_vertices: usize, max_quads: usize) -> Answered<'_> {
    let stamps = |n: usize| PyArray1::<i64>::zeros(py, n, false);
    let sides = || PyArray1::<i32>::zeros(py, 4 * max_quads, false);
    let block = PyArray1::from_vec(py, vec![-1_i32; 4 * max_quads]);
    py.import("patterndb.core.reduction")?
        .getattr("ReductionWork")?
        .call1((
            stamps(n_vertices),
            stamps(n_vertices),
            stamps(2),
            sides(),
            block,
            sides(),
            sides(),
            sides(),
        ))
}

/// Implements a binding of a way to reduce a disk.
macro_rules! bind_reduction {
    ($name:ident) => {
        #[pyfunction]
        fn $name<'py>(
            py: Python<'py>,
            n_quads: usize,
            twin: Items<'py, i32>,
            vertex: Items<'py, i32>,
            count: Items<'py, i32>,
            full: Items<'py, i32>,
            mut work: WorkArrays<'py>,
        ) -> Answered<'py> {
            let mut work = work.view();
            compute!(py, twin, vertex, count, full => {
                let twin = &twin[..4 * n_quads];
                let vertex = &vertex[..4 * n_quads];
                reduction::$name(Disk { twin, vertex, count, full }, &mut work)
            })
        }
    };
}

bind_reduction!(dissolve);
bind_reduction!(dissolve_straight);

#[pyfunction]
fn name_once<'py>(
    py: Python<'py>,
    symbols: Items<'py, i32>,
    offsets: Items<'py, i64>,
) -> Answered<'py> {
    compute!(py, symbols, offsets => {
        let rows = shortcode::name_once(symbols, offsets);
        (rows.flat, rows.ends, place_or_none(rows.bad))
    })
}

#[pyfunction]
fn name_twice<'py>(py: Python<'py>, raw: Items<'py, u8>, ends: Items<'py, i64>) -> Answered<'py> {
    compute!(py, raw, ends => {
        let rows = shortcode::name_twice(raw, ends);
        (rows.flat, rows.ends, place_or_none(rows.bad))
    })
}

#[pyfunction]
fn pack_symbols<'py>(
    py: Python<'py>,
    symbols: Items<'py, u16>,
    offsets: Items<'py, i64>,
) -> Answered<'py> {
    compute!(py, symbols, offsets => {
        let rows = shortcode::pack_symbols(symbols, offsets);
        (rows.flat, rows.ends)
    })
}

#[pyfunction]
fn smallest_key<'py>(py: Python<'py>, code: Items<'py, u16>, clockwise: bool) -> Answered<'py> {
    compute!(py, code => {
        let key = ddqkey::smallest_key(code, sense(clockwise));
        (key.faces, key.twin)
    })
}

#[pyfunction]
fn survey<'py>(py: Python<'py>, twin: Items<'py, i32>) -> Answered<'py> {
    compute!(py, twin => {
        let made = ddqkey::survey(twin);
        (made.chords, made.corners, made.valences, made.n_vertices, made.n_concave)
    })
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "code": rooted_code, clockwise_start, smallest_code, code_starts,
        is_disk_code);
    add_functions!(parent, "description": describe);
    add_functions!(parent, "halfedge": fans, border_vertices, next_border_edge);
    add_functions!(parent, "polychord": trace);
    add_functions!(parent, "quadmesh": flip_to_agree, components);
    add_functions!(parent, "reduction": reduction_work, dissolve, dissolve_straight);
    add_functions!(parent, "shortcode": name_once, name_twice, pack_symbols);
    Ok(())
}

/// Add `patterndb._native.store`, which is called by what reads and writes .ddq files.
pub fn add_store(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "ddqkey": smallest_key, survey);
    Ok(())
}
