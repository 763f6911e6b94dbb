//! Where a mesh crosses itself: pairs of triangles that go through each other.

use patterndb_geometry::Point;
use patterndb_geometry::tree::{Tree, Triangle};
use patterndb_geometry::vector::{cross, dot, length, max, min, subtract};

/// Faces that reach through each other by less than this, as a part of the mesh's diagonal, touch:
/// far above rounding, far below anything drawn.
const TOUCH: f64 = 1e-9;

/// A triangle flatter than this part of the mesh's diagonal has no plane: rounding moves its far
/// points by TOUCH.
const THIN: f64 = 1e-7;

/// A triangle and its plane.
struct Face<'a> {
    corners: &'a Triangle,
    vertices: &'a [i64; 3],
    normal: Point,
}

/// How a triangle lies to another's plane.
enum Reach {
    /// It does not reach through.
    Apart,
    /// It lies in the plane.
    Within,
    /// It meets the plane between two places.
    Through([Point; 2]),
}

/// Return the pairs of triangles that cross, the lower number first, found down the tree of their
/// boxes. The diagonal of the mesh is 1.
///
/// `vertices` are the numbers of the triangles' corners. Triangles of one `owner` are not compared.
pub fn find_crossings(tree: &Tree, vertices: &[[i64; 3]], owner: &[i64]) -> Vec<[i64; 2]> {
    let faces: Vec<Option<Face>> = tree
        .corners
        .iter()
        .zip(vertices)
        .map(|(corners, vertices)| Face::new(corners, vertices))
        .collect();
    let mut found = Vec::new();
    let mut stack = Vec::new();
    for (i, face) in faces.iter().enumerate() {
        let Some(face) = face else { continue };
        let [a, b, c] = face.corners;
        // Wider by what counts as touching: triangles in one plane have flat boxes.
        let low = [0, 1, 2].map(|k| min(min(a[k], b[k]), c[k]) - TOUCH);
        let high = [0, 1, 2].map(|k| max(max(a[k], b[k]), c[k]) + TOUCH);
        let near = tree.select(&mut stack, |[from, to]| {
            !(0..3).any(|k| from[k] > high[k] || to[k] < low[k])
        });
        for j in near {
            let j = j as usize;
            if j <= i || owner[i] == owner[j] {
                continue;
            }
            if faces[j].as_ref().is_some_and(|other| face.crosses(other)) {
                found.push([i as i64, j as i64]);
            }
        }
    }
    found
}

