//! What a loop encloses.

use patterndb_geometry::Point;
use patterndb_geometry::vector::{cross, dot, length, subtract};

/// What a loop encloses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Enclosed {
    /// Signed area, positive if the loop runs counter-clockwise seen from outside.
    pub area: f64,
    /// The same without the signs of its triangles.
    pub unsigned: f64,
    /// Length of the loop.
    pub length: f64,
}

/// Measure what a closed polyline, which does not repeat its first point, encloses on a surface
/// with these normals.
///
/// Source: Takayama et al. 2013, equation 1, with the mean of the points as the centre.
pub fn sum_areas(points: &[Point], normals: &[Point]) -> Enclosed {
    let n = points.len() as f64;
    let centre = points.iter().fold([0.0; 3], |centre, point| {
        [0, 1, 2].map(|c| centre[c] + point[c] / n)
    });
    let follower = points.iter().cycle().skip(1);
    let mut found = Enclosed::default();
    for ((point, next), normal) in points.iter().zip(follower).zip(normals) {
        let (u, v) = (subtract(point, &centre), subtract(next, &centre));
        let doubled = cross(&u, &v);
        found.area += 0.5 * dot(&doubled, normal);
        found.unsigned += 0.5 * length(&doubled);
        found.length += length(&subtract(&v, &u));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_encloses_its_area() {
        let points = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
        let found = sum_areas(&points, &[[0.0, 0.0, 1.0]; 4]);
        assert_eq!((found.area, found.unsigned, found.length), (4.0, 4.0, 8.0));
        let found = sum_areas(&points, &[[0.0, 0.0, -1.0]; 4]);
        assert_eq!(found.area, -4.0);
    }
}
