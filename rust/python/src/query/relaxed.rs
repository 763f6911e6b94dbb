//! `patterndb._native.query.relaxed`.

use numpy::PyArray1;
use patterndb_query::relaxed::bestmarked::{self, ClassTable, MarkedIndex, MarkedRow, Outline};
use patterndb_query::relaxed::corner_placement::{self, CornerSites, Records, Unmarked};
use patterndb_query::relaxed::family;
use patterndb_query::solving::balance::Class;
use pyo3::prelude::*;

use crate::answers::{Answered, Shaped, add_functions, compute};
use crate::arguments::{Items, Table};
use crate::flag::{CancelFlag, is_set};

/// Return components and colours.
#[pyfunction]
fn colours<'py>(
    py: Python<'py>,
    class_start: Items<'py, i64>,
    class_i: Items<'py, i32>,
    class_j: Items<'py, i32>,
    n_sides: usize,
) -> Answered<'py> {
    compute!(py, class_start, class_i, class_j => {
        let classes = ClassTable { start: class_start, i: class_i, j: class_j };
        let shape = [class_start.len() - 1, n_sides];
        let [component, colour] = bestmarked::colours(&classes, n_sides);
        (Shaped(component, shape), Shaped(colour, shape))
    })
}

/// The Python class `MarkedIndex`.
#[derive(FromPyObject)]
struct IndexArrays<'py> {
    base: Table<'py, i32>,
    start: Items<'py, i64>,
    unmarked: Items<'py, i32>,
    signature: Items<'py, i32>,
    counts: Table<'py, u8>,
    convex: Items<'py, i32>,
    reflex: Items<'py, i32>,
    class_start: Items<'py, i64>,
    class_i: Items<'py, i32>,
    class_j: Items<'py, i32>,
    component: Table<'py, i16>,
    colour: Table<'py, i16>,
}

impl IndexArrays<'_> {
    /// Borrow the arrays.
    fn view(&self) -> MarkedIndex<'_> {
        MarkedIndex {
            base: &self.base,
            start: &self.start,
            unmarked: &self.unmarked,
            signature: &self.signature,
            counts: &self.counts,
            convex: &self.convex,
            reflex: &self.reflex,
            classes: ClassTable {
                start: &self.class_start,
                i: &self.class_i,
                j: &self.class_j,
            },
            component: &self.component,
            colour: &self.colour,
        }
    }
}

/// Return the fields of [`bestmarked::BestRow`], the row -1 where there is none.
#[pyfunction]
fn find_best_row<'py>(
    py: Python<'py>,
    index: IndexArrays<'py>,
    lengths: Items<'py, i32>,
    asked: Items<'py, i32>,
    cap: i32,
    most: Option<i32>,
) -> Answered<'py> {
    let index = index.view();
    compute!(py, lengths, asked => {
        match bestmarked::find_best_row(&Outline { lengths, asked, cap, most }, &index) {
            Some(best) => {
                let on_boundary = best.n_on_boundary;
                (best.row as i64, best.orientation, best.n_irregular, on_boundary, best.slack)
            }
            None => (-1, 0, 0, 0, Vec::new()),
        }
    })
}

/// A label as a word, rotation, whether it is reflected, and the number of sides.
type Row<'py> = (Items<'py, i16>, usize, bool, usize);

/// The two sides of classes, and their numbers of strands.
type Classes<'py> = (Items<'py, i32>, Items<'py, i32>, Items<'py, i32>);

#[pyfunction]
fn spread_strand_widths<'py>(
    py: Python<'py>,
    row: Row<'py>,
    classes: Classes<'py>,
    slack: Items<'py, i32>,
) -> Answered<'py> {
    let (label, rotation, reflected, n_sides) = row;
    let columns = classes.0.iter().zip(&*classes.1);
    let class = |((&i, &j), &n): ((&i32, &i32), &i32)| Class {
        i: i as usize,
        j: j as usize,
        n,
        weight: 1,
    };
    let classes: Vec<Class> = columns.zip(&*classes.2).map(class).collect();
    compute!(py, label, slack => {
        let row = MarkedRow { label, rotation, reflected, n_sides };
        bestmarked::spread_strand_widths(&row, &classes, slack)
    })
}

/// The Python class `CornerSites`.
#[derive(FromPyObject)]
struct SiteArrays<'py> {
    marks: Items<'py, i32>,
    slots: Items<'py, i32>,
    near: Items<'py, i32>,
    far: Items<'py, i32>,
}

/// Codes one after the other, where each begins and the last ends, and the irregular interior
/// vertices and reflex corners of each.
type PatternArrays<'py> = (
    Items<'py, u16>,
    Items<'py, i64>,
    Items<'py, i32>,
    Items<'py, i32>,
);

/// Return the heads, labels and polychords of records.
#[pyfunction]
fn list_records<'py>(
    py: Python<'py>,
    patterns: PatternArrays<'py>,
    n_marks: usize,
    most: i32,
    free: bool,
    sites: SiteArrays<'py>,
    cancelled: Bound<'py, PyArray1<u8>>,
) -> Answered<'py> {
    let SiteArrays {
        marks,
        slots,
        near,
        far,
    } = &sites;
    let sites: Vec<CornerSites> = (0..marks.len())
        .map(|k| CornerSites {
            marks: marks[k],
            slots: slots[k],
            near: near[k],
            far: far[k],
        })
        .collect();
    let (flat, offsets, n_irregular, n_reflex) = patterns;
    let cancelled = CancelFlag::new(cancelled)?;
    let cancelled = cancelled.atomic();
    compute!(py, flat, offsets, n_irregular, n_reflex => {
        let patterns = offsets.windows(2).zip(n_irregular).zip(n_reflex);
        let patterns = patterns.map(|((ends, &n_irregular), &n_reflex)| Unmarked {
            code: &flat[ends[0] as usize..ends[1] as usize],
            n_irregular,
            n_reflex,
        });
        let bounds = corner_placement::Bounds { n_marks, most, free };
        let is_cancelled = || is_set(cancelled);
        let records = corner_placement::list_records(patterns, bounds, &sites, &is_cancelled);
        let width = Records::width(n_marks);
        let n_records = records.head.len() / width;
        (Shaped(records.head, [n_records, width]), records.label, records.chord)
    })
}

/// Return codes one after the other, and where each begins and the last ends.
#[pyfunction]
fn grow_patterns<'py>(
    py: Python<'py>,
    most: i32,
    valence: i32,
    max_quads: usize,
    cancelled: Bound<'py, PyArray1<u8>>,
) -> Answered<'py> {
    let cancelled = CancelFlag::new(cancelled)?;
    let cancelled = cancelled.atomic();
    compute!(py, => {
        let bounds = family::Bounds { most, valence, max_quads };
        let grown = family::grow_patterns(bounds, &|| is_set(cancelled));
        (grown.flat, grown.offsets)
    })
}

#[pyfunction]
fn meshes<'py>(py: Python<'py>, flat: Items<'py, u16>, offsets: Items<'py, i64>) -> Answered<'py> {
    compute!(py, flat, offsets => family::meshes(flat, offsets))
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "bestmarked": colours, find_best_row, spread_strand_widths);
    add_functions!(parent, "corner_placement": list_records);
    add_functions!(parent, "family": grow_patterns, meshes);
    Ok(())
}
