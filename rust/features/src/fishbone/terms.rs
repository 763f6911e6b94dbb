//! What pulls a curve along its ribs: bends of the surface.

use patterndb_geometry::Point;
use patterndb_geometry::vector::{dot, length, max, min, subtract};

use super::Ribs;

/// Bends are measured over this many windows at once. The narrowest shows where a sharp edge is, the
/// widest where the middle of a rounded one is, whose own bends are all alike. As `SCALES` of the
/// Python module `patterndb_sketch.features.fishbone.terms`.
const SCALES: [f64; 2] = [1.0, 4.0];

/// Unit vectors that differ by less are one, apart from rounding.
const SAME_WAY: f64 = 1e-9;

/// Samples are taken to be no nearer to each other than this part of a window: ribs of hardly any
/// length, too, bend by what they turn over the whole window.
const LEAST_SPACING: f64 = 1e-9;

/// Return how much ribs bend at each sample, in radians per length; 0 where there is none.
///
/// `spacing` is the distance between the samples of each rib. The mean over the chords to both sides,
/// each a window long: the angle between both chords per window, taken over several windows, the sum
/// of their angles per sum of their lengths.
///
/// Source: feature curve recovery paper, section 4.3.3. Differs from the paper: the angle over the
/// length along the rib, which has a peak at corners, and is the same on circles.
pub fn measure_bends(ribs: &Ribs, spacing: &[f64], window: f64) -> Vec<f64> {
    let mut result = vec![0.0; ribs.points.len()];
    let rows = result.chunks_exact_mut(ribs.n_rows);
    for (i, (row, &spacing)) in rows.zip(spacing).enumerate() {
        let step = max(spacing, LEAST_SPACING * window);
        for j in ribs.inner(i) {
            let room = ribs.room(i, j);
            let turn_per_sample = |reach: usize| {
                let reach = reach.min(room);
                turn(ribs.rib(i), j, reach) / reach as f64
            };
            let (mut total, mut length) = (0.0, 0.0);
            for scale in SCALES {
                // A window between two whole numbers of samples is a mixture of both: a circle's
                // curvature is exact for either.
                let steps = max(scale * window / step, 1.0);
                let fewer = steps as usize;
                let share = steps - fewer as f64;
                let (low, high) = (turn_per_sample(fewer), turn_per_sample(fewer + 1));
                total += ((1.0 - share) * low + share * high) * min(steps, room as f64);
                length += steps;
            }
            row[j] = total / (length * step);
        }
    }
    result
}

/// Return the angle between the chords to and from sample j, `reach` samples long.
fn turn(rib: &[Point], j: usize, reach: usize) -> f64 {
    let before = subtract(&rib[j], &rib[j - reach]);
    let after = subtract(&rib[j + reach], &rib[j]);
    let mut across = 0.0;
    for c in 0..3 {
        let d = (c + 1) % 3;
        let turn = before[c] * after[d] - before[d] * after[c];
        across += turn * turn;
    }
    // Adding 0 makes 0 of -0.
    across.sqrt().atan2(0.0 + dot(&before, &after))
}

/// Return the unit vector from the chord to each sample to that from it, 0 where they are one.
pub fn find_ways(ribs: &Ribs, spacing: &[f64], window: f64) -> Vec<Point> {
    let mut result = vec![[0.0; 3]; ribs.points.len()];
    let rows = result.chunks_exact_mut(ribs.n_rows);
    for (i, (row, &spacing)) in rows.zip(spacing).enumerate() {
        let step = max(spacing, LEAST_SPACING * window);
        let steps = max((window / step).round_ties_even(), 1.0) as usize;
        let rib = ribs.rib(i);
        for j in ribs.inner(i) {
            let reach = steps.min(ribs.room(i, j));
            let before = subtract(&rib[j], &rib[j - reach]);
            let after = subtract(&rib[j + reach], &rib[j]);
            let (one, other) = (length(&before), length(&after));
            if one > 0.0 && other > 0.0 {
                let way = subtract(&after.map(|x| x / other), &before.map(|x| x / one));
                let size = length(&way);
                if size > SAME_WAY {
                    row[j] = way.map(|x| x / size);
                }
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of a circle of radius 2, 0.1 apart.
    fn circle() -> Vec<Point> {
        let angle = |j: i32| f64::from(j) * 0.05;
        (0..60)
            .map(|j| [2.0 * angle(j).cos(), 2.0 * angle(j).sin(), 0.0])
            .collect()
    }

    #[test]
    fn a_circle_bends_by_its_radius_towards_its_middle() {
        let points = circle();
        let ribs = Ribs {
            points: &points,
            n_rows: 60,
            first: &[1],
            stop: &[59],
        };
        let bends = measure_bends(&ribs, &[0.1], 0.25);
        assert!(bends[12..48].iter().all(|bend| (bend - 0.5).abs() < 1e-9));
        assert_eq!((bends[1], bends[58]), (0.0, 0.0));
        let ways = find_ways(&ribs, &[0.1], 0.25);
        for (way, point) in ways[2..58].iter().zip(&points[2..58]) {
            assert!((dot(way, point) + 2.0).abs() < 1e-9);
        }
    }
}
