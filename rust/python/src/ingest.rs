//! `patterndb._native.ingest`.

use std::sync::atomic::AtomicI64;

use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use patterndb_core::code::Reading;
use patterndb_ingest::census::{self, Bench, Census, KernelMesh};
use patterndb_ingest::growth::{self, Growth};
use patterndb_ingest::hashing::{KeyMap, Table};
use patterndb_ingest::pulse::Pulse;
use patterndb_ingest::{basic, hashing, learning, prepare, shards};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::answers::{Answer, Answered, add_functions, compute};
use crate::arguments::{Items, ItemsMut, Rows, RowsMut};
use crate::core::{WorkArrays, reduction_work};
use crate::unlocked::run;

/// The flag that stops searches, and the number of patches met so far.
///
/// Not a borrow of the array as others are: several searches, and Python, use it at a time.
#[expect(unsafe_code, reason = "numpy has no arrays of atomic numbers")]
fn share<'a>(pulse: &'a Bound<'_, PyArray1<i64>>) -> PyResult<[&'a AtomicI64; 2]> {
    if pulse.len() != 2 || !pulse.is_contiguous() {
        return Err(PyValueError::new_err("a pulse is an array (2,) of int64"));
    }
    let first = pulse.data();
    if !first.is_aligned() {
        return Err(PyValueError::new_err("a pulse is not aligned"));
    }
    // SAFETY: both numbers are aligned and live as long as the array, which the caller holds; no
    // Rust code reads or writes them but as atomic numbers.
    Ok(unsafe {
        [
            AtomicI64::from_ptr(first),
            AtomicI64::from_ptr(first.add(1)),
        ]
    })
}

/// The arrays of a `KernelMesh` of Python.
#[derive(FromPyObject)]
struct MeshArrays<'py> {
    twin: Items<'py, i32>,
    vertex: Items<'py, i32>,
    valence: Items<'py, i32>,
    full: Items<'py, i32>,
    star_start: Items<'py, i32>,
    star: Items<'py, i32>,
    zobrist: Rows<'py, u64, 2>,
}

impl MeshArrays<'_> {
    /// Borrow the arrays.
    fn view(&self) -> KernelMesh<'_> {
        KernelMesh {
            twin: self.twin.as_chunks().0,
            vertex: self.vertex.as_chunks().0,
            valence: &self.valence,
            full: &self.full,
            star_start: &self.star_start,
            star: &self.star,
            zobrist: &self.zobrist,
        }
    }
}

/// The arrays of a `Bench` of Python.
#[derive(FromPyObject)]
struct BenchArrays<'py> {
    member: ItemsMut<'py, i32>,
    held: ItemsMut<'py, i32>,
    quads: ItemsMut<'py, i32>,
    twin: ItemsMut<'py, i32>,
    vertex: ItemsMut<'py, i32>,
    curvature: ItemsMut<'py, i64>,
    code: ItemsMut<'py, u16>,
    number: ItemsMut<'py, i32>,
    entry: ItemsMut<'py, i32>,
    order: ItemsMut<'py, i32>,
    reduction: WorkArrays<'py>,
}

impl BenchArrays<'_> {
    /// Borrow the arrays; ValueError where one has another size than it needs.
    fn view(&mut self) -> PyResult<Bench<'_>> {
        let [curvature] = &mut *self.curvature else {
            return Err(PyValueError::new_err("curvature is not (1,)"));
        };
        Ok(Bench {
            member: &mut self.member,
            held: &mut self.held,
            quads: &mut self.quads,
            twin: self.twin.as_chunks_mut().0,
            vertex: self.vertex.as_chunks_mut().0,
            curvature,
            code: &mut self.code,
            reading: Reading {
                number: &mut self.number,
                entry: &mut self.entry,
                order: &mut self.order,
            },
            work: self.reduction.view(),
        })
    }
}

