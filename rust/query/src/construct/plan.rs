//! Plans: how an outline is cut up, and the mesh that its parts make.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chord_is_in_both_loops() {
        let [left, right] = split_loop(&[0, 1, 2, 3, 4], 4, 6, &[7, 8]);
        assert_eq!(left, [4, 0, 1, 8, 7]);
        assert_eq!(right, [1, 2, 3, 4, 7, 8]);
    }
}
