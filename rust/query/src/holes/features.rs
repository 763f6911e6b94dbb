//! Features of holes: the angles and lengths of the loop itself.

use std::f64::consts::PI;

use patterndb_geometry::Point;
use patterndb_geometry::vector::{cross, length, max, min, subtract};

use super::neighbourhood::angle_between;
use super::sum_products;

/// The numbers of a loop vertex; `OWN` in query/holes/features.py is the same.
pub const OWN: usize = 15;

/// A loop and what is known at its vertices.
#[derive(Clone, Copy, Debug)]
pub struct Rim<'a> {
    /// Where the vertices lie.
    pub points: &'a [Point],
    /// Unit normals of the faces outside.
    pub normals: &'a [Point],
    /// The angles of the faces outside, in radians.
    pub angle_outside: &'a [f64],
    /// The number of faces outside.
    pub outside: &'a [i32],
    /// The quads that would make each vertex regular, from 1 to 4.
    pub clamped_valence: &'a [i32],
    /// The length of edges around.
    pub scale: f64,
    /// Mean logarithms of the lengths of edges that leave the loop outwards, NaN where none does.
    pub spokes: &'a [f64],
    /// The faces at their far ends, less 4.
    pub far: &'a [f64],
}

impl Rim<'_> {
    /// Return how far the loop is across at a vertex: the distance to the nearest vertex that is
    /// more than two edges away, at most 100 times the scale.
    fn find_width(&self, i: usize) -> Option<f64> {
        let n = self.points.len();
        let mut near = f64::INFINITY;
        for (j, point) in self.points.iter().enumerate() {
            let apart = i.abs_diff(j);
            if apart.min(n - apart) > 2 {
                near = min(near, length(&subtract(point, &self.points[i])));
            }
        }
        (near < f64::INFINITY).then(|| min(near, 100.0 * self.scale))
    }

    /// Return the numbers of a vertex alone, and of the edges at it.
    fn measure_vertex(&self, i: usize) -> [f64; OWN] {
        let n = self.points.len();
        let (next, previous) = ((i + 1) % n, (i + n - 1) % n);
        let a = subtract(&self.points[next], &self.points[i]);
        let b = subtract(&self.points[previous], &self.points[i]);
        let tiny = 1e-12 * self.scale;
        let (la, lb) = (max(length(&a), tiny), max(length(&b), tiny));
        let normal = &self.normals[i];
        let along = |other: &Point| sum_products(normal, other);
        let outside = self.outside[i];
        [
            f64::from(self.clamped_valence[i]),
            angle_inside(&a, &b, normal),
            2.0 * PI - self.angle_outside[i],
            f64::from(outside),
            angle_between(&a, &b, &cross(&a, &b)),
            (la / self.scale).ln(),
            (lb / self.scale).ln(),
            along(&self.normals[next]),
            along(&self.normals[previous]),
            along(&a) / la,
            along(&b) / lb,
            if self.spokes[i].is_nan() {
                0.0
            } else {
                self.spokes[i] - self.scale.ln()
            },
            self.far[i],
            self.angle_outside[i] / f64::from(outside.max(1)),
            self.find_width(i)
                .map_or(0.0, |width| (width / self.scale).ln()),
        ]
    }
}

/// Return the angle from vector `a` to `b` in the plane across a normal, from 0 to 2 pi.
fn angle_inside(a: &Point, b: &Point, normal: &Point) -> f64 {
    let flat = |vector: &Point| {
        let height = sum_products(vector, normal);
        subtract(vector, &normal.map(|axis| axis * height))
    };
    let (u, w) = (flat(a), flat(b));
    let sine = sum_products(&cross(&u, &w), normal);
    let angle = sine.atan2(sum_products(&u, &w));
    if angle < 0.0 { angle + 2.0 * PI } else { angle }
}

/// Return the numbers of each loop vertex alone, and of the edges at it.
pub fn own_features(rim: &Rim) -> Vec<[f64; OWN]> {
    (0..rim.points.len())
        .map(|i| rim.measure_vertex(i))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// A square of the plane.
    const POINTS: [Point; 4] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];

    #[test]
    fn a_square_has_right_angles() {
        let rim = Rim {
            points: &POINTS,
            normals: &[[0.0, 0.0, 1.0]; 4],
            angle_outside: &[PI; 4],
            outside: &[2; 4],
            clamped_valence: &[2; 4],
            scale: 1.0,
            spokes: &[f64::NAN; 4],
            far: &[0.0; 4],
        };
        let rows = own_features(&rim);
        assert!(rows.iter().all(|row| row == &rows[0]));
        assert_eq!(rows[0][..5], [2.0, FRAC_PI_2, PI, 2.0, FRAC_PI_2]);
        assert_eq!(rows[0][5..11], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
        assert_eq!(rows[0][11..], [0.0, 0.0, FRAC_PI_2, 0.0]);
    }
}
