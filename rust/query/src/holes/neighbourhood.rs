//! The neighbourhood of a hole: the faces outside of its loop.

use patterndb_geometry::Point;
use patterndb_geometry::vector::{cross, length, subtract};

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
pub(super) fn angle_between(a: &Point, b: &Point, crossed: &Point) -> f64 {
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
    fn faces_are_counted_around_a_vertex() {
        // Two digons, glued: two faces around each vertex.
        assert_eq!(count_faces(&[2, 3, 0, 1], &[1, 0, 3, 2], 0), 2);
        assert_eq!(count_faces(&[-1, -1], &[1, 0], 0), 4);
    }
}
