//! The equations of cross fields: a connection Laplacian (Knoppel et al. 2013).

use std::array;

use num_complex::Complex64;
use patterndb_geometry::relaxation::divide;

/// Residuals are this part of the right side, at most; crosses are right to a ten thousandth then.
const RESIDUAL: f64 = 1e-7;

/// Steps of the solver at most; fields of 50,000 triangles take some hundreds.
const MOST_STEPS: usize = 4000;

/// A connection Laplacian on triangles, with pulls on its diagonal.
#[derive(Clone, Copy, Debug)]
pub struct Laplacian<'a> {
    /// Of each side the one beyond, -1 at borders.
    pub across: &'a [i32],
    /// Of each side, how much the difference across it weighs.
    pub weight: &'a [f64],
    /// Of each side, what brings the neighbour's value into the triangle.
    pub turned: &'a [Complex64],
    /// Of each triangle, how much its own value weighs.
    pub pull: &'a [f64],
}

/// A row of the matrix.
struct Row {
    diagonal: f64,
    /// Up to three neighbours; what they have times the factors is taken off.
    neighbours: [Option<(usize, Complex64)>; 3],
}

impl Row {
    fn apply(&self, u: &[Complex64], here: usize) -> Complex64 {
        let mut value = Complex64::from(self.diagonal) * u[here];
        for &(there, factor) in self.neighbours.iter().flatten() {
            value -= factor * u[there];
        }
        value
    }
}

impl Laplacian<'_> {
    fn rows(&self) -> Vec<Row> {
        let row = |(f, &pull): (usize, &f64)| {
            let sides = array::from_fn(|e| 3 * f + e);
            Row {
                diagonal: sides
                    .iter()
                    .fold(pull, |sum, &h: &usize| sum + self.weight[h]),
                neighbours: sides.map(|h| {
                    let beyond = usize::try_from(self.across[h]).ok()?;
                    Some((beyond / 3, Complex64::from(self.weight[h]) * self.turned[h]))
                }),
            }
        };
        self.pull.iter().enumerate().map(row).collect()
    }

    /// Solve (weights + pull) u - sum of weight * turned * the neighbour's u = `right`, by conjugate
    /// gradients, from a start.
    ///
    /// Not by a factorisation: it would ask a BLAS with threads of its own for thousands of tiny
    /// blocks, and these take a hundred times as long while other work is on.
    pub fn solve(&self, right: &[Complex64], start: &[Complex64]) -> Vec<Complex64> {
        let rows = self.rows();
        let mut u = start.to_vec();
        // What is missing, and where a step goes.
        let mut r = Vec::with_capacity(rows.len());
        let mut p = Vec::with_capacity(rows.len());
        let (mut size, mut rho) = (0.0, 0.0);
        for (f, (row, &right)) in rows.iter().zip(right).enumerate() {
            let missing = right - row.apply(&u, f);
            r.push(missing);
            p.push(divide(missing, row.diagonal));
            size += square(right) / row.diagonal;
            rho += square(missing) / row.diagonal;
        }
        let mut q = vec![Complex64::ZERO; rows.len()];
        for _ in 0..MOST_STEPS {
            if rho <= RESIDUAL * RESIDUAL * size {
                break;
            }
            let mut along = 0.0;
            for (f, (row, q)) in rows.iter().zip(&mut q).enumerate() {
                *q = row.apply(&p, f);
                along += p[f].re * q.re + p[f].im * q.im;
            }
            let step = Complex64::from(rho / along);
            let before = rho;
            rho = 0.0;
            for (f, row) in rows.iter().enumerate() {
                u[f] += step * p[f];
                r[f] -= step * q[f];
                rho += square(r[f]) / row.diagonal;
            }
            let ratio = Complex64::from(rho / before);
            for ((p, &r), row) in p.iter_mut().zip(&r).zip(&rows) {
                *p = divide(r, row.diagonal) + ratio * *p;
            }
        }
        u
    }
}

/// Return the squared absolute value.
fn square(a: Complex64) -> f64 {
    a.re * a.re + a.im * a.im
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_fulfils_the_equations() {
        let turned = [0.6, -0.6].map(|y| Complex64::new(0.8, y));
        let one = Complex64::ONE;
        // Two triangles; side 1 of the first is side 0 of the second.
        let laplacian = Laplacian {
            across: &[-1, 3, -1, 1, -1, -1],
            weight: &[0.0, 2.0, 0.0, 2.0, 0.0, 0.0],
            turned: &[one, turned[0], one, turned[1], one, one],
            pull: &[1.0, 0.5],
        };
        let right = [Complex64::new(1.0, 2.0), Complex64::new(-1.0, 0.5)];
        let u = laplacian.solve(&right, &[one, one]);
        let first = 3.0 * u[0] - 2.0 * turned[0] * u[1] - right[0];
        let second = 2.5 * u[1] - 2.0 * turned[1] * u[0] - right[1];
        assert!(first.l1_norm() < 1e-6 && second.l1_norm() < 1e-6);
    }
}
