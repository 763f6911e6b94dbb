//! Which patterns of a class fit a boundary, and in which orientations.
//!
//! Whether lengths can be met depends on a pattern's signature and on the orientation alone. Each is
//! one system. A sieve rejects most of them, all orientations of a signature together
//! ([`crate::solving::sieve`]); parity may reject others ([`is_balanced`]), and so may Hall conditions
//! ([`crate::solving::hall_conditions`]); a flow decides the rest ([`crate::solving::matching`]), and
//! the cut that one orientation fails by, others of the same system often fail by as well. Marcias et
//! al. 2015, section 4, solve one integer program a pattern.

use crate::solving::fractional_matching::{Scratch, Square};
use crate::solving::hall_conditions::{MOST_SIDES, Sums};
use crate::solving::matching::{Verdict, decide};
use crate::solving::sieve::{Sieve, Words, drop_lane, has_lane};
use crate::solving::systems::{Systems, is_balanced};

/// Patterns between two looks at the cancel flag: some ten microseconds.
const ROWS_PER_LOOK: usize = 64;

/// The lengths of a boundary, as the systems of a class see them.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<'a> {
    /// The sieve of the class and the boundary.
    pub sieve: Sieve<'a>,
    /// For each lane, a different way in which a signature sees the boundary, a row of lengths.
    pub lengths: &'a [i32],
    /// The lane of each orientation.
    pub lane_of: &'a [i32],
}

/// Some patterns of a class, and the orientations that are asked about.
#[derive(Clone, Copy, Debug)]
pub struct Patterns<'a> {
    /// Their numbers in the class.
    pub rows: &'a [i64],
    /// The system of each pattern of the class.
    pub signature: &'a [i32],
    /// The pattern's side that is the first of its signature, for each pattern of the class.
    pub rotation: &'a [i32],
    /// Whether its sides are those of the signature in reverse.
    pub reflected: &'a [bool],
    /// For each of these patterns a row of bits, the highest first: its allowed orientations.
    pub allowed: &'a [u8],
}

/// How a pattern lies to its signature: side i of the signature is its side `turn` + i, or `turn` - i
/// where reflected.
#[derive(Clone, Copy)]
struct Pose {
    turn: usize,
    reflected: bool,
}

impl Pose {
    /// Return the orientation of the signature, of `2 n`, that is the pattern's orientation `o`.
    ///
    /// What the orientation (mirrored, r) of the pattern is to its sides, (mirrored, r - turn) is to
    /// the signature's, or, where reflected, (not mirrored, turn - r).
    #[inline(always)]
    fn of_signature(self, o: usize, n: usize) -> usize {
        let (is_mirrored, r) = if o < n { (false, o) } else { (true, o - n) };
        let difference = match self.reflected {
            true => self.turn + n - r,
            false => r + n - self.turn,
        };
        let at = if difference >= n {
            difference - n
        } else {
            difference
        };
        if is_mirrored != self.reflected {
            n + at
        } else {
            at
        }
    }
}

/// Return the orientations whose bits are set, of the first `n`.
#[inline(always)]
fn list_allowed(bits: &[u8], n: usize) -> impl Iterator<Item = usize> {
    (0..n).filter(|o| bits[o / 8] & (0x80 >> (o % 8)) != 0)
}

/// Mark the allowed orientations in which lengths can be met.
///
/// `fits` has for each pattern a row, false at first: a place for each orientation, or with `once` one
/// place, whether any fits. Once `is_cancelled`, the rest stays false.
pub fn mark(
    systems: &Systems,
    lanes: &Lanes,
    patterns: &Patterns,
    once: bool,
    is_cancelled: impl Fn() -> bool,
    fits: &mut [bool],
) {
    let mut solver = Solver::new(systems, lanes);
    let n_orientations = lanes.lane_of.len();
    let n = systems.graphs.n_sides;
    let perimeter: i32 = lanes.lengths[..n].iter().sum();
    let rows = patterns.rows.iter();
    let allowed = patterns.allowed.chunks_exact(n_orientations.div_ceil(8));
    let fits = fits.chunks_exact_mut(if once { 1 } else { n_orientations });
    for (u, ((&at, allowed), fits)) in rows.zip(allowed).zip(fits).enumerate() {
        if u % ROWS_PER_LOOK == 0 && is_cancelled() {
            return;
        }
        let at = at as usize;
        let row = patterns.signature[at] as usize;
        if systems.perimeter[row] > perimeter || !lanes.sieve.sift(row, &mut solver.left) {
            continue;
        }
        let pose = Pose {
            turn: patterns.rotation[at] as usize % n,
            reflected: patterns.reflected[at],
        };
        let lane = |o| lanes.lane_of[pose.of_signature(o, n)] as usize;
        solver.keep_lanes(list_allowed(allowed, n_orientations).map(lane));
        let is_found = solver.solve(row, once);
        if once {
            fits[0] = is_found;
        } else if is_found {
            for o in list_allowed(allowed, n_orientations) {
                fits[o] = solver.fit[lane(o)];
            }
        }
    }
}

