//! Which side lengths have a regular fill.
//!
//! By Gauss and Bonnet no strip of quads leads from a side back to itself, nor to a neighbour of it,
//! if no vertex has fewer than four quads: what lies across must be long enough, for each side and
//! for each two neighbours. For 2 to 6 sides this is the answer of the complete family; for more it
//! is sufficient.

/// Return for each patch whether it has no regular fill.
///
/// `lengths`: of all sides; those of patch f are `first_side[f]` to `first_side[f + 1]`.
pub fn find_irregular(first_side: &[i32], lengths: &[i32]) -> Vec<bool> {
    first_side
        .windows(2)
        .map(|ends| !is_cheap(&lengths[ends[0] as usize..ends[1] as usize]))
        .collect()
}

/// Return whether a patch of N sides has a fill of |N - 4| irregular vertices.
///
/// All need an even perimeter. N = 4: opposite sides are equal. N = 3: no side is longer than the
/// others together. N >= 5: no side is longer than those that do not touch it, and no two neighbours
/// are longer than all others. N < 3: all.
pub fn is_cheap(lengths: &[i32]) -> bool {
    let n = lengths.len();
    let length = |i: usize| i64::from(lengths[i]);
    let perimeter: i64 = (0..n).map(length).sum();
    if perimeter % 2 != 0 {
        return false;
    }
    match n {
        0..3 => true,
        3 => (0..n).all(|i| 2 * length(i) <= perimeter),
        4 => lengths[0] == lengths[2] && lengths[1] == lengths[3],
        _ => {
            let (mut before, mut here) = (length(n - 1), length(0));
            (1..=n).all(|i| {
                let after = if i < n { length(i) } else { length(0) };
                let fits =
                    2 * (here + after) <= perimeter && before + 2 * here + after <= perimeter;
                (before, here) = (here, after);
                fits
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_has_equal_opposite_sides() {
        assert!(is_cheap(&[3, 2, 3, 2]));
        assert!(!is_cheap(&[3, 2, 3, 4]));
    }

    #[test]
    fn a_side_is_no_longer_than_those_across() {
        assert!(is_cheap(&[4, 2, 2]));
        assert!(!is_cheap(&[5, 2, 1]));
        assert!(is_cheap(&[2, 2, 2, 2, 2]));
        assert!(!is_cheap(&[5, 1, 1, 2, 1]));
        assert!(!is_cheap(&[2, 2, 2, 2, 1]));
    }

    #[test]
    fn each_patch_is_judged_by_its_own_sides() {
        let lengths = [1, 1, 1, 1, 1, 2, 1, 1];
        assert_eq!(find_irregular(&[0, 4, 8], &lengths), [false, true]);
    }
}