/// The arrays of a `Census` of Python.
#[derive(FromPyObject)]
struct CensusArrays<'py> {
    used: ItemsMut<'py, i64>,
    most: Items<'py, i64>,
    reading_keys: RowsMut<'py, u64, 2>,
    reading_rows: ItemsMut<'py, i32>,
    code_keys: RowsMut<'py, u64, 2>,
    code_rows: ItemsMut<'py, i32>,
    codes: ItemsMut<'py, u8>,
    ends: ItemsMut<'py, i64>,
    sides: ItemsMut<'py, i32>,
    patches: RowsMut<'py, i64, 2>,
    example_size: ItemsMut<'py, i32>,
    example_hash: RowsMut<'py, u64, 2>,
    example_at: ItemsMut<'py, i64>,
    example: ItemsMut<'py, i32>,
}

impl CensusArrays<'_> {
    /// Borrow the arrays; ValueError where one has another size than it needs.
    fn view(&mut self) -> PyResult<Census<'_>> {
        let [most] = *self.most else {
            return Err(PyValueError::new_err("most is not (1,)"));
        };
        Ok(Census {
            used: &mut self.used,
            most: most as usize,
            readings: KeyMap {
                keys: Table::Given(&mut self.reading_keys),
                values: Table::Given(&mut self.reading_rows),
            },
            rows: KeyMap {
                keys: Table::Given(&mut self.code_keys),
                values: Table::Given(&mut self.code_rows),
            },
            codes: Table::Given(&mut self.codes),
            ends: Table::Given(&mut self.ends),
            sides: Table::Given(&mut self.sides),
            patches: Table::Given(&mut self.patches),
            example_size: Table::Given(&mut self.example_size),
            example_hash: Table::Given(&mut self.example_hash),
            example_at: Table::Given(&mut self.example_at),
            example: Table::Given(&mut self.example),
        })
    }
}

/// Return a `Census` of Python with the arrays of the given one, where they are not replaced.
fn replace<'py>(given: &Bound<'py, PyAny>, census: Census) -> Answered<'py> {
    let fields = [
        given.getattr("used")?,
        given.getattr("most")?,
        array(given, "reading_keys", census.readings.keys)?,
        array(given, "reading_rows", census.readings.values)?,
        array(given, "code_keys", census.rows.keys)?,
        array(given, "code_rows", census.rows.values)?,
        array(given, "codes", census.codes)?,
        array(given, "ends", census.ends)?,
        array(given, "sides", census.sides)?,
        array(given, "patches", census.patches)?,
        array(given, "example_size", census.example_size)?,
        array(given, "example_hash", census.example_hash)?,
        array(given, "example_at", census.example_at)?,
        array(given, "example", census.example)?,
    ];
    given.get_type().call1(PyTuple::new(given.py(), fields)?)
}

fn array<'py, T>(given: &Bound<'py, PyAny>, name: &str, table: Table<T>) -> Answered<'py>
where
    Vec<T>: Answer<'py>,
{
    match table {
        Table::Given(_) => given.getattr(name),
        Table::Own(items) => items.answer(given.py()),
    }
}

#[pyfunction]
fn new_bench(py: Python<'_>, n_quads: usize, n_vertices: usize, limit: usize) -> Answered<'_> {
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
    twin: Bound<'py, PyAny>,
    vertex: Bound<'py, PyAny>,
    n_vertices: usize,
    zobrist: Bound<'py, PyAny>,
) -> Answered<'py> {
    let stars = {
        let (twins, vertices): (Items<i32>, Items<i32>) = (twin.extract()?, vertex.extract()?);
        let (twins, vertices) = (&*twins, &*vertices);
        run(py, || census::list_stars(twins, vertices, n_vertices))?
    };
    let made = py.import("ingest.census")?.getattr("KernelMesh")?;
    let (valence, full) = (stars.valence.answer(py)?, stars.full.answer(py)?);
    let (star_start, star) = (stars.star_start.answer(py)?, stars.star.answer(py)?);
    made.call1((twin, vertex, valence, full, star_start, star, zobrist))
}

