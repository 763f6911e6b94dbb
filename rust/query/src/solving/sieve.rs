//! A sieve for systems: orientations that two conditions refuse, eight at a time and unsolved.
//!
//! A side of a pattern can be no shorter than its base length, and what it is wider than that its
//! neighbours must be together, since a polychord takes as much from one end as from the other:
//!
//! ```text
//! lengths_i >= base_i
//! sum of lengths_j - lengths_i >= sum of base_j - base_i, over the sides j that i is joined to
//! ```
//!
//! The right-hand sides are the pattern's, the left-hand ones the boundary's: the first depends on
//! the side alone, the second on the side and its neighbours, a *claim* ([`crate::solving::systems`]). A class
//! of 20,000 patterns of 12 sides has some 3,000 of these, so that a query works all left-hand sides
//! out once, and compares.
//!
//! It compares *words*: 64-bit integers of eight bytes, a byte for each *lane*, which is a way in
//! which a pattern can see the boundary. The bytes hold v + 128 for a left-hand side v, cut off to
//! 0..127. Less a number of 0..127 in every byte, the highest bit of each is set where v is at least
//! that number, and nothing is borrowed from the byte above. Since claims may be below 0, both sides
//! of the second are one more. What the first condition yields for two sides is looked up by both
//! base lengths, cut off at [`LONGEST_BASE`]. Cut off, more may pass, never less: what passes is not
//! known to fit.

/// Lanes in a word.
pub const LANES: usize = 8;

/// Bits of each lane.
const BITS: usize = 8;

/// Words that are compared at once: 32 lanes, as many as 16 sides have.
pub const GROUP: usize = 4;

/// The words of some lanes, the first lane in the lowest byte.
pub type Words = [i64; GROUP];

/// 1 in every lane.
const ONES: i64 = 0x0101_0101_0101_0101;

/// The highest bit of a lane.
const HIGHEST: i32 = 128;

/// The longest base length that the sieve keeps apart from longer ones, so that two are one byte.
const LONGEST_BASE: i64 = 15;

/// The most that the sieve knows of a side's neighbours: a greater surplus is a weaker sieve, no
/// other answer.
pub const MOST_SURPLUS: i32 = 127;

/// Pairs of base lengths.
const PAIRS: usize = (LONGEST_BASE as usize + 1).pow(2);

/// The lengths that some lanes have, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedLengths {
    /// The words with the highest bit of each lane; their number is a multiple of GROUP.
    pub marks: Vec<i64>,
    /// For sides 2 p and 2 p + 1 and each number q of [`Sieve::pairs`], the words of the lanes in which
    /// the sides are as long as q asks.
    pub compared: Vec<i64>,
}

/// Compare the lengths of each two sides with all base lengths that they may have.
///
/// `lengths` has for each lane a row of `n_sides`. Lanes that fill up words have any length.
pub fn pack_lengths(lengths: &[i32], n_sides: usize) -> PackedLengths {
    let n_lanes = lengths.len() / n_sides;
    let n = n_lanes.div_ceil(LANES * GROUP) * GROUP;
    let word = |of_lane: &dyn Fn(usize) -> i32, first: usize| {
        let bytes = std::array::from_fn(|lane| of_lane(first + lane) as u8);
        i64::from_le_bytes(bytes)
    };
    let words = |of_lane: &dyn Fn(usize) -> i32| -> Vec<i64> {
        (0..n).map(|g| word(of_lane, g * LANES)).collect()
    };
    let sides: Vec<Vec<i64>> = (0..n_sides)
        .map(|side| {
            words(&|lane| {
                let length = lengths.get(lane * n_sides + side);
                HIGHEST + length.map_or(0, |&length| length.min(MOST_SURPLUS))
            })
        })
        .collect();
    let size = LONGEST_BASE + 1;
    let mut compared = vec![0; sides.len().div_ceil(2) * PAIRS * n];
    let entries = compared.chunks_exact_mut(PAIRS * n);
    for (compared, pair) in entries.zip(sides.chunks(2)) {
        for (q, compared) in (0..).zip(compared.chunks_exact_mut(n)) {
            for (compared, word) in compared.iter_mut().zip(&pair[0]) {
                *compared = word.wrapping_sub(q / size * ONES);
            }
            // The last side may have none next to it.
            for second in &pair[1..] {
                for (compared, word) in compared.iter_mut().zip(second) {
                    *compared &= word.wrapping_sub(q % size * ONES);
                }
            }
        }
    }
    PackedLengths {
        marks: words(&|lane| if lane < n_lanes { HIGHEST } else { 0 }),
        compared,
    }
}

