//! Polygons of any number of corners, cut into triangles.

use crate::leastarea::{Price, triangulate_cheapest};
use crate::vector::Point;

/// The most corners of a face of which the least area is sought: time grows with the cube, and is a
/// millisecond here.
const MOST_EXACT: usize = 128;

/// What an edge's squared length counts next to an area: among equal areas the shorter edges win.
const PRICE: Price = Price {
    shorter: 1e-6,
    thin: 0.0,
};

/// The faces of a mesh: their corners in a row, and where those of each face begin.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a> {
    /// The vertex of every corner.
    pub corners: &'a [i32],
    /// The first corner of every face, and the number of corners.
    pub offsets: &'a [i64],
}

impl<'a> Faces<'a> {
    fn face(&self, f: usize) -> &'a [i32] {
        &self.corners[self.offsets[f] as usize..self.offsets[f + 1] as usize]
    }

    fn iter(&self) -> impl Iterator<Item = &'a [i32]> {
        (1..self.offsets.len()).map(|f| self.face(f - 1))
    }
}

/// Return the triangles of all faces, n - 2 of a face with n corners; (0, 0, 0) where these are more
/// than 128.
///
/// They do not depend on which corner of a face comes first, nor on its sense.
pub fn cut(points: &[Point], faces: Faces) -> Vec<[i32; 3]> {
    let mut triangles = Vec::new();
    for face in faces.iter().filter(|face| face.len() > 2) {
        if face.len() > MOST_EXACT {
            triangles.resize(triangles.len() + face.len() - 2, [0; 3]);
            continue;
        }
        match write_once(face)[..] {
            [a, b, c] => triangles.push([a, b, c]),
            ref face => triangles.extend(cut_face(points, face)),
        }
    }
    triangles
}

/// Write the triangles of some faces of a mesh, each in the sense of its face.
///
/// `rows` has the first triangle of every face, and the number of triangles.
pub fn cut_chosen(
    points: &[Point],
    faces: Faces,
    rows: &[i64],
    chosen: &[i64],
    triangles: &mut [[i32; 3]],
) {
    for &f in chosen {
        let f = f as usize;
        let made = cut_face(points, faces.face(f));
        let written = &mut triangles[rows[f] as usize..rows[f + 1] as usize];
        for (triangle, made) in written.iter_mut().zip(made) {
            *triangle = made;
        }
    }
}

/// Return the triangles of one face.
fn cut_face(points: &[Point], face: &[i32]) -> impl Iterator<Item = [i32; 3]> {
    let corners: Vec<Point> = face.iter().map(|&v| points[v as usize]).collect();
    let (triangles, _) = triangulate_cheapest(&corners, PRICE);
    triangles
        .into_iter()
        .map(|triangle| triangle.map(|k| face[k]))
}

/// Return the lexicographically first of all 2 n ways to write down a face.
pub fn write_once(face: &[i32]) -> Vec<i32> {
    let forward = first_rotation(face);
    let backward: Vec<i32> = face.iter().rev().copied().collect();
    forward.min(first_rotation(&backward))
}

/// Return the lexicographically first rotation; in linear time: two candidates are compared, and
/// what the worse of them has in common with the better is skipped.
fn first_rotation(face: &[i32]) -> Vec<i32> {
    let n = face.len();
    let (mut one, mut other, mut common) = (0, 1, 0);
    while one < n && other < n && common < n {
        let (a, b) = (face[(one + common) % n], face[(other + common) % n]);
        if a == b {
            common += 1;
            continue;
        }
        if a > b {
            one += common + 1;
        } else {
            other += common + 1;
        }
        if one == other {
            other += 1;
        }
        common = 0;
    }
    let (end, start) = face.split_at(one.min(other).min(n));
    [start, end].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_is_written_the_same_from_every_corner_both_ways() {
        let face = [3, 1, 4, 1, 5, 9, 2];
        let once = write_once(&face);
        assert_eq!(once, [1, 3, 2, 9, 5, 1, 4]);
        for k in 0..face.len() {
            let mut other = face;
            other.rotate_left(k);
            assert_eq!(write_once(&other), once);
            other.reverse();
            assert_eq!(write_once(&other), once);
        }
    }

    #[test]
    fn a_concave_face_is_cut_at_its_reflex_corner() {
        let points = [[0.0; 3], [2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0]];
        let (corners, offsets) = ([0, 1, 2, 3, 0, 1], [0, 4, 6]);
        let faces = Faces {
            corners: &corners,
            offsets: &offsets,
        };
        let triangles = cut(&points, faces);
        assert_eq!(triangles, [[0, 2, 3], [0, 1, 2]]);
        let mut written = [[0; 3]; 2];
        cut_chosen(&points, faces, &[0, 2, 2], &[0], &mut written);
        assert_eq!(written, triangles[..]);
    }
}
