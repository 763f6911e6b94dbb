//! `patterndb._native.ingest.census`.

use numpy::{
    Element, IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1,
    PyReadwriteArray2,
};
use patterndb_core::code::Reading;
use patterndb_ingest::census::{self, Bench, Census, KernelMesh};
use patterndb_ingest::hashing::{KeyMap, Table};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arrays::{read, run, write};
use crate::core::reduction::{WorkArrays, reduction_work};
use crate::rows::{from_rows, read_rows, write_rows};

/// The arrays of a `KernelMesh` of Python.
#[derive(FromPyObject)]
pub struct MeshArrays<'py> {
    twin: PyReadonlyArray1<'py, i32>,
    vertex: PyReadonlyArray1<'py, i32>,
    valence: PyReadonlyArray1<'py, i32>,
    full: PyReadonlyArray1<'py, i32>,
    star_start: PyReadonlyArray1<'py, i32>,
    star: PyReadonlyArray1<'py, i32>,
    zobrist: PyReadonlyArray2<'py, u64>,
}

impl MeshArrays<'_> {
    pub fn slices(&self) -> PyResult<KernelMesh<'_>> {
        Ok(KernelMesh {
            twin: read(&self.twin)?.as_chunks().0,
            vertex: read(&self.vertex)?.as_chunks().0,
            valence: read(&self.valence)?,
            full: read(&self.full)?,
            star_start: read(&self.star_start)?,
            star: read(&self.star)?,
            zobrist: read_rows(&self.zobrist)?,
        })
    }
}

/// The arrays of a `Bench` of Python.
#[derive(FromPyObject)]
pub struct BenchArrays<'py> {
    member: PyReadwriteArray1<'py, i32>,
    held: PyReadwriteArray1<'py, i32>,
    quads: PyReadwriteArray1<'py, i32>,
    twin: PyReadwriteArray1<'py, i32>,
    vertex: PyReadwriteArray1<'py, i32>,
    curvature: PyReadwriteArray1<'py, i64>,
    code: PyReadwriteArray1<'py, u16>,
    number: PyReadwriteArray1<'py, i32>,
    entry: PyReadwriteArray1<'py, i32>,
    order: PyReadwriteArray1<'py, i32>,
    reduction: WorkArrays<'py>,
}

impl BenchArrays<'_> {
    pub fn slices(&mut self) -> PyResult<Bench<'_>> {
        let [curvature] = write(&mut self.curvature)? else {
            return Err(PyValueError::new_err("curvature is not (1,)"));
        };
        Ok(Bench {
            member: write(&mut self.member)?,
            held: write(&mut self.held)?,
            quads: write(&mut self.quads)?,
            twin: write(&mut self.twin)?.as_chunks_mut().0,
            vertex: write(&mut self.vertex)?.as_chunks_mut().0,
            curvature,
            code: write(&mut self.code)?,
            reading: Reading {
                number: write(&mut self.number)?,
                entry: write(&mut self.entry)?,
                order: write(&mut self.order)?,
            },
            work: self.reduction.slices()?,
        })
    }
}

/// The arrays of a `Census` of Python.
#[derive(FromPyObject)]
pub struct CensusArrays<'py> {
    used: PyReadwriteArray1<'py, i64>,
    most: PyReadonlyArray1<'py, i64>,
    reading_keys: PyReadwriteArray2<'py, u64>,
    reading_rows: PyReadwriteArray1<'py, i32>,
    code_keys: PyReadwriteArray2<'py, u64>,
    code_rows: PyReadwriteArray1<'py, i32>,
    codes: PyReadwriteArray1<'py, u8>,
    ends: PyReadwriteArray1<'py, i64>,
    sides: PyReadwriteArray1<'py, i32>,
    patches: PyReadwriteArray2<'py, i64>,
    example_size: PyReadwriteArray1<'py, i32>,
    example_hash: PyReadwriteArray2<'py, u64>,
    example_at: PyReadwriteArray1<'py, i64>,
    example: PyReadwriteArray1<'py, i32>,
}

