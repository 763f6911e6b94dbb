//! The backbone of a fishbone: the samples that the stroke was drawn along.

use patterndb_geometry::Point;
use patterndb_geometry::vector::{length, max, subtract};

use super::Ribs;

fn distance(a: &Point, b: &Point) -> f64 {
    length(&subtract(a, b))
}

/// Return the rows of the backbone, each the nearest sample to the one before; -1 where it strays.
///
/// `backbone` are the rows nearest to the stroke, `origins` the stroke's points at the ribs. The
/// backbone is carried from the rib `start` to both ends. It strays where it would go farther than
/// `strayed` times as far as the stroke does.
pub fn carry_backbone(
    ribs: &Ribs,
    backbone: &[i64],
    origins: &[Point],
    start: usize,
    strayed: f64,
) -> Vec<i64> {
    let m = ribs.len();
    let mut rows = vec![-1; m];
    rows[start] = backbone[start];
    let mean = origins.windows(2).fold(0.0, |mean, pair| {
        mean + distance(&pair[1], &pair[0]) / (m - 1) as f64
    });
    let mut carry = |at: usize, last: &mut usize| {
        let here = &ribs.rib(*last)[rows[*last] as usize];
        let (mut best, mut row) = (f64::INFINITY, -1);
        for j in ribs.valid(at) {
            let away = distance(&ribs.rib(at)[j], here);
            if away < best {
                best = away;
                row = j as i64;
            }
        }
        if best <= strayed * max(distance(&origins[at], &origins[*last]), mean) {
            rows[at] = row;
            *last = at;
        }
    };
    let mut last = start;
    (start + 1..m).for_each(|at| carry(at, &mut last));
    last = start;
    (0..start).rev().for_each(|at| carry(at, &mut last));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_samples_are_followed_and_a_far_rib_is_left_out() {
        let points: Vec<Point> = (0..5)
            .flat_map(|i| {
                let away = if i == 3 { 90.0 } else { 0.0 };
                (0..3).map(move |j| [f64::from(i), f64::from(j) + away, 0.0])
            })
            .collect();
        let ribs = Ribs {
            points: &points,
            n_rows: 3,
            first: &[0; 5],
            stop: &[3; 5],
        };
        let origins = [0, 1, 2, 3, 4].map(|i| [f64::from(i), 1.0, 0.0]);
        let rows = carry_backbone(&ribs, &[0, 0, 1, 0, 2], &origins, 2, 3.0);
        assert_eq!(rows, [1, 1, 1, -1, 1]);
    }
}
