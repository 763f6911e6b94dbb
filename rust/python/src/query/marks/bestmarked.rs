//! `patterndb._native.query.marks.bestmarked`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use patterndb_query::marks::bestmarked::{self, ClassTable, MarkedIndex, MarkedRow, Outline};
use patterndb_query::solving::balance::Class;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_table, read_all};

/// Components and colours.
type Colours<'py> = (Bound<'py, PyArray2<i16>>, Bound<'py, PyArray2<i16>>);

#[pyfunction]
fn colours<'py>(
    py: Python<'py>,
    class_start: PyReadonlyArray1<'py, i64>,
    class_i: PyReadonlyArray1<'py, i32>,
    class_j: PyReadonlyArray1<'py, i32>,
    n_sides: usize,
) -> PyResult<Colours<'py>> {
    let classes = ClassTable {
        start: read(&class_start)?,
        i: read(&class_i)?,
        j: read(&class_j)?,
    };
    let [component, colour] = run(py, || bestmarked::colours(&classes, n_sides))?;
    let n = classes.start.len() - 1;
    Ok((
        from_table(py, n, n_sides, component)?,
        from_table(py, n, n_sides, colour)?,
    ))
}

/// The Python class `MarkedIndex`.
#[derive(FromPyObject)]
struct IndexArrays<'py> {
    base: PyReadonlyArray2<'py, i32>,
    start: PyReadonlyArray1<'py, i64>,
    unmarked: PyReadonlyArray1<'py, i32>,
    signature: PyReadonlyArray1<'py, i32>,
    counts: PyReadonlyArray2<'py, u8>,
    convex: PyReadonlyArray1<'py, i32>,
    reflex: PyReadonlyArray1<'py, i32>,
    class_start: PyReadonlyArray1<'py, i64>,
    class_i: PyReadonlyArray1<'py, i32>,
    class_j: PyReadonlyArray1<'py, i32>,
    component: PyReadonlyArray2<'py, i16>,
    colour: PyReadonlyArray2<'py, i16>,
}

impl IndexArrays<'_> {
    fn borrow(&self) -> PyResult<MarkedIndex<'_>> {
        Ok(MarkedIndex {
            base: read_all(&self.base)?,
            start: read(&self.start)?,
            unmarked: read(&self.unmarked)?,
            signature: read(&self.signature)?,
            counts: read_all(&self.counts)?,
            convex: read(&self.convex)?,
            reflex: read(&self.reflex)?,
            classes: ClassTable {
                start: read(&self.class_start)?,
                i: read(&self.class_i)?,
                j: read(&self.class_j)?,
            },
            component: read_all(&self.component)?,
            colour: read_all(&self.colour)?,
        })
    }
}

/// The fields of [`bestmarked::BestRow`], the row -1 where there is none.
type Best<'py> = (i64, usize, i32, i32, Bound<'py, PyArray1<i32>>);

#[pyfunction]
fn find_best_row<'py>(
    py: Python<'py>,
    index: IndexArrays<'py>,
    lengths: PyReadonlyArray1<'py, i32>,
    asked: PyReadonlyArray1<'py, i32>,
    cap: i32,
    most: Option<i32>,
) -> PyResult<Best<'py>> {
    let index = index.borrow()?;
    let outline = Outline {
        lengths: read(&lengths)?,
        asked: read(&asked)?,
        cap,
        most,
    };
    Ok(
        match run(py, || bestmarked::find_best_row(&outline, &index))? {
            Some(best) => (
                best.row as i64,
                best.orientation,
                best.n_irregular,
                best.n_on_boundary,
                best.slack.into_pyarray(py),
            ),
            None => (-1, 0, 0, 0, Vec::new().into_pyarray(py)),
        },
    )
}

/// A label as a word, rotation, whether it is reflected, and the number of sides.
type Row<'py> = (PyReadonlyArray1<'py, i16>, usize, bool, usize);

/// The two sides of classes, and their numbers of strands.
type Classes<'py> = (
    PyReadonlyArray1<'py, i32>,
    PyReadonlyArray1<'py, i32>,
    PyReadonlyArray1<'py, i32>,
);

#[pyfunction]
fn spread_strand_widths<'py>(
    py: Python<'py>,
    row: Row<'py>,
    classes: Classes<'py>,
    slack: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let (label, rotation, reflected, n_sides) = row;
    let row = MarkedRow {
        label: read(&label)?,
        rotation,
        reflected,
        n_sides,
    };
    let columns = read(&classes.0)?.iter().zip(read(&classes.1)?);
    let class = |((&i, &j), &n): ((&i32, &i32), &i32)| Class {
        i: i as usize,
        j: j as usize,
        n,
        weight: 1,
    };
    let classes: Vec<Class> = columns.zip(read(&classes.2)?).map(class).collect();
    let slack = read(&slack)?;
    let widths = run(py, || {
        bestmarked::spread_strand_widths(&row, &classes, slack)
    })?;
    Ok(widths.into_pyarray(py))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(colours, module)?)?;
    module.add_function(wrap_pyfunction!(find_best_row, module)?)?;
    module.add_function(wrap_pyfunction!(spread_strand_widths, module)?)
}
