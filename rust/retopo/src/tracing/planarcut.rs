//! Cuts of a surface by a plane.
//!
//! A vertex on the plane counts as on the normal's side, so that a cut never branches. In a triangle
//! that is cut, the curve runs from one side to another with the normal on its left.

use patterndb_geometry::Point;
use patterndb_geometry::vector::subtract;

use patterndb_geometry::adjacency::{Surface, Triangle, from_corner, side_corners};

/// The sides by which a cut leaves and enters a triangle; -1 where the plane does not cut it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutSides {
    /// The side by which the cut leaves.
    pub out: i32,
    /// The side by which it enters.
    pub into: i32,
}

/// A part of a cut.
#[derive(Clone, Debug, PartialEq)]
pub struct CutPart {
    /// The sides by which the cut leaves one triangle after the other.
    pub sides: Vec<i32>,
    /// Length from the first side on.
    pub length: f64,
    /// Whether it came back to its first triangle.
    pub closed: bool,
}

/// Return the sides by which a plane's cut leaves and enters a triangle.
///
/// height: of the vertices above the plane.
pub fn find_cut_sides(triangles: &[Triangle], height: &[f64], triangle: usize) -> CutSides {
    let above = triangles[triangle].map(|v| height[v as usize] >= 0.0);
    let mut found = CutSides { out: -1, into: -1 };
    for e in 0..3 {
        let side = (3 * triangle + e) as i32;
        match from_corner(above, e) {
            [false, true, _] => found.out = side,
            [true, false, _] => found.into = side,
            _ => {}
        }
    }
    found
}

/// Return where the plane cuts a side, the same seen from both of its triangles.
pub fn place_crossing(surface: Surface<'_>, height: &[f64], side: i32) -> Point {
    let [tail, head, _] = side_corners(surface.triangles, side);
    let (a, b) = (tail.min(head) as usize, tail.max(head) as usize);
    let t = height[a] / (height[a] - height[b]);
    let (from, to) = (&surface.vertices[a], &surface.vertices[b]);
    [0, 1, 2].map(|c| (1.0 - t) * from[c] + t * to[c])
}

/// Follow a cut from a side by which it leaves a triangle.
///
/// It ends at a border, back at its first triangle, or beyond the length `most`.
pub fn follow_cut(
    surface: Surface<'_>,
    across: &[i32],
    height: &[f64],
    side: i32,
    most: f64,
) -> CutPart {
    let first = side / 3;
    let mut part = CutPart {
        sides: vec![side],
        length: 0.0,
        closed: false,
    };
    let mut side = side;
    let mut at = place_crossing(surface, height, side);
    while part.length <= most {
        let beyond = across[side as usize];
        if beyond < 0 {
            break;
        }
        let CutSides { out, into } = find_cut_sides(surface.triangles, height, beyond as usize / 3);
        // Neighbours may be turned against each other.
        side = if beyond == out { into } else { out };
        let there = place_crossing(surface, height, side);
        let [x, y, z] = subtract(&there, &at);
        part.length += (x * x + y * y + z * z).sqrt();
        at = there;
        if beyond / 3 == first {
            part.closed = true;
            break;
        }
        part.sides.push(side);
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    const VERTICES: [Point; 4] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    /// A tetrahedron.
    const TRIANGLES: [Triangle; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    const ACROSS: [i32; 12] = [9, 6, 3, 2, 8, 10, 1, 11, 4, 0, 5, 7];
    /// Above the plane z = 1/2.
    const HEIGHT: [f64; 4] = [-0.5, -0.5, -0.5, 0.5];

    #[test]
    fn a_cut_around_a_corner_closes() {
        let surface = Surface {
            vertices: &VERTICES,
            triangles: &TRIANGLES,
        };
        let found = find_cut_sides(&TRIANGLES, &HEIGHT, 1);
        assert_eq!(found, CutSides { out: 4, into: 5 });
        assert_eq!(place_crossing(surface, &HEIGHT, 4), [0.5, 0.0, 0.5]);
        let cut = follow_cut(surface, &ACROSS, &HEIGHT, 4, f64::INFINITY);
        assert_eq!(cut.sides, [4, 7, 10]);
        assert!(cut.closed);
        assert!((cut.length - (1.0 + 0.5 * 2.0_f64.sqrt())).abs() < 1e-15);
        let short = follow_cut(surface, &ACROSS, &HEIGHT, 4, 0.1);
        assert_eq!((short.sides.len(), short.closed), (2, false));
    }
}