/// Return the base lengths of each two sides of systems of `n_sides` sides, as [`Sieve::pairs`].
pub fn pair_sides(base: &[i16], n_sides: usize) -> Vec<u8> {
    let short = |length: i16| i64::from(length).min(LONGEST_BASE);
    let pair = |pair: &[i16]| {
        ((LONGEST_BASE + 1) * short(pair[0]) + pair.get(1).map_or(0, |&second| short(second))) as u8
    };
    let rows = base.chunks_exact(n_sides);
    rows.flat_map(|row| row.chunks(2).map(pair)).collect()
}

/// The claims of a class, and the lengths that lanes have.
#[derive(Clone, Copy, Debug)]
pub struct Claims<'a> {
    /// For each side a row of the lengths in all lanes.
    pub lengths: &'a [i32],
    /// Number of lanes.
    pub n_lanes: usize,
    /// The side that makes each claim.
    pub claimant: &'a [i16],
    /// Where the sides of each claim begin in `near`, and where those of the last end.
    pub near_first: &'a [i32],
    /// The sides of the claims.
    pub near: &'a [i16],
}

impl Claims<'_> {
    fn lengths(&self, side: i16) -> &[i32] {
        &self.lengths[side as usize * self.n_lanes..][..self.n_lanes]
    }

    /// Write the lanes of a claim: what the neighbours have beyond the side's own length.
    fn state(&self, claim: usize, spare: &mut [i32], stated: &mut [u8]) {
        for (spare, length) in spare.iter_mut().zip(self.lengths(self.claimant[claim])) {
            *spare = -length;
        }
        let near = self.near_first[claim] as usize..self.near_first[claim + 1] as usize;
        for &side in &self.near[near] {
            for (spare, length) in spare.iter_mut().zip(self.lengths(side)) {
                *spare += length;
            }
        }
        let (lanes, rest) = stated.split_at_mut(self.n_lanes);
        for (lane, spare) in lanes.iter_mut().zip(spare) {
            *lane = (HIGHEST + (*spare + 1).clamp(0, MOST_SURPLUS)) as u8;
        }
        rest.fill(HIGHEST as u8);
    }
}

/// Write the lanes of those of some claims that have none yet, which are 0.
///
/// `stated` holds rows of `width` lanes, of the claims from `first` on. Claims may repeat.
pub fn state_claims(claims: &Claims, some: &[i32], first: usize, stated: &mut [u8], width: usize) {
    let mut spare = vec![0; claims.n_lanes];
    for &claim in some {
        let claim = claim as usize;
        let row = &mut stated[(claim - first) * width..][..width];
        if row[0] == 0 {
            claims.state(claim, &mut spare, row);
        }
    }
}

/// What the sieve knows of systems and of a boundary.
#[derive(Clone, Copy, Debug)]
pub struct Sieve<'a> {
    /// For each system a row, of each two sides (LONGEST_BASE + 1) a + b, where a and b are their base
    /// lengths, at most LONGEST_BASE; b is 0 where there is one side more.
    pub pairs: &'a [u8],
    /// For each system a row, one more than what the base lengths of a side's neighbours have beyond
    /// its own, at most MOST_SURPLUS; 0 where it is joined to itself: it asks no other.
    pub surplus: &'a [u8],
    /// For each system a row: the claim of each side.
    pub claim: &'a [i32],
    /// The words with the highest bit of each lane.
    pub marks: &'a [Words],
    /// What [`pack_lengths`] returns.
    pub compared: &'a [Words],
    /// What [`state_claims`] writes.
    pub stated: &'a [Words],
    /// Number of sides.
    pub n_sides: usize,
}

#[inline(always)]
fn keep(lanes: &mut Words, others: &Words, least: i64) {
    for (word, other) in lanes.iter_mut().zip(others) {
        *word &= other.wrapping_sub(least);
    }
}