impl<'a> Face<'a> {
    /// Return a triangle with its normal; None if it is too flat to have one.
    fn new(corners: &'a Triangle, vertices: &'a [i64; 3]) -> Option<Face<'a>> {
        let [a, b, c] = corners;
        let longest = [(a, b), (b, c), (c, a)]
            .map(|(from, to)| length(&subtract(to, from)))
            .into_iter()
            .fold(0.0, max);
        let normal = cross(&subtract(b, a), &subtract(c, a));
        // Twice the area: base times height.
        let size = length(&normal);
        (size > THIN * longest).then(|| Face {
            corners,
            vertices,
            normal: normal.map(|x| x / size),
        })
    }

    /// Return whether two triangles go through each other, or overlap in one plane.
    ///
    /// Source: Moeller 1997, "A fast triangle-triangle intersection test": the stretches in which
    /// each meets the other's plane are on one line, and are compared there.
    fn crosses(&self, other: &Face) -> bool {
        let mine = self.reach(other);
        if matches!(mine, Reach::Apart) {
            return false;
        }
        match (mine, other.reach(self)) {
            (_, Reach::Apart) => false,
            (Reach::Through(mine), Reach::Through(other)) => overlap(&mine, &other),
            _ => !self.is_apart(other) && !other.is_apart(self),
        }
    }

    /// Return how the triangle lies to another's plane.
    fn reach(&self, other: &Face) -> Reach {
        let mut heights = [0.0; 3];
        let corners = self.corners.iter().zip(self.vertices);
        for (height, (corner, vertex)) in heights.iter_mut().zip(corners) {
            // A common corner is in the plane, also where rounding puts it elsewhere.
            if !other.vertices.contains(vertex) {
                let above = dot(&subtract(corner, &other.corners[0]), &other.normal);
                if above.abs() > TOUCH {
                    *height = above;
                }
            }
        }
        let above = heights.iter().any(|&height| height > 0.0);
        let below = heights.iter().any(|&height| height < 0.0);
        match (above, below) {
            (false, false) => return Reach::Within,
            (true, true) => {}
            _ => return Reach::Apart,
        }
        let mut ends = [[0.0; 3]; 2];
        let mut count = 0;
        for e in 0..3 {
            let f = (e + 1) % 3;
            let (from, to) = (&self.corners[e], &self.corners[f]);
            if heights[e] == 0.0 {
                ends[count] = *from;
                count += 1;
            } else if heights[e] * heights[f] < 0.0 {
                let share = heights[e] / (heights[e] - heights[f]);
                ends[count] = [0, 1, 2].map(|c| from[c] + share * (to[c] - from[c]));
                count += 1;
            }
        }
        Reach::Through(ends)
    }

    /// Return whether an edge has another triangle of the same plane beyond it.
    fn is_apart(&self, other: &Face) -> bool {
        (0..3).any(|e| {
            let (p, q) = (&self.corners[e], &self.corners[(e + 1) % 3]);
            // Into the triangle, across the edge.
            let across = cross(&self.normal, &subtract(q, p));
            let size = length(&across);
            let deepest = other.corners.iter().fold(f64::NEG_INFINITY, |deepest, r| {
                max(deepest, dot(&subtract(r, p), &across) / size)
            });
            deepest <= TOUCH
        })
    }
}

/// Return whether two stretches of one line overlap by more than TOUCH.
fn overlap([from, to]: &[Point; 2], other: &[Point; 2]) -> bool {
    let along = subtract(to, from);
    let size = length(&along);
    if size <= TOUCH {
        return false;
    }
    let along = along.map(|x| x / size);
    let [first, second] = other.map(|place| dot(&subtract(&place, from), &along));
    min(size, max(first, second)) - max(0.0, min(first, second)) > TOUCH
}

#[cfg(test)]
mod tests {
    use patterndb_geometry::tree::build;

    use super::*;

    fn crossings(points: &[Point], triangles: &[[i64; 3]]) -> Vec<[i64; 2]> {
        let corners: Vec<Triangle> = triangles
            .iter()
            .map(|triangle| triangle.map(|v| points[v as usize]))
            .collect();
        let owner: Vec<i64> = (0..triangles.len() as i64).collect();
        let boxes = build(&corners);
        find_crossings(&boxes.tree(&corners), triangles, &owner)
    }

    #[test]
    fn triangles_cross_where_they_go_through_each_other() {
        let points = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.25, 0.25, -0.5],
            [0.25, 0.25, 0.5],
            [2.0, 2.0, 0.5],
            [1.0, 1.0, 0.0],
            [0.5, 0.25, 0.0],
        ];
        assert_eq!(crossings(&points, &[[0, 1, 2], [3, 4, 5]]), [[0, 1]]);
        // Along an edge, and with a common corner.
        assert!(crossings(&points, &[[0, 1, 2], [2, 1, 6]]).is_empty());
        assert!(crossings(&points, &[[0, 1, 2], [0, 3, 4]]).len() == 1);
        assert!(crossings(&points, &[[0, 1, 2], [1, 5, 4]]).is_empty());
        // In one plane: folded onto the other, or next to it.
        assert_eq!(crossings(&points, &[[0, 1, 2], [1, 0, 7]]), [[0, 1]]);
        // Too flat to have a plane.
        assert!(crossings(&points, &[[0, 1, 2], [0, 6, 0]]).is_empty());
    }
}
