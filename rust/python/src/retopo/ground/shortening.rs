//! `patterndb._native.retopo.ground.shortening`.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
};
use patterndb_retopo::ground::shortening::{self, Flat, Gates, Step, Turn};
use patterndb_retopo::ground::topology::Surface;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::read_items;
use crate::arrays::{read, run};
use crate::rows::{from_blocks, from_rows, read_blocks, read_rows};

type UnfoldedArrays<'py> = (
    Bound<'py, PyArray2<i32>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray2<f64>>,
);

type TurnArrays<'py> = (Bound<'py, PyArray1<i32>>, Bound<'py, PyArray1<i32>>, f64);

type StripArrays<'py> = (
    i32,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

/// Return the steps of a strip, of which there is one at least.
fn read_steps(
    out: &PyReadonlyArray1<'_, i32>,
    into: &PyReadonlyArray1<'_, i32>,
) -> PyResult<Vec<Step>> {
    let (out, into) = (read(out)?, read(into)?);
    if out.is_empty() || out.len() != into.len() {
        return Err(PyValueError::new_err(
            "a strip has as many sides out as into, and one at least",
        ));
    }
    let step = |(&out, &into)| Step { out, into };
    Ok(out.iter().zip(into).map(step).collect())
}

/// Borrow the gates of a strip.
fn read_gates<'a>(
    gate: &'a PyReadonlyArray2<'_, i32>,
    flat: &'a PyReadonlyArray3<'_, f64>,
    ends: &'a PyReadonlyArray2<'_, f64>,
) -> PyResult<Gates<'a>> {
    let ends: &[[Flat; 2]] = read_blocks(ends)?;
    let gates = Gates {
        vertices: read_rows(gate)?,
        places: read_blocks(flat)?,
        ends: &ends[0],
    };
    if gates.vertices.len() < 2 || gates.vertices.len() != gates.places.len() {
        return Err(PyValueError::new_err(
            "gates have as many vertices as places, and two rows at least",
        ));
    }
    Ok(gates)
}

#[pyfunction]
fn unfold_strip<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    triangles: PyReadonlyArray2<'py, i32>,
    out: PyReadonlyArray1<'py, i32>,
    into: PyReadonlyArray1<'py, i32>,
    start: PyReadonlyArray1<'py, f64>,
    end: PyReadonlyArray1<'py, f64>,
) -> PyResult<UnfoldedArrays<'py>> {
    let surface = Surface {
        vertices: read_rows(&vertices)?,
        triangles: read_rows(&triangles)?,
    };
    let steps = read_steps(&out, &into)?;
    let (start, end) = (read_items(&start)?, read_items(&end)?);
    let made = run(py, || shortening::unfold_strip(surface, &steps, start, end))?;
    Ok((
        from_rows(py, made.vertices)?,
        from_blocks(py, made.places)?,
        from_rows(py, made.ends.to_vec())?,
    ))
}

#[pyfunction]
fn pull_tight<'py>(
    py: Python<'py>,
    gate: PyReadonlyArray2<'py, i32>,
    flat: PyReadonlyArray3<'py, f64>,
    ends: PyReadonlyArray2<'py, f64>,
) -> PyResult<TurnArrays<'py>> {
    let gates = read_gates(&gate, &flat, &ends)?;
    let (turns, length) = run(py, || shortening::pull_tight(gates))?;
    let turn = |turn: &Turn| (turn.gate as i32, turn.side as i32);
    let (numbers, which): (Vec<i32>, Vec<i32>) = turns.iter().map(turn).unzip();
    Ok((numbers.into_pyarray(py), which.into_pyarray(py), length))
}

#[pyfunction]
fn shorten_strip<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    triangles: PyReadonlyArray2<'py, i32>,
    across: PyReadonlyArray1<'py, i32>,
    out: PyReadonlyArray1<'py, i32>,
    into: PyReadonlyArray1<'py, i32>,
    start: PyReadonlyArray1<'py, f64>,
    end: PyReadonlyArray1<'py, f64>,
) -> PyResult<StripArrays<'py>> {
    let surface = Surface {
        vertices: read_rows(&vertices)?,
        triangles: read_rows(&triangles)?,
    };
    let across = read(&across)?;
    let steps = read_steps(&out, &into)?;
    let (start, end) = (*read_items(&start)?, *read_items(&end)?);
    let strip = run(py, || {
        shortening::shorten_strip(surface, across, steps, start, end)
    })?;
    let sides = strip.steps.iter().map(|step| (step.out, step.into));
    let (out, into): (Vec<i32>, Vec<i32>) = sides.unzip();
    Ok((
        strip.first,
        out.into_pyarray(py),
        into.into_pyarray(py),
        strip.start.to_vec().into_pyarray(py),
        strip.end.to_vec().into_pyarray(py),
    ))
}

#[pyfunction]
fn cross_gates<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    gate: PyReadonlyArray2<'py, i32>,
    flat: PyReadonlyArray3<'py, f64>,
    ends: PyReadonlyArray2<'py, f64>,
    numbers: PyReadonlyArray1<'py, i32>,
    which: PyReadonlyArray1<'py, i32>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let vertices = read_rows(&vertices)?;
    let gates = read_gates(&gate, &flat, &ends)?;
    let turn = |(&gate, &side): (&i32, &i32)| Turn {
        gate: gate as usize,
        side: side as usize,
    };
    let turns: Vec<Turn> = read(&numbers)?
        .iter()
        .zip(read(&which)?)
        .map(turn)
        .collect();
    let points = run(py, || shortening::cross_gates(vertices, gates, &turns))?;
    from_rows(py, points)
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(unfold_strip, module)?)?;
    module.add_function(wrap_pyfunction!(pull_tight, module)?)?;
    module.add_function(wrap_pyfunction!(shorten_strip, module)?)?;
    module.add_function(wrap_pyfunction!(cross_gates, module)?)
}