#[pyfunction]
fn count_basic<'py>(
    py: Python<'py>,
    first: i32,
    last: i32,
    limit: usize,
    mesh: MeshArrays<'py>,
    mut bench: BenchArrays<'py>,
    census: Bound<'py, PyAny>,
    pulse: Bound<'py, PyArray1<i64>>,
) -> Answered<'py> {
    let mut arrays: CensusArrays = census.extract()?;
    let (mesh, mut bench, mut tables) = (mesh.view(), bench.view()?, arrays.view()?);
    let [stop, met] = share(&pulse)?;
    let total = run(py, || {
        let mut pulse = Pulse::new(stop, met);
        basic::count_basic(
            first..last,
            limit,
            &mesh,
            &mut bench,
            &mut tables,
            &mut pulse,
        )
    })?;
    (total, replace(&census, tables)?).answer(py)
}

#[pyfunction]
fn grow<'py>(
    py: Python<'py>,
    roots: Items<'py, i32>,
    limit: usize,
    convex: bool,
    smaller: usize,
    others: Rows<'py, u64, 2>,
    shard: Items<'py, i32>,
    mesh: MeshArrays<'py>,
    mut bench: BenchArrays<'py>,
    census: Bound<'py, PyAny>,
    pulse: Bound<'py, PyArray1<i64>>,
) -> Answered<'py> {
    let mut arrays: CensusArrays = census.extract()?;
    let (mesh, mut bench, mut tables) = (mesh.view(), bench.view()?, arrays.view()?);
    let [stop, met] = share(&pulse)?;
    let (roots, others, shard) = (&*roots, &*others, &*shard);
    let grown = run(py, || {
        let mut pulse = Pulse::new(stop, met);
        let growth = Growth {
            limit,
            convex,
            smaller,
            others,
            shard,
        };
        growth::grow(roots, growth, &mesh, &mut bench, &mut tables, &mut pulse)
    })?;
    let census = replace(&census, tables)?;
    (
        grown.total,
        grown.met,
        grown.far_hash,
        grown.far_value,
        census,
    )
        .answer(py)
}

#[pyfunction]
fn random_pairs(py: Python<'_>, n: usize) -> Answered<'_> {
    compute!(py, => hashing::random_pairs(n))
}

#[pyfunction]
fn hash_rows<'py>(py: Python<'py>, raw: Items<'py, u8>, ends: Items<'py, i64>) -> Answered<'py> {
    compute!(py, raw, ends => learning::hash_rows(raw, ends))
}

#[pyfunction]
fn pack_faces<'py>(
    py: Python<'py>,
    quads: Items<'py, i32>,
    sizes: Items<'py, i32>,
    faces: Items<'py, i64>,
) -> Answered<'py> {
    compute!(py, quads, sizes, faces => {
        let packed = learning::pack_faces(quads, sizes, faces);
        (packed.flat, packed.ends)
    })
}

#[pyfunction]
fn collapse_all<'py>(
    py: Python<'py>,
    mut vertex: ItemsMut<'py, i32>,
    mut twin: ItemsMut<'py, i32>,
    n_vertices: usize,
) -> Answered<'py> {
    let (vertex, twin) = (&mut *vertex, &mut *twin);
    compute!(py, => prepare::collapse_all(vertex, twin, n_vertices))
}

#[pyfunction]
fn breadth_first<'py>(
    py: Python<'py>,
    twin: Items<'py, i32>,
    root: i32,
    inside: Items<'py, bool>,
    part: Items<'py, i32>,
) -> Answered<'py> {
    compute!(py, twin, inside, part => shards::breadth_first(twin, root, inside, part))
}

pub fn add(parent: &Bound<'_, PyModule>) -> PyResult<()> {
    add_functions!(parent, "basic": count_basic);
    add_functions!(parent, "census": new_bench, kernel_mesh);
    add_functions!(parent, "growth": grow);
    add_functions!(parent, "hashing": random_pairs);
    add_functions!(parent, "learning": hash_rows, pack_faces);
    add_functions!(parent, "prepare": collapse_all);
    add_functions!(parent, "shards": breadth_first);
    Ok(())
}
