//! Uniform Laplacian: every interior vertex at the mean of its neighbours.
//!
//! Solved by conjugate gradients over the neighbours as they stand: for the few hundred vertices of a
//! fill that is some ten times faster than building and factoring a sparse matrix, and several right
//! sides go side by side.

use patterndb_geometry::Point;
use patterndb_geometry::vector::{dot, max};

/// The residual is brought below this part of the right side: rounding, nearly.
const PRECISION: f64 = 1e-13;

/// The same for moves that are made again and again.
const FEW_DIGITS: f64 = 1e-4;

/// Steps per free vertex. In exact arithmetic one each would do; rounding costs a few more.
const STEPS_EACH: usize = 4;

/// Two orthonormal tangents of a vertex.
pub type Frame = [Point; 2];

/// The neighbours of vertices, in a row.
#[derive(Clone, Copy, Debug)]
pub struct Adjacency<'a> {
    /// Where the neighbours of each vertex begin, and where those of the last end.
    pub start: &'a [i32],
    /// The neighbours.
    pub neighbour: &'a [i32],
    /// Vertices before this one do not move.
    pub fixed: usize,
}

impl<'a> Adjacency<'a> {
    /// Return the neighbours of a vertex.
    #[inline(always)]
    fn of(&self, vertex: usize) -> &'a [i32] {
        &self.neighbour[self.start[vertex] as usize..self.start[vertex + 1] as usize]
    }

    /// Return the neighbours of each free vertex.
    #[inline(always)]
    fn free(&self) -> impl Iterator<Item = &'a [i32]> {
        let (neighbour, starts) = (self.neighbour, &self.start[self.fixed..]);
        starts
            .windows(2)
            .map(|ends| &neighbour[ends[0] as usize..ends[1] as usize])
    }

    fn n_steps(&self, free: usize) -> usize {
        STEPS_EACH * free + 10
    }
}

/// The solution for one coordinate, by conjugate gradients with the diagonal as preconditioner.
struct Column {
    values: Vec<f64>,
    /// Of each free vertex, like the two below.
    residual: Vec<f64>,
    toward: Vec<f64>,
    product: Vec<f64>,
    /// The squared size of the residual.
    squared: f64,
    /// What the residual is compared with.
    scale: f64,
}

impl Column {
    /// Begin with values of all vertices.
    fn new(values: Vec<f64>, graph: &Adjacency) -> Column {
        let free = values.len() - graph.fixed;
        let mut column = Column {
            values,
            residual: Vec::with_capacity(free),
            toward: Vec::with_capacity(free),
            product: vec![0.0; free],
            squared: 0.0,
            scale: 0.0,
        };
        for (around, &value) in graph.free().zip(&column.values[graph.fixed..]) {
            let degree = around.len() as f64;
            let (mut total, mut right) = (0.0, 0.0);
            for &j in around {
                let j = j as usize;
                total += column.values[j];
                if j < graph.fixed {
                    right += column.values[j];
                }
            }
            let r = total - degree * value;
            column.residual.push(r);
            column.toward.push(r / degree);
            column.squared += r * r / degree;
            column.scale += max(right * right, total * total) / degree;
        }
        column
    }

    fn is_busy(&self) -> bool {
        self.squared > PRECISION * PRECISION * self.scale
    }

    fn step(&mut self, graph: &Adjacency) {
        let mut curve = 0.0;
        let rows = graph.free().zip(&self.toward).zip(&mut self.product);
        for ((around, &toward), product) in rows {
            let mut total = around.len() as f64 * toward;
            for &j in around {
                if let Some(j) = (j as usize).checked_sub(graph.fixed) {
                    total -= self.toward[j];
                }
            }
            *product = total;
            curve += total * toward;
        }
        if curve <= 0.0 {
            self.squared = 0.0;
            return;
        }
        let alpha = self.squared / curve;
        let mut after = 0.0;
        let values = self.values[graph.fixed..].iter_mut();
        let rows = graph.free().zip(values).zip(&self.toward);
        let rows = rows.zip(&mut self.residual).zip(&self.product);
        for ((((around, value), &toward), residual), &product) in rows {
            *value += alpha * toward;
            *residual -= alpha * product;
            after += *residual * *residual / around.len() as f64;
        }
        let beta = after / self.squared;
        self.squared = after;
        let rows = graph.free().zip(&mut self.toward).zip(&self.residual);
        for ((around, toward), residual) in rows {
            *toward = residual / around.len() as f64 + beta * *toward;
        }
    }
}

/// Solve for the values of the free vertices, in place; return the steps taken.
///
/// `values` has `width` columns, each solved for itself, and a row for every vertex. What stands in
/// the rows of free vertices is where the solution starts from.
pub fn relax_inside(graph: &Adjacency, width: usize, values: &mut [f64]) -> usize {
    let n_vertices = values.len().checked_div(width).unwrap_or(0);
    if n_vertices <= graph.fixed {
        return 0;
    }
    let column = |c: usize| values.iter().skip(c).step_by(width).copied().collect();
    let mut columns: Vec<Column> = (0..width).map(|c| Column::new(column(c), graph)).collect();
    let mut steps = 0;
    while steps < graph.n_steps(n_vertices - graph.fixed) && columns.iter().any(Column::is_busy) {
        steps += 1;
        for column in &mut columns {
            column.step(graph);
        }
    }
    for (c, column) in columns.iter().enumerate() {
        let rows = values.chunks_exact_mut(width).zip(&column.values);
        rows.skip(graph.fixed)
            .for_each(|(row, &value)| row[c] = value);
    }
    steps
}

