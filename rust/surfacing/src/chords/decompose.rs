//! By how much chords make a cycle flatter.

use patterndb_geometry::vector::{Point, max};

use crate::chords::flatness::{find_determinant, sum_moments};

/// Return for each chord the box of a loop less the boxes of the two sides of the chord.
///
/// A box is the product of the standard deviations along the principal axes. Chords are positions
/// i < j in the loop.
pub fn measure_gains(points: &[Point], chords: &[[i64; 2]]) -> Vec<f64> {
    let whole = measure_box(points);
    let gains = chords.iter().map(|chord| {
        let [i, j] = chord.map(|end| end as usize);
        let one = measure_box(&points[i..=j]);
        let other = measure_box(points[j..].iter().chain(&points[..=i]));
        whole - one - other
    });
    gains.collect()
}

fn measure_box<'a>(points: impl IntoIterator<Item = &'a Point>) -> f64 {
    max(0.0, find_determinant(&sum_moments(points))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chord_between_two_planes_takes_the_whole_box_away() {
        // A square folded along its diagonal, with a vertex in every side.
        let points = [
            [0.0, 0.0, 0.0],
            [0.5, 0.0, 0.5],
            [1.0, 0.0, 1.0],
            [1.0, 0.5, 0.5],
            [1.0, 1.0, 0.0],
            [0.5, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.5, 0.0],
        ];
        let gains = measure_gains(&points, &[[0, 4], [1, 5]]);
        assert_eq!(gains[0], measure_box(&points));
        assert!(gains[1] < gains[0]);
    }
}
