//! How many edges a line needs to keep its shape.

use patterndb_geometry::vector::{Point, dot, max, min, subtract};

/// The sagitta that an edge may cut off a curve, in target edges. A ring of four edges of the target
/// length around a limb cuts off 0.21, one of six 0.13. Also in
/// patterndb_sketch.retopo.filling.edgecounts.
const SAGITTA: f64 = 0.125;

/// Return the integral of sqrt(curvature / (8 SAGITTA edge)) along a polyline, in equal steps.
///
/// `closed`: whether the line, whose last point is its first, turns there, too.
pub fn count_bend_edges(line: &[Point], closed: bool, steps: usize, edge: f64) -> f64 {
    let mut length = 0.0;
    for ends in line.windows(2) {
        length += square_distance(&ends[0], &ends[1]).sqrt();
    }
    if length == 0.0 {
        return 0.0;
    }
    let points = resample(line, length, steps);
    let share = length / steps as f64 / (8.0 * SAGITTA * edge);
    let mut total = 0.0;
    for k in if closed { 0 } else { 1 }..steps {
        let back = if k == 0 { steps - 1 } else { k - 1 };
        let one = subtract(&points[back + 1], &points[back]);
        let two = subtract(&points[k + 1], &points[k]);
        let size = (dot(&one, &one) * dot(&two, &two)).sqrt();
        if size > 0.0 {
            let turn = min(max(dot(&one, &two) / size, -1.0), 1.0).acos();
            total += (turn * share).sqrt();
        }
    }
    if closed {
        total
    } else {
        // The turns of an open line lie at one place fewer than it has steps.
        total * steps as f64 / (steps - 1) as f64
    }
}

/// Return points along a line at equal distances: one more than there are steps.
fn resample(line: &[Point], length: f64, steps: usize) -> Vec<Point> {
    let mut points = Vec::with_capacity(steps + 1);
    points.push(line[0]);
    // The distance along the line up to one of its points.
    let (mut before, mut at) = (0.0, 0);
    for k in 1..steps {
        let wanted = length * k as f64 / steps as f64;
        let mut here = square_distance(&line[at], &line[at + 1]).sqrt();
        while before + here < wanted && at + 2 < line.len() {
            before += here;
            at += 1;
            here = square_distance(&line[at], &line[at + 1]).sqrt();
        }
        let t = if here > 0.0 {
            (wanted - before) / here
        } else {
            0.0
        };
        let [a, b] = [&line[at], &line[at + 1]];
        points.push([0, 1, 2].map(|c| (1.0 - t) * a[c] + t * b[c]));
    }
    points.push(line[line.len() - 1]);
    points
}

fn square_distance(a: &Point, b: &Point) -> f64 {
    let way = subtract(a, b);
    dot(&way, &way)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_needs_no_edges() {
        let line = [[0.0; 3], [1.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
        assert_eq!(count_bend_edges(&line, false, 8, 1.0), 0.0);
    }

    #[test]
    fn a_circle_needs_the_more_the_larger_it_is() {
        let count = |radius: f64| {
            let line: Vec<Point> = (0..=64)
                .map(|k| f64::from(k) / 64.0 * std::f64::consts::TAU)
                .map(|angle| [radius * angle.cos(), radius * angle.sin(), 0.0])
                .collect();
            count_bend_edges(&line, true, 16, 1.0)
        };
        // 2 pi radius sqrt(1 / radius).
        assert!((count(4.0) - std::f64::consts::TAU * 2.0).abs() < 0.1);
        assert!((count(1.0) - std::f64::consts::TAU).abs() < 0.1);
    }
}