/// Return the vector of a plane with two coordinates.
#[inline(always)]
fn in_space(at: &[f64; 2], frame: &Frame) -> Point {
    [0, 1, 2].map(|c| at[0] * frame[0][c] + at[1] * frame[1][c])
}

/// Return moves within the vertices' planes that bring the least sum of squared edges.
///
/// A few digits suffice: the planes turn from round to round.
pub fn relax_within(graph: &Adjacency, points: &[Point], frames: &[Frame]) -> Vec<Point> {
    let fixed = graph.fixed;
    let mut across = vec![[0.0; 3]; points.len()];
    if points.len() <= fixed {
        return across;
    }
    let free = points.len() - fixed;
    let frames = &frames[fixed..];
    let mut at = vec![[0.0; 2]; free];
    let mut residual = Vec::with_capacity(free);
    let mut squared = 0.0;
    for ((around, point), frame) in graph.free().zip(&points[fixed..]).zip(frames) {
        let degree = around.len() as f64;
        let mut pull = point.map(|x| -degree * x);
        for &j in around {
            for (pull, x) in pull.iter_mut().zip(points[j as usize]) {
                *pull += x;
            }
        }
        let off = [0, 1].map(|f| 0.0 + dot(&pull, &frame[f]));
        for r in off {
            squared += r * r / degree;
        }
        residual.push(off);
    }
    let towards = graph.free().zip(&residual);
    let mut toward: Vec<[f64; 2]> = towards
        .map(|(around, off)| off.map(|r| r / around.len() as f64))
        .collect();
    let mut product = vec![[0.0; 2]; free];
    let target = FEW_DIGITS * FEW_DIGITS * squared;
    for _ in 0..graph.n_steps(free) {
        if squared <= target {
            break;
        }
        for ((across, toward), frame) in across[fixed..].iter_mut().zip(&toward).zip(frames) {
            *across = in_space(toward, frame);
        }
        let mut curve = 0.0;
        let rows = graph.free().zip(&across[fixed..]).zip(frames);
        for (((around, own), frame), (product, toward)) in rows.zip(product.iter_mut().zip(&toward))
        {
            let mut pull = own.map(|x| around.len() as f64 * x);
            for &j in around {
                for (pull, x) in pull.iter_mut().zip(across[j as usize]) {
                    *pull -= x;
                }
            }
            *product = [0, 1].map(|f| 0.0 + dot(&pull, &frame[f]));
            curve += product[0] * toward[0] + product[1] * toward[1];
        }
        if curve <= 0.0 {
            break;
        }
        let alpha = squared / curve;
        let mut after = 0.0;
        let rows = graph.free().zip(&mut at).zip(&mut residual);
        for (((around, at), residual), (toward, product)) in rows.zip(toward.iter().zip(&product)) {
            for f in 0..2 {
                at[f] += alpha * toward[f];
                residual[f] -= alpha * product[f];
                after += residual[f] * residual[f] / around.len() as f64;
            }
        }
        let beta = after / squared;
        squared = after;
        for ((around, toward), residual) in graph.free().zip(&mut toward).zip(&residual) {
            for (toward, residual) in toward.iter_mut().zip(residual) {
                *toward = residual / around.len() as f64 + beta * *toward;
            }
        }
    }
    for ((across, at), frame) in across[fixed..].iter_mut().zip(&at).zip(frames) {
        *across = in_space(at, frame);
    }
    across
}

/// Return the sum of the squared lengths of all edges.
pub fn measure_edge_energy(graph: &Adjacency, points: &[Point]) -> f64 {
    let mut total = 0.0;
    for (i, point) in points.iter().enumerate() {
        for &j in graph.of(i) {
            if j as usize > i {
                for (a, b) in point.iter().zip(points[j as usize]) {
                    total += (a - b) * (a - b);
                }
            }
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 2 and its middle, the last vertex.
    const SQUARE: Adjacency = Adjacency {
        start: &[0, 3, 6, 9, 12, 16],
        neighbour: &[1, 3, 4, 2, 0, 4, 3, 1, 4, 0, 2, 4, 0, 1, 2, 3],
        fixed: 4,
    };

    fn corners() -> Vec<Point> {
        vec![
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0, 2.0, 0.0],
            [0.0, 2.0, 0.0],
            [1.5, 0.25, 3.0],
        ]
    }

    #[test]
    fn the_middle_is_the_mean() {
        let mut points = corners();
        let steps = relax_inside(&SQUARE, 3, points.as_flattened_mut());
        assert_eq!(steps, 1);
        assert_eq!(points[4], [1.0, 1.0, 0.0]);
        assert_eq!(points[..4], corners()[..4]);
        assert_eq!(measure_edge_energy(&SQUARE, &points), 24.0);
    }

    #[test]
    fn a_move_stays_in_its_plane() {
        let frames = [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 5];
        let moves = relax_within(&SQUARE, &corners(), &frames);
        assert_eq!(moves[4], [-0.5, 0.75, 0.0]);
        assert_eq!(moves[..4], [[0.0; 3]; 4]);
    }
}
