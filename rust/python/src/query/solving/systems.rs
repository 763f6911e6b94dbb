//! `patterndb._native.query.solving.systems`.

use numpy::{
    Element, IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArray1,
    PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods,
};
use patterndb_query::solving::feasibility::Systems;
use patterndb_query::solving::graphs::Graphs;
use patterndb_query::solving::systems;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{read, run};
use crate::rows::{from_table, read_all, write_all};

/// The Python class `Graphs`.
#[derive(FromPyObject)]
pub struct GraphArrays<'py> {
    first: PyReadonlyArray1<'py, i32>,
    class_i: PyReadonlyArray1<'py, i16>,
    class_j: PyReadonlyArray1<'py, i16>,
    claim: PyReadonlyArray2<'py, i32>,
    near_first: PyReadonlyArray1<'py, i32>,
    near: PyReadonlyArray1<'py, i16>,
}

/// The Python class `Systems`.
#[derive(FromPyObject)]
pub struct SystemArrays<'py> {
    pub graphs: GraphArrays<'py>,
    base: PyReadonlyArray2<'py, i16>,
    pub pairs: PyReadonlyArray2<'py, u8>,
    perimeter: PyReadonlyArray1<'py, i32>,
    pub surplus: PyReadonlyArray2<'py, u8>,
    component: PyReadonlyArray2<'py, i16>,
    colour: PyReadonlyArray2<'py, i16>,
    parity: PyReadonlyArray1<'py, bool>,
    graph: PyReadonlyArray1<'py, i32>,
    joint_first: PyReadonlyArray1<'py, i32>,
    joint: PyReadonlyArray1<'py, i32>,
}

impl GraphArrays<'_> {
    /// Borrow the arrays.
    pub fn borrow(&self) -> PyResult<Graphs<'_>> {
        Ok(Graphs {
            first: read(&self.first)?,
            class_i: read(&self.class_i)?,
            class_j: read(&self.class_j)?,
            claim: read_all(&self.claim)?,
            near_first: read(&self.near_first)?,
            near: read(&self.near)?,
            n_sides: self.claim.shape()[1],
        })
    }
}

impl SystemArrays<'_> {
    /// Borrow the arrays.
    pub fn borrow(&self) -> PyResult<Systems<'_>> {
        Ok(Systems {
            graphs: self.graphs.borrow()?,
            base: read_all(&self.base)?,
            perimeter: read(&self.perimeter)?,
            component: read_all(&self.component)?,
            colour: read_all(&self.colour)?,
            parity: read(&self.parity)?,
            graph: read(&self.graph)?,
            joint_first: read(&self.joint_first)?,
            joint: read(&self.joint)?,
        })
    }
}

type ClaimArrays<'py> = (
    Bound<'py, PyArray2<i32>>,
    Bound<'py, PyArray1<i16>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i16>>,
);

#[pyfunction]
fn number_claims<'py>(
    py: Python<'py>,
    joined: PyReadonlyArray3<'py, bool>,
) -> PyResult<ClaimArrays<'py>> {
    let (n, n_sides) = (joined.shape()[0], joined.shape()[1]);
    let joined = read_all(&joined)?;
    let made = run(py, || systems::number_claims(joined, n_sides))?;
    Ok((
        from_table(py, n, n_sides, made.claim)?,
        made.claimant.into_pyarray(py),
        made.near_first.into_pyarray(py),
        made.near.into_pyarray(py),
    ))
}

/// Write an array of a named tuple.
fn fill<T: Element + Copy>(tuple: &Bound<'_, PyAny>, name: &str, items: &[T]) -> PyResult<()> {
    let array = tuple.getattr(name)?.cast_into::<PyArrayDyn<T>>()?;
    let mut array = array.try_readwrite()?;
    let written = write_all(&mut array)?;
    if written.len() != items.len() {
        return Err(PyValueError::new_err(format!("{name} has another length")));
    }
    written.copy_from_slice(items);
    Ok(())
}

#[pyfunction]
#[pyo3(name = "fill")]
fn fill_systems<'py>(
    py: Python<'py>,
    made: &Bound<'py, PyAny>,
    joined: PyReadonlyArray3<'py, bool>,
) -> PyResult<()> {
    let n_sides = joined.shape()[1];
    let base: PyReadonlyArray2<'py, i16> = made.getattr("base")?.extract()?;
    let (base, joined) = (read_all(&base)?, read_all(&joined)?);
    let classes = run(py, || systems::list_classes(base, joined, n_sides))?;
    let graphs = made.getattr("graphs")?;
    fill(&graphs, "first", &classes.first)?;
    fill(&graphs, "class_i", &classes.class_i)?;
    fill(&graphs, "class_j", &classes.class_j)?;
    fill(made, "surplus", &classes.surplus)?;
    fill(made, "component", &classes.component)?;
    fill(made, "colour", &classes.colour)?;
    fill(made, "parity", &classes.parity)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(number_claims, module)?)?;
    module.add_function(wrap_pyfunction!(fill_systems, module)?)
}
