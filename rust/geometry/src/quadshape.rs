//! The shape of placed quads.

use std::f64::consts::PI;

use crate::vector::{Point, cross, dot, length, subtract};

/// Return how far the quads' angles are from right, in radians squared: the smaller, the squarer.
///
/// The deviations of the four angles of a quad from 90 degrees, squared and summed, and the mean of
/// that over the quads (Marcias et al. 2015, section 4, "Geometric sorting": "the average quality of
/// the quads"). 0 for rectangles; an angle beyond 180 degrees counts as such.
pub fn squareness(quads: &[[i32; 4]], vertices: &[Point]) -> f64 {
    let mut total = 0.0;
    for quad in quads {
        let corner = quad.map(|v| &vertices[v as usize]);
        let between = |from: usize, to: usize| subtract(corner[to], corner[from]);
        let up = cross(&between(0, 2), &between(1, 3));
        for e in 0..4 {
            let (leaving, entering) = (between(e, (e + 1) % 4), between(e, (e + 3) % 4));
            let normal = cross(&leaving, &entering);
            let mut angle = length(&normal).atan2(dot(&leaving, &entering));
            if dot(&normal, &up) < 0.0 {
                angle = 2.0 * PI - angle;
            }
            let off = angle - 0.5 * PI;
            total += off * off;
        }
    }
    total / quads.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_is_square_and_a_dart_is_not() {
        let mut vertices = [[0.0; 3], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(squareness(&[[0, 1, 2, 3]], &vertices), 0.0);
        vertices[2] = [0.5, 0.1, 0.0];
        assert!(squareness(&[[0, 1, 2, 3]], &vertices) > 1.0);
    }
}
