//! What surrounds a hole: the faces outside, and the loop's own angles and lengths.

use std::f64::consts::PI;

use patterndb_geometry::Point;
use patterndb_geometry::vector::{cross, length, max, min, subtract};

use super::sum_products;

/// Faces around a vertex that are counted at most.
const MOST_FACES: i32 = 64;

/// Return the number of faces around the tail of half-edge `h`, 4 where the border is met.
///
/// `twin` and `following` have the half-edge on the other side of each, and the next of its face.
pub fn count_faces(twin: &[i32], following: &[i32], h: i32) -> i32 {
    let mut g = h;
    for count in 1..=MOST_FACES {
        g = twin[g as usize];
        if g < 0 {
            return super::REGULAR;
        }
        g = following[g as usize];
        if g == h {
            return count;
        }
    }
    MOST_FACES
}

/// Faces around a hole, whose first vertices are those of the loop.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a> {
    /// Where all vertices lie.
    pub points: &'a [Point],
    /// The vertices of each face, face after face.
    pub corners: &'a [i32],
    /// Where those of each begin, and how many there are in all.
    pub offsets: &'a [i64],
    /// The number of the loop's vertices.
    pub n_loop: usize,
}

impl Faces<'_> {
    /// Iterate over the faces' vertices.
    fn iter(&self) -> impl Iterator<Item = &[i32]> {
        let bounds = self.offsets.windows(2);
        bounds.map(|bounds| &self.corners[bounds[0] as usize..bounds[1] as usize])
    }

    fn point(&self, v: i32) -> &Point {
        &self.points[v as usize]
    }

    /// Return the normal of a face, as long as twice its area.
    fn normal(&self, face: &[i32]) -> Point {
        let mut normal = [0.0; 3];
        let from = |v: i32| subtract(self.point(v), self.point(face[0]));
        for pair in face[1..].windows(2) {
            add(&mut normal, &cross(&from(pair[0]), &from(pair[1])));
        }
        normal
    }
}

fn add(sum: &mut Point, vector: &Point) {
    for (sum, vector) in sum.iter_mut().zip(vector) {
        *sum += vector;
    }
}

fn divide(vector: &Point, by: f64) -> Point {
    vector.map(|axis| axis / by)
}

/// Return the angle between two vectors, from their cross product.
fn angle_between(a: &Point, b: &Point, crossed: &Point) -> f64 {
    length(crossed).atan2(sum_products(a, b))
}

/// Return for each loop vertex the unit normal of the faces outside, weighted by their angles, 0
/// where there are none; and the angle that they take, in radians.
pub fn measure_fans(faces: &Faces) -> (Vec<Point>, Vec<f64>) {
    let mut normals = vec![[0.0; 3]; faces.n_loop];
    let mut angles = vec![0.0; faces.n_loop];
    for face in faces.iter() {
        let k = face.len();
        for (e, &v) in face.iter().enumerate() {
            let v = v as usize;
            if v >= faces.n_loop {
                continue;
            }
            let a = subtract(faces.point(face[(e + 1) % k]), &faces.points[v]);
            let b = subtract(faces.point(face[(e + k - 1) % k]), &faces.points[v]);
            let crossed = cross(&a, &b);
            let size = length(&crossed);
            let angle = angle_between(&a, &b, &crossed);
            angles[v] += angle;
            if size > 0.0 {
                add(
                    &mut normals[v],
                    &divide(&crossed, size).map(|axis| axis * angle),
                );
            }
        }
    }
    for normal in &mut normals {
        let size = length(normal);
        if size > 0.0 {
            *normal = divide(normal, size);
        }
    }
    (normals, angles)
}

/// Return the unit normals of the faces across the loop's edges, 0 where there is none.
pub fn find_normals_beyond(faces: &Faces) -> Vec<Point> {
    let n = faces.n_loop;
    let mut beyond = vec![[0.0; 3]; n];
    for face in faces.iter() {
        for (e, &w) in face.iter().enumerate() {
            let v = face[(e + 1) % face.len()] as usize;
            if v >= n || w as usize != (v + 1) % n {
                continue;
            }
            let normal = faces.normal(face);
            let size = length(&normal);
            if size > 0.0 {
                beyond[v] = divide(&normal, size);
            }
        }
    }
    beyond
}

/// The numbers of a loop vertex; `OWN` in query/holes/surroundings.py is the same.
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

    /// A square of the plane, the loop, and a face outside of its first edge.
    const POINTS: [Point; 6] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
    ];

    #[test]
    fn faces_outside_give_normals_and_angles() {
        let faces = Faces {
            points: &POINTS,
            corners: &[0, 4, 5, 1],
            offsets: &[0, 4],
            n_loop: 4,
        };
        let up = [0.0, 0.0, 1.0];
        let none = [0.0; 3];
        let (normals, angles) = measure_fans(&faces);
        assert_eq!(normals, [up, up, none, none]);
        assert_eq!(angles, [FRAC_PI_2, FRAC_PI_2, 0.0, 0.0]);
        assert_eq!(find_normals_beyond(&faces), [up, none, none, none]);
    }

    #[test]
    fn a_square_has_right_angles() {
        let rim = Rim {
            points: &POINTS[..4],
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

    #[test]
    fn faces_are_counted_around_a_vertex() {
        // Two digons, glued: two faces around each vertex.
        assert_eq!(count_faces(&[2, 3, 0, 1], &[1, 0, 3, 2], 0), 2);
        assert_eq!(count_faces(&[-1, -1], &[1, 0], 0), 4);
    }
}
