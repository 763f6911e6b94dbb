//! Where around a node a chain leaves it.

use std::f64::consts::PI;

use patterndb_geometry::Point;
use patterndb_geometry::vector::{cross, dot, length, subtract};

/// Return the vector from the first (or last) point of a polyline to the place at this arc length
/// along it, or to its other end if that is nearer.
pub fn find_departure(points: &[Point], backwards: bool, reach: f64) -> Point {
    let n = points.len();
    let point = |k: usize| &points[if backwards { n - 1 - k } else { k }];
    let mut departure = [0.0; 3];
    let mut left = reach;
    for k in 1..n {
        let step = subtract(point(k), point(k - 1));
        let size = length(&step);
        let share = if size > left { left / size } else { 1.0 };
        departure = [0, 1, 2].map(|c| departure[c] + share * step[c]);
        if size >= left {
            break;
        }
        left -= size;
    }
    departure
}

/// Return the angle from one direction to another, counter-clockwise about a unit normal, in its
/// tangent plane: 0 to 2 pi.
pub fn measure_turn(normal: &Point, one: &Point, two: &Point) -> f64 {
    let (up_one, up_two) = (dot(one, normal), dot(two, normal));
    let sine = dot(&cross(one, two), normal);
    let cosine = dot(one, two) - up_one * up_two;
    let angle = sine.atan2(cosine);
    if angle >= 0.0 {
        angle
    } else {
        angle + 2.0 * PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_departure_ends_within_a_segment() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0]];
        assert_eq!(find_departure(&points, false, 2.0), [1.0, 1.0, 0.0]);
        assert_eq!(find_departure(&points, true, 1.0), [0.0, -1.0, 0.0]);
        assert_eq!(find_departure(&points, false, 9.0), [1.0, 2.0, 0.0]);
        assert_eq!(find_departure(&[], true, 1.0), [0.0; 3]);
    }

    #[test]
    fn turns_are_counter_clockwise() {
        let (x, y, up) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(measure_turn(&up, &x, &y), 0.5 * PI);
        assert_eq!(measure_turn(&up, &y, &x), 1.5 * PI);
        assert_eq!(measure_turn(&up, &x, &[2.0, 0.0, 3.0]), 0.0);
    }
}
