//! Pentagon cuts: where a pentagon can be cut off an outline.
//!
//! The pentagon has one interior vertex, of valence 5; straight lines from it meet every side. Side k
//! is x_k + x_(k+2) edges long, x_k of them before the line that meets it, so
//! x_k = S/2 - L_(k+1) - L_(k+2) with S the perimeter: the pentagon exists exactly if S is even and
//! any two sides next to each other are shorter than half of it.

/// Positions tried along a side; longer sides are tried in larger steps.
const MOST_STEPS: i64 = 24;

/// Is there a pentagon of one valence-5 vertex with these sides?
fn is_pentagon(sides: [i64; 5]) -> bool {
    let total: i64 = sides.iter().sum();
    let pairs = (0..5).map(|k| sides[k] + sides[(k + 1) % 5]);
    total % 2 == 0 && pairs.into_iter().all(|pair| 2 * pair < total)
}

/// A pentagon cut off an outline: `before` edges of side i, sides i + 1 and i + 2, `after` edges of
/// side i + 3 and a chord.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PentagonCut {
    /// Side i.
    pub side: usize,
    /// Edges taken of side i.
    pub before: i64,
    /// Edges taken of side i + 3.
    pub after: i64,
    /// Edges of the chord.
    pub chord: i64,
}

/// Return the best cut at every side, best first.
///
/// `lengths` and `counts` are the edges of the sides and the quads at the corners of an outline of at
/// least five. The three corners within a cut must be convex, and at least 2 edges be left of both
/// sides. The best cut leaves the longest shortest side, where sides of more than `ample` edges count
/// as that long, then has the shortest chord: long ones add up from cut to cut, until one side is more
/// than half of what is left. Then it leaves more of the sides it cuts, and takes alike of both.
pub fn find_pentagon_cuts(lengths: &[i64], counts: &[i64], ample: i64) -> Vec<PentagonCut> {
    let n = lengths.len();
    let mut found: Vec<(f64, PentagonCut)> = Vec::new();
    for side in 0..n {
        let after = |k: usize| (side + k) % n;
        if (1..n.min(4)).any(|k| counts[after(k)] != 1) {
            continue;
        }
        let others = (4..n).map(|k| lengths[after(k)]);
        let shortest = others.min().unwrap_or(1 << 30).min(1 << 30);
        let sides = [0, 1, 2, 3].map(|k| lengths[after(k)]);
        if let Some((score, cut)) = find_best_cut(side, sides, shortest, ample) {
            let at = found.partition_point(|&(other, _)| other >= score);
            found.insert(at, (score, cut));
        }
    }
    found.into_iter().map(|(_, cut)| cut).collect()
}

/// Return the best cut over the two sides in the middle of four, and its score.
///
/// `shortest` is the shortest of the sides that the cut does not touch.
fn find_best_cut(
    side: usize,
    [first, b, c, last]: [i64; 4],
    shortest: i64,
    ample: i64,
) -> Option<(f64, PentagonCut)> {
    let mut best: Option<(f64, PentagonCut)> = None;
    let step = (first / MOST_STEPS).max(1);
    for u in (2..first - 1).step_by(step as usize) {
        for w in (u - 2 * step).max(2)..=(last - 2).min(u + 2 * step) {
            // The shortest chord that the pentagon's conditions and parity allow.
            let least = (b + c - u - w + 2).max((u + b - c - w).abs() + 2).max(2);
            let e = least + (least + u + b + c + w) % 2;
            if !is_pentagon([u, b, c, w, e]) {
                continue;
            }
            let made = (first - u).min(last - w).min(e);
            let score = made.min(shortest).min(ample) as f64 * 1e6 - 1e2 * e as f64 + made as f64
                - 0.5 * (u - w).abs() as f64;
            if best.is_none_or(|(best, _)| score > best) {
                let cut = PentagonCut {
                    side,
                    before: u,
                    after: w,
                    chord: e,
                };
                best = Some((score, cut));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sides_of_a_pentagon_are_shorter_than_the_others() {
        assert!(is_pentagon([2; 5].map(|side| 2 * side)));
        assert!(!is_pentagon([1; 5]));
        assert!(!is_pentagon([1, 1, 1, 4, 3]));
    }

    #[test]
    fn cuts_leave_sides_of_two_edges_and_more() {
        let cuts = find_pentagon_cuts(&[6; 8], &[1; 8], 4);
        assert_eq!(cuts.len(), 8);
        for cut in cuts {
            assert!(cut.before >= 2 && 6 - cut.before >= 2 && 6 - cut.after >= 2);
            assert!(is_pentagon([cut.before, 6, 6, cut.after, cut.chord]));
        }
        // A reflex corner lies within three of the cuts.
        let cuts = find_pentagon_cuts(&[6; 8], &[1, 1, 1, 3, 1, 1, 1, 1], 4);
        assert_eq!(cuts.len(), 5);
    }
}
