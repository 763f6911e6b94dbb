//! The part of a surface that a boundary encloses.

/// Triangles in pieces: of each the least triangle that it is known to be joined with.
struct Pieces(Vec<usize>);

impl Pieces {
    /// Return the least triangle of the piece that a triangle is in; the way there becomes shorter.
    fn root(&mut self, triangle: i32) -> usize {
        let mut f = triangle as usize;
        while self.0[f] != f {
            self.0[f] = self.0[self.0[f]];
            f = self.0[f];
        }
        f
    }

    fn join(&mut self, a: i32, b: i32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}

/// Return whether each triangle is one that a boundary crosses, or on its left, and whether the
/// boundary parts the left from the right.
///
/// `beside` are pairs of triangles with a common edge. `barrier` are the triangles that the boundary
/// crosses. `voters` are triangles next to these, and `sides` is 1 for those on the left of the
/// boundary, -1 for those on its right.
pub fn flood_left(
    beside: &[[i32; 2]],
    barrier: &[bool],
    voters: &[i32],
    sides: &[i8],
) -> (Vec<bool>, bool) {
    let n = barrier.len();
    let mut pieces = Pieces((0..n).collect());
    for &[a, b] in beside {
        if !(barrier[a as usize] || barrier[b as usize]) {
            pieces.join(a, b);
        }
    }
    let mut votes = vec![0_i64; n];
    let mut count = vec![0_i64; n];
    for (&voter, &side) in voters.iter().zip(sides) {
        let piece = pieces.root(voter);
        votes[piece] += i64::from(side);
        count[piece] += 1;
    }
    let agree = |(&votes, &count): (&i64, &i64)| 2 * votes.abs() >= count;
    let separates = votes.iter().zip(&count).all(agree);
    let inside = (0..).zip(barrier);
    let inside = inside.map(|(f, &crossed)| crossed || votes[pieces.root(f)] > 0);
    (inside.collect(), separates)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five triangles in a row, the middle one crossed.
    const ROW: [[i32; 2]; 4] = [[0, 1], [1, 2], [2, 3], [3, 4]];
    const CROSSED: [bool; 5] = [false, false, true, false, false];

    #[test]
    fn the_left_part_is_inside() {
        let (inside, separates) = flood_left(&ROW, &CROSSED, &[1, 3], &[-1, 1]);
        assert_eq!(inside, [false, false, true, true, true]);
        assert!(separates);
    }

    #[test]
    fn a_part_with_opposite_votes_is_not_separated() {
        let beside = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 0]];
        let (_, separates) = flood_left(&beside, &CROSSED, &[1, 3], &[-1, 1]);
        assert!(!separates);
    }
}