#[inline(always)]
fn is_any(lanes: &Words) -> bool {
    lanes[0] | lanes[1] | lanes[2] | lanes[3] != 0
}

impl Sieve<'_> {
    /// Write the lanes in which the system of a row passes; return whether any does.
    #[inline(always)]
    pub fn sift(&self, row: usize, left: &mut [Words]) -> bool {
        let w = self.n_sides;
        let n_pairs = w.div_ceil(2);
        let pairs = &self.pairs[row * n_pairs..][..n_pairs];
        let claims = &self.claim[row * w..][..w];
        let surplus = &self.surplus[row * w..][..w];
        let n = self.marks.len();
        let mut passing = false;
        for (g, left) in left.iter_mut().enumerate() {
            let mut lanes = self.marks[g];
            for (p, &q) in pairs.iter().enumerate() {
                keep(
                    &mut lanes,
                    &self.compared[(p * PAIRS + q as usize) * n + g],
                    0,
                );
            }
            // Half of the claims refuse most of what all do.
            for sides in [0..n_pairs, n_pairs..w] {
                if !is_any(&lanes) {
                    break;
                }
                for (&claim, &surplus) in claims[sides.clone()].iter().zip(&surplus[sides]) {
                    let least = i64::from(surplus) * ONES;
                    keep(&mut lanes, &self.stated[claim as usize * n + g], least);
                }
            }
            *left = lanes;
            passing |= is_any(&lanes);
        }
        passing
    }
}

/// Return whether a lane is among those left.
#[inline(always)]
pub fn has_lane(left: &[Words], lane: usize) -> bool {
    let word = left.as_flattened()[lane / LANES];
    (word >> (BITS * (lane % LANES) + BITS - 1)) & 1 != 0
}

