//! The curvature of a surface about points, gathered from dots.

use patterndb_geometry::vector::{Point, dot, subtract};

/// Beyond this many widths the weights, below e^-8, are left out. Also in
/// patterndb_sketch.retopo.tools.salience.
const REACH: f64 = 4.0;

/// Numbers of cells are this many bits wide in a key of 63, for each of the three axes. Also in
/// patterndb_sketch.retopo.tools.salience.
const CELL_BITS: u32 = 21;

/// Dots of curvature on a surface, by cells of `REACH * width`.
#[derive(Clone, Copy, Debug)]
pub struct Dots<'a> {
    /// Where they are.
    pub points: &'a [Point],
    /// The surface's normals there.
    pub normals: &'a [Point],
    /// The curvature of each, times its area: xx, yy, zz, xy, xz, yz of a symmetric matrix.
    pub tensors: &'a [[f64; 6]],
    /// Where the cells begin.
    pub low: &'a Point,
    /// The cells that have dots, in order.
    pub keys: &'a [i64],
    /// The dots of cell k are `starts[k]` to `starts[k + 1]`.
    pub starts: &'a [i64],
    /// The width of the Gaussian weights.
    pub width: f64,
}

/// Weighted sums over dots: of their tensors, and of these times x, y and z of the way to the dot.
pub type Sums = [[f64; 6]; 4];

impl Dots<'_> {
    /// Return the sums over the dots near a point that lie on the side of the surface that its
    /// normal looks to.
    pub fn sum(&self, at: &Point, up: &Point) -> Sums {
        let reach = REACH * self.width;
        let [x, y, z] = [0, 1, 2].map(|c| {
            let cell = ((at[c] - self.low[c]) / reach).floor() as i64;
            cell.saturating_sub(1).max(0)..cell.saturating_add(2)
        });
        let mut sums = [[0.0; 6]; 4];
        for x in x {
            for y in y.clone() {
                for z in z.clone() {
                    let key = (x << (2 * CELL_BITS)) | (y << CELL_BITS) | z;
                    let Ok(cell) = self.keys.binary_search(&key) else {
                        continue;
                    };
                    for dot in self.starts[cell] as usize..self.starts[cell + 1] as usize {
                        self.add(dot, at, up, &mut sums);
                    }
                }
            }
        }
        sums
    }

    #[inline]
    fn add(&self, k: usize, at: &Point, up: &Point, sums: &mut Sums) {
        let way = subtract(&self.points[k], at);
        let far = dot(&way, &way) / (self.width * self.width);
        if far > REACH * REACH || dot(&self.normals[k], up) <= 0.0 {
            return;
        }
        let weight = (-0.5 * far).exp();
        let weighted = self.tensors[k].map(|x| weight * x);
        let [sum, by_axis @ ..] = sums;
        for (sum, x) in sum.iter_mut().zip(weighted) {
            *sum += x;
        }
        for (sum, way) in by_axis.iter_mut().zip(way) {
            for (sum, x) in sum.iter_mut().zip(weighted) {
                *sum += x * way;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_dots_on_the_same_side_count() {
        let dots = Dots {
            points: &[[0.0; 3], [1.0, 0.0, 0.0], [40.0, 0.0, 0.0]],
            normals: &[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]],
            tensors: &[[2.0; 6]; 3],
            low: &[0.0; 3],
            keys: &[0, 10 << (2 * CELL_BITS)],
            starts: &[0, 2, 3],
            width: 1.0,
        };
        let sums = dots.sum(&[0.5, 0.0, 0.0], &[0.0, 0.0, 1.0]);
        let weight = (-0.125_f64).exp();
        assert_eq!(sums, [[2.0 * weight; 6], [-weight; 6], [0.0; 6], [0.0; 6]]);
    }
}
