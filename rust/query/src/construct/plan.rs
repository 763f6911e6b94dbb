//! Plans: how an outline is cut up, and where it has room for a rectangle.

use std::cmp::Reverse;

/// Return the two loops into which a chord cuts a loop.
///
/// The chord runs from position `start` of the loop over the vertices `inner` to position `end`. The
/// left loop begins at `start`, follows the old loop to `end` and comes back along the chord; the
/// right one begins at `end`, follows the old loop to `start` and comes back. Positions may lie beyond
/// the loop's length: they count on.
pub fn split_loop(vertices: &[i32], start: i64, end: i64, inner: &[i32]) -> [Vec<i32>; 2] {
    let n = vertices.len();
    let [start, end] = [start, end].map(|position| position.rem_euclid(n as i64) as usize);
    let there = (end + n - start) % n;
    let along = |from: usize, steps: usize| (0..=steps).map(move |i| vertices[(from + i) % n]);
    let left = along(start, there).chain(inner.iter().rev().copied());
    let right = along(end, n - there).chain(inner.iter().copied());
    [left.collect(), right.collect()]
}

/// A rectangle in a boundary of P edges, with corners at p, p + a, p + P/2 and p + P/2 + a.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// What its corners gain.
    pub gain: i64,
    /// Boundary vertex of the first corner.
    pub p: i64,
    /// Edges to the next.
    pub a: i64,
}

/// Return the best rectangle; among equals the nearest to a square.
///
/// `gain` holds what a pair of opposite corners at p and p + P/2 gains, for every p below P/2.
pub fn find_best_places(gain: &[i64]) -> Place {
    let half = gain.len() as i64;
    let mut order: Vec<usize> = (0..gain.len()).collect();
    order.sort_by_key(|&p| Reverse(gain[p]));
    let mut best = Place {
        gain: -1,
        p: 0,
        a: 0,
    };
    for (i, &x) in order.iter().enumerate() {
        let others = &order[i + 1..];
        let promising = |y: usize, best: &Place| gain[x] + gain[y] >= best.gain;
        if !others.first().is_some_and(|&y| promising(y, &best)) {
            break;
        }
        for &y in others {
            if !promising(y, &best) {
                break;
            }
            let both = gain[x] + gain[y];
            let a = y.abs_diff(x) as i64;
            let is_squarer = (2 * a - half).abs() < (2 * best.a - half).abs();
            if both > best.gain || is_squarer {
                best = Place {
                    gain: both,
                    p: x.min(y) as i64,
                    a,
                };
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chord_is_in_both_loops() {
        let [left, right] = split_loop(&[0, 1, 2, 3, 4], 4, 6, &[7, 8]);
        assert_eq!(left, [4, 0, 1, 8, 7]);
        assert_eq!(right, [1, 2, 3, 4, 7, 8]);
    }

    #[test]
    fn the_best_rectangle_gains_most_and_is_squarest() {
        let place = |gain, p, a| Place { gain, p, a };
        assert_eq!(find_best_places(&[0, 2, 0, 2, 0]), place(4, 1, 2));
        assert_eq!(find_best_places(&[0; 4]), place(0, 0, 2));
    }
}