/// Take a lane that is left from those left.
#[inline(always)]
pub fn drop_lane(left: &mut [Words], lane: usize) {
    left.as_flattened_mut()[lane / LANES] ^= 1 << (BITS * (lane % LANES) + BITS - 1);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solving::systems::{list_classes, number_claims};

    /// Pseudo-random numbers: splitmix64.
    struct Chance(u64);

    impl Chance {
        fn below(&mut self, n: i64) -> i64 {
            self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((x ^ (x >> 31)) % n as u64) as i64
        }
    }

    /// Whether the two conditions hold, side by side.
    fn meets_conditions(joined: &[bool], base: &[i16], lengths: &[i32]) -> bool {
        let w = base.len();
        let slack: Vec<i32> = (0..w).map(|i| lengths[i] - i32::from(base[i])).collect();
        (0..w).all(|i| {
            let near = (0..w).filter(|&j| joined[i * w + j]);
            let reach: i32 = near.map(|j| slack[j]).sum();
            slack[i] >= 0 && (joined[i * w + i] || slack[i] <= reach)
        })
    }

    #[test]
    fn lanes_pass_where_the_conditions_hold() {
        let mut chance = Chance(1);
        for _ in 0..300 {
            let w = 1 + chance.below(12) as usize;
            let longest = [6, 60, 2000][chance.below(3) as usize];
            // How many polychords join two sides; they make base lengths.
            let mut joins = vec![0; w * w];
            let mut join = |i: usize, j: usize, number: i64| {
                joins[i * w + j] = number;
                joins[j * w + i] = number;
            };
            for i in 0..w {
                join(i, chance.below(w as i64) as usize, 1);
            }
            for (i, j) in (0..w).flat_map(|i| (i..w).map(move |j| (i, j))) {
                if chance.below(10) < if i == j { 1 } else { 3 } {
                    join(i, j, 1 + chance.below(2));
                }
            }
            let joined: Vec<bool> = joins.iter().map(|&number| number > 0).collect();
            let times = 1 + chance.below(longest / 6);
            let length = |i: usize| joins[i * w..][..w].iter().sum::<i64>() + joins[i * w + i];
            let base: Vec<i16> = (0..w).map(|i| (times * length(i)) as i16).collect();
            let n_lanes = 1 + chance.below(70) as usize;
            let mut lengths = Vec::with_capacity(n_lanes * w);
            for _ in 0..n_lanes {
                let wide = 1 + chance.below(longest);
                lengths.extend(base.iter().map(|&base| {
                    (i64::from(base) + chance.below(wide) - chance.below(2)).max(1) as i32
                }));
            }
            let packed = pack_lengths(&lengths, w);
            let turned: Vec<i32> = (0..w * n_lanes)
                .map(|k| lengths[k % n_lanes * w + k / n_lanes])
                .collect();
            let claims = number_claims(&joined, w);
            let of_class = Claims {
                lengths: &turned,
                n_lanes,
                claimant: &claims.claimant,
                near_first: &claims.near_first,
                near: &claims.near,
            };
            let every: Vec<i32> = (0..claims.claimant.len() as i32).collect();
            let width = packed.marks.len() * LANES;
            let mut stated = vec![0; every.len() * width];
            state_claims(&of_class, &every, 0, &mut stated, width);
            let words = stated.chunks_exact(LANES);
            let stated: Vec<i64> = words
                .map(|word| i64::from_le_bytes(word.try_into().unwrap()))
                .collect();
            let sieve = Sieve {
                pairs: &pair_sides(&base, w),
                surplus: &list_classes(&base, &joined, w).surplus,
                claim: &claims.claim,
                marks: packed.marks.as_chunks().0,
                compared: packed.compared.as_chunks().0,
                stated: stated.as_chunks().0,
                n_sides: w,
            };
            let mut left = vec![[0; GROUP]; sieve.marks.len()];
            sieve.sift(0, &mut left);
            let total: i32 = base.iter().map(|&base| i32::from(base)).sum();
            for (lane, lengths) in lengths.chunks_exact(w).enumerate() {
                let (passes, holds) = (
                    has_lane(&left, lane),
                    meets_conditions(&joined, &base, lengths),
                );
                // Cut off, more may pass, never less.
                assert!(passes || !holds);
                let is_short = total.max(lengths.iter().sum()) < MOST_SURPLUS;
                if is_short && base.iter().all(|&base| i64::from(base) <= LONGEST_BASE) {
                    assert_eq!(passes, holds);
                }
            }
        }
    }

    #[test]
    fn lanes_pass_whose_sides_and_neighbours_are_long_enough() {
        // Two sides joined to each other, seen in two lanes with the lengths (3, 3) and (2, 3).
        let marks = [[0x8080, 0, 0, 0]];
        let packed = pack_lengths(&[3, 3, 2, 3], 2);
        assert_eq!(packed.marks, marks.as_flattened());
        assert_eq!(pair_sides(&[2, 2, 1, 20], 2), [2 * 16 + 2, 16 + 15]);
        assert_eq!(pair_sides(&[1, 2, 3], 3), [16 + 2, 3 * 16]);
        let claims = Claims {
            lengths: &[3, 2, 3, 3],
            n_lanes: 2,
            claimant: &[0, 1],
            near_first: &[0, 1, 2],
            near: &[1, 0],
        };
        let mut stated = vec![0; 2 * GROUP * LANES];
        state_claims(&claims, &[0, 1, 0], 0, &mut stated, GROUP * LANES);
        assert_eq!(stated[..3], [129, 130, 128]);
        let lanes = |bytes: &[u8]| i64::from_le_bytes(bytes.try_into().unwrap());
        let stated: Vec<i64> = stated.chunks_exact(LANES).map(lanes).collect();
        let mut sieve = Sieve {
            pairs: &[2 * 16 + 2],
            surplus: &[1, 1],
            claim: &[0, 1],
            marks: &marks,
            compared: packed.compared.as_chunks().0,
            stated: stated.as_chunks().0,
            n_sides: 2,
        };
        let mut left = [[0; GROUP]];
        assert!(sieve.sift(0, &mut left));
        // In the second lane side 1 asks for one edge more than side 0 has.
        assert!(has_lane(&left, 0) && !has_lane(&left, 1));
        drop_lane(&mut left, 0);
        assert_eq!(left, [[0; GROUP]]);
        sieve.pairs = &[2 * 16 + 4];
        assert!(!sieve.sift(0, &mut left));
    }
}