impl CensusArrays<'_> {
    pub fn slices(&mut self) -> PyResult<Census<'_>> {
        let &[most] = read(&self.most)? else {
            return Err(PyValueError::new_err("most is not (1,)"));
        };
        Ok(Census {
            used: write(&mut self.used)?,
            most: most as usize,
            readings: KeyMap {
                keys: Table::Given(write_rows(&mut self.reading_keys)?),
                values: Table::Given(write(&mut self.reading_rows)?),
            },
            rows: KeyMap {
                keys: Table::Given(write_rows(&mut self.code_keys)?),
                values: Table::Given(write(&mut self.code_rows)?),
            },
            codes: Table::Given(write(&mut self.codes)?),
            ends: Table::Given(write(&mut self.ends)?),
            sides: Table::Given(write(&mut self.sides)?),
            patches: Table::Given(write_rows(&mut self.patches)?),
            example_size: Table::Given(write(&mut self.example_size)?),
            example_hash: Table::Given(write_rows(&mut self.example_hash)?),
            example_at: Table::Given(write(&mut self.example_at)?),
            example: Table::Given(write(&mut self.example)?),
        })
    }
}

/// Return a `Census` of Python with the arrays of the given one, where they are not replaced.
pub fn replace<'py>(given: &Bound<'py, PyAny>, census: Census) -> PyResult<Bound<'py, PyAny>> {
    let fields = [
        given.getattr("used")?,
        given.getattr("most")?,
        array_of_rows(given, "reading_keys", census.readings.keys)?,
        array(given, "reading_rows", census.readings.values)?,
        array_of_rows(given, "code_keys", census.rows.keys)?,
        array(given, "code_rows", census.rows.values)?,
        array(given, "codes", census.codes)?,
        array(given, "ends", census.ends)?,
        array(given, "sides", census.sides)?,
        array_of_rows(given, "patches", census.patches)?,
        array(given, "example_size", census.example_size)?,
        array_of_rows(given, "example_hash", census.example_hash)?,
        array(given, "example_at", census.example_at)?,
        array(given, "example", census.example)?,
    ];
    given.get_type().call1(PyTuple::new(given.py(), fields)?)
}

fn array<'py, T: Element>(
    given: &Bound<'py, PyAny>,
    name: &str,
    table: Table<T>,
) -> PyResult<Bound<'py, PyAny>> {
    match table {
        Table::Given(_) => given.getattr(name),
        Table::Own(items) => Ok(items.into_pyarray(given.py()).into_any()),
    }
}

fn array_of_rows<'py, T: Element, const W: usize>(
    given: &Bound<'py, PyAny>,
    name: &str,
    table: Table<[T; W]>,
) -> PyResult<Bound<'py, PyAny>> {
    match table {
        Table::Given(_) => given.getattr(name),
        Table::Own(rows) => Ok(from_rows(given.py(), rows)?.into_any()),
    }
}

#[pyfunction]
fn new_bench(
    py: Python<'_>,
    n_quads: usize,
    n_vertices: usize,
    limit: usize,
) -> PyResult<Bound<'_, PyAny>> {
    let zeros = |n: usize| PyArray1::<i32>::zeros(py, n, false);
    py.import("ingest.census")?.getattr("Bench")?.call1((
        PyArray1::from_vec(py, vec![-1_i32; n_quads]),
        zeros(n_vertices),
        zeros(limit),
        zeros(4 * limit),
        zeros(4 * limit),
        PyArray1::<i64>::zeros(py, 1, false),
        PyArray1::<u16>::zeros(py, 4 * limit, false),
        zeros(limit),
        zeros(limit),
        zeros(limit),
        reduction_work(py, n_vertices, limit)?,
    ))
}

#[pyfunction]
fn kernel_mesh<'py>(
    py: Python<'py>,
    twin: Bound<'py, PyArray1<i32>>,
    vertex: Bound<'py, PyArray1<i32>>,
    n_vertices: usize,
    zobrist: Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let stars = {
        let (twin, vertex): (PyReadonlyArray1<i32>, PyReadonlyArray1<i32>) =
            (twin.extract()?, vertex.extract()?);
        let (twin, vertex) = (read(&twin)?, read(&vertex)?);
        run(py, || census::list_stars(twin, vertex, n_vertices))?
    };
    py.import("ingest.census")?.getattr("KernelMesh")?.call1((
        twin,
        vertex,
        stars.valence.into_pyarray(py),
        stars.full.into_pyarray(py),
        stars.star_start.into_pyarray(py),
        stars.star.into_pyarray(py),
        zobrist,
    ))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(new_bench, module)?)?;
    module.add_function(wrap_pyfunction!(kernel_mesh, module)?)
}
