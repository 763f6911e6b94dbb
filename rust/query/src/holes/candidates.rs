//! Candidates for the fill of a hole.

use super::REGULAR;

/// Turn quads such that loop vertex 0 of `0..n` becomes vertex `first`; return them, and the number
/// of quads at each loop vertex.
///
/// No quads where a loop vertex has none, or more than four.
pub fn turn_quads(quads: &[[i32; 4]], first: i32, n: usize) -> (Vec<[i32; 4]>, Vec<i32>) {
    let mut counts = vec![0; n];
    let mut turn = |v: i32| {
        if v >= n as i32 {
            return v;
        }
        let turned = (v + first).rem_euclid(n as i32);
        counts[turned as usize] += 1;
        turned
    };
    let mut turned: Vec<_> = quads.iter().map(|quad| quad.map(&mut turn)).collect();
    if counts.iter().any(|count| !(1..=REGULAR).contains(count)) {
        turned.clear();
    }
    (turned, counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loop_vertices_are_turned_and_others_stay() {
        let quads = [[0, 1, 8, 7], [1, 2, 3, 8], [7, 8, 5, 6], [8, 3, 4, 5]];
        let (turned, counts) = turn_quads(&quads, -1, 8);
        assert_eq!(turned[0], [7, 0, 8, 6]);
        assert_eq!(counts, [2, 1, 2, 1, 2, 1, 2, 1]);
        assert!(turn_quads(&quads[..1], 0, 8).0.is_empty());
    }
}