/// Decides the lanes of one system after another.
struct Solver<'a> {
    systems: &'a Systems<'a>,
    lanes: &'a Lanes<'a>,
    /// The lanes that nothing has rejected.
    left: Vec<Words>,
    /// The lanes that are asked about, while they are collected; then those in which the system fits.
    fit: Vec<bool>,
    /// By how much lengths exceed base lengths, 0 for sides that Hall conditions count beyond the last.
    need: Vec<i32>,
    sums: Sums,
    flow: Square,
    scratch: Scratch,
}

impl<'a> Solver<'a> {
    fn new(systems: &'a Systems<'a>, lanes: &'a Lanes<'a>) -> Solver<'a> {
        let w = systems.graphs.n_sides;
        Solver {
            systems,
            lanes,
            left: vec![[0; 4]; lanes.sieve.marks.len()],
            fit: vec![false; lanes.lengths.len() / w],
            need: vec![0; w.max(MOST_SIDES)],
            sums: Sums::default(),
            flow: Square::new(w),
            scratch: Scratch::new(w),
        }
    }

    /// Drop the lanes left but some.
    #[inline(always)]
    fn keep_lanes(&mut self, some: impl Iterator<Item = usize>) {
        self.fit.fill(false);
        some.for_each(|lane| self.fit[lane] = true);
        for (lane, &is_asked) in self.fit.iter().enumerate() {
            if !is_asked && has_lane(&self.left, lane) {
                drop_lane(&mut self.left, lane);
            }
        }
    }

    /// Decide the lanes left of the system in a row, all or with `once` until one fits; return whether
    /// any does.
    #[inline(always)]
    fn solve(&mut self, row: usize, once: bool) -> bool {
        let w = self.systems.graphs.n_sides;
        let base = &self.systems.base[row * w..][..w];
        let mut found = false;
        for lane in 0..self.fit.len() {
            self.fit[lane] = false;
            if !has_lane(&self.left, lane) {
                continue;
            }
            let lengths = &self.lanes.lengths[lane * w..][..w];
            match self.decide(row, base, lengths) {
                Some(Verdict::Matchable) => {
                    self.fit[lane] = true;
                    found = true;
                    if once {
                        break;
                    }
                }
                Some(Verdict::Cut) => self.drop_by_cut(base, lane),
                Some(Verdict::Halves) | None => {}
            }
        }
        found
    }

    /// Decide a lane of a system; None where it is rejected without a flow.
    #[inline(always)]
    fn decide(&mut self, row: usize, base: &[i16], lengths: &[i32]) -> Option<Verdict> {
        let systems = self.systems;
        let w = base.len();
        let need = &mut self.need[..w];
        for ((need, length), base) in need.iter_mut().zip(lengths).zip(base) {
            *need = length - i32::from(*base);
        }
        if need.iter().any(|&need| need < 0) {
            return None;
        }
        if systems.parity[row] {
            let component = &systems.component[row * w..][..w];
            let colour = &systems.colour[row * w..][..w];
            if !is_balanced(need, component, colour, self.scratch.numbers()) {
                return None;
            }
        }
        let graph = systems.graph[row] as usize;
        let hall = systems.hall_first[graph] as usize..systems.hall_first[graph + 1] as usize;
        if !hall.is_empty()
            && let Some(needs) = self.need.first_chunk()
        {
            self.sums.fill(needs);
            if self.sums.break_any(&systems.hall[hall]) {
                return None;
            }
        }
        let graph = systems.graphs.graph(row);
        Some(decide(
            &self.need[..w],
            &graph,
            &mut self.flow,
            &mut self.scratch,
        ))
    }

    /// Drop the lanes after one in which the sides of the cut ask for more than their neighbours have.
    fn drop_by_cut(&mut self, base: &[i16], last: usize) {
        let w = base.len();
        for lane in last + 1..self.fit.len() {
            if !has_lane(&self.left, lane) {
                continue;
            }
            let lengths = &self.lanes.lengths[lane * w..][..w];
            let need = |side: usize| lengths[side] - i32::from(base[side]);
            let near = (0..w).filter(|&side| self.scratch.is_near_cut(side));
            let asked: i32 = self.scratch.cut().iter().map(|&side| need(side)).sum();
            if near.map(need).sum::<i32>() < asked {
                drop_lane(&mut self.left, lane);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientations_of_a_pattern_are_those_of_its_signature_turned() {
        let pose = |turn, reflected| Pose { turn, reflected };
        let list = |pose: Pose| (0..6).map(|o| pose.of_signature(o, 3)).collect::<Vec<_>>();
        assert_eq!(list(pose(0, false)), [0, 1, 2, 3, 4, 5]);
        assert_eq!(list(pose(1, false)), [2, 0, 1, 5, 3, 4]);
        assert_eq!(list(pose(1, true)), [4, 3, 5, 1, 0, 2]);
    }

    #[test]
    fn allowed_orientations_are_bits_highest_first() {
        assert!(list_allowed(&[0b0100_0001, 0b1000_0000], 10).eq([1, 7, 8]));
    }
}
