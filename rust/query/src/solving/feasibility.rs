//! Which patterns of a class fit a boundary, and in which orientations.
//!
//! Whether lengths can be met depends on a pattern's signature and on the orientation alone. Each is
//! one system. A sieve refuses most of them, all orientations of a signature together
//! ([`crate::solving::sieve`]); parity may refuse others ([`is_balanced`]), and what several sides ask together
//! ([`crate::solving::jointclaims`]); a flow decides the rest ([`crate::solving::matching`]), and what one orientation
//! fails by, others of the same system often do. Marcias et al. 2015, section 4, solve one integer
//! program a pattern.

use crate::solving::graphs::{Graphs, Square};
use crate::solving::halves::Scratch;
use crate::solving::jointclaims::{MOST_SIDES, Sums};
use crate::solving::matching::{Verdict, decide};
use crate::solving::sieve::{Sieve, Words, drop_lane, has_lane};
use crate::solving::systems::is_balanced;

/// Patterns between two looks at the cancel flag: some ten microseconds.
const ROWS_PER_LOOK: usize = 64;

/// The systems of a class.
#[derive(Clone, Copy, Debug)]
pub struct Systems<'a> {
    /// Their graphs.
    pub graphs: Graphs<'a>,
    /// For each system a row of the base lengths of its sides.
    pub base: &'a [i16],
    /// The sum of each system's base lengths.
    pub perimeter: &'a [i32],
    /// For each system a row: the first side of each side's component.
    pub component: &'a [i16],
    /// For each system a row: each side's colour, see [`crate::solving::systems::two_colour`].
    pub colour: &'a [i16],
    /// Whether parity can refuse an even perimeter.
    pub parity: &'a [bool],
    /// The number of each system's graph, in `joint_first`.
    pub graph: &'a [i32],
    /// Where the joint claims of each graph begin, and where those of the last end.
    pub joint_first: &'a [i32],
    /// The joint claims.
    pub joint: &'a [i32],
}

/// What is asked of a class.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// What the sieve knows.
    pub sieve: Sieve<'a>,
    /// For each lane, a different way in which a signature sees the boundary, a row of lengths.
    pub lengths: &'a [i32],
    /// For each lane a row of the quads at the corners; corner s is where side s of the signature
    /// begins.
    pub kinds: &'a [i32],
    /// Number of corners.
    pub n_corners: usize,
    /// The lane of each orientation.
    pub lane_of: &'a [i32],
    /// Edges around the boundary.
    pub perimeter: i64,
}

/// Some patterns of a class.
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
    /// For each of these patterns a row of the quads at its corners; None where corners do not matter.
    pub corners: Option<&'a [u8]>,
}

/// How a pattern lies to its signature: side i of the signature is its side `turn` + i, or `turn` - i
/// where reflected.
#[derive(Clone, Copy)]
struct Pose {
    turn: usize,
    reflected: bool,
}

/// Mark the patterns that fit.
///
/// `fits` has for each pattern a row, false at first: one place, whether it fits at all, or with
/// `every` one for each orientation. Once `is_cancelled`, the rest stays false.
pub fn mark(
    systems: &Systems,
    question: &Question,
    patterns: &Patterns,
    every: bool,
    is_cancelled: impl Fn() -> bool,
    fits: &mut [bool],
) {
    let mut solver = Solver::new(systems, question);
    let width = if every { question.lane_of.len() } else { 1 };
    for (u, (&at, fits)) in patterns
        .rows
        .iter()
        .zip(fits.chunks_exact_mut(width))
        .enumerate()
    {
        if u % ROWS_PER_LOOK == 0 && is_cancelled() {
            return;
        }
        let at = at as usize;
        let row = patterns.signature[at] as usize;
        if i64::from(systems.perimeter[row]) > question.perimeter {
            continue;
        }
        if !question.sieve.sift(row, &mut solver.left) {
            continue;
        }
        let pose = Pose {
            turn: patterns.rotation[at] as usize,
            reflected: patterns.reflected[at],
        };
        if let Some(corners) = patterns.corners {
            let n = question.n_corners;
            solver.drop_by_corners(&corners[u * n..][..n], pose);
        }
        let found = solver.solve(row, every);
        if !every {
            fits[0] = found;
        } else if found {
            turn_back(question.lane_of, &solver.fit, pose, fits);
        }
    }
}

/// Decides the lanes of one system after another.
struct Solver<'a> {
    systems: &'a Systems<'a>,
    question: &'a Question<'a>,
    /// The lanes that nothing has refused.
    left: Vec<Words>,
    /// The lanes in which the system fits.
    fit: Vec<bool>,
    /// By how much lengths exceed base lengths, 0 for sides that joint claims count beyond the last.
    need: Vec<i32>,
    sums: Sums,
    flow: Square,
    scratch: Scratch,
}

impl<'a> Solver<'a> {
    fn new(systems: &'a Systems<'a>, question: &'a Question<'a>) -> Solver<'a> {
        let w = systems.graphs.n_sides;
        Solver {
            systems,
            question,
            left: vec![[0; 4]; question.sieve.marks.len()],
            fit: vec![false; question.lengths.len() / w],
            need: vec![0; w.max(MOST_SIDES)],
            sums: Sums::default(),
            flow: Square::new(w),
            scratch: Scratch::new(w),
        }
    }

    /// Decide the lanes left of the system in a row, all of `every` or until one fits; return whether
    /// any does.
    #[inline(always)]
    fn solve(&mut self, row: usize, every: bool) -> bool {
        let w = self.systems.graphs.n_sides;
        let base = &self.systems.base[row * w..][..w];
        let mut found = false;
        for lane in 0..self.fit.len() {
            self.fit[lane] = false;
            if !has_lane(&self.left, lane) {
                continue;
            }
            let lengths = &self.question.lengths[lane * w..][..w];
            match self.decide(row, base, lengths) {
                Some(Verdict::Matchable) => {
                    self.fit[lane] = true;
                    found = true;
                    if !every {
                        break;
                    }
                }
                Some(Verdict::Cut) => self.drop_by_cut(base, lane),
                Some(Verdict::Halves) | None => {}
            }
        }
        found
    }

    /// Decide a lane of a system; None where no flow was needed to refuse it.
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
        let claims = systems.joint_first[graph] as usize..systems.joint_first[graph + 1] as usize;
        if !claims.is_empty()
            && let Some(needs) = self.need.first_chunk()
        {
            self.sums.fill(needs);
            if self.sums.refuse(&systems.joint[claims]) {
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

    /// Drop the lanes in which a corner of the pattern falls on one of another kind.
    fn drop_by_corners(&mut self, corners: &[u8], pose: Pose) {
        let n = corners.len();
        let corner = |s: usize| match pose.reflected {
            true => corners[(pose.turn + n + 1 - s) % n],
            false => corners[(pose.turn + s) % n],
        };
        for lane in 0..self.fit.len() {
            let kinds = &self.question.kinds[lane * n..][..n];
            let mut pairs = kinds.iter().enumerate();
            if has_lane(&self.left, lane) && pairs.any(|(s, &kind)| kind != corner(s).into()) {
                drop_lane(&mut self.left, lane);
            }
        }
    }

    /// Drop the lanes after one in which the sides of the cut ask for more than their neighbours have.
    fn drop_by_cut(&mut self, base: &[i16], last: usize) {
        let w = base.len();
        for lane in last + 1..self.fit.len() {
            if !has_lane(&self.left, lane) {
                continue;
            }
            let lengths = &self.question.lengths[lane * w..][..w];
            let need = |side: usize| lengths[side] - i32::from(base[side]);
            let near = (0..w).filter(|&side| self.scratch.is_near_cut(side));
            let asked: i32 = self.scratch.cut().iter().map(|&side| need(side)).sum();
            if near.map(need).sum::<i32>() < asked {
                drop_lane(&mut self.left, lane);
            }
        }
    }
}

/// Set `fits`, by orientation of the pattern, from `fit`, by lane of its signature.
///
/// What the orientation (mirrored, r) of the pattern is to its sides, (mirrored, r - turn) is to the
/// signature's, or, where reflected, (not mirrored, turn - r).
fn turn_back(lane_of: &[i32], fit: &[bool], pose: Pose, fits: &mut [bool]) {
    let n = fits.len() / 2;
    let (plain, mirrored) = lane_of.split_at(n);
    let (plain, mirrored) = match pose.reflected {
        true => (mirrored, plain),
        false => (plain, mirrored),
    };
    let (first, second) = fits.split_at_mut(n);
    for r in 0..n {
        let at = match pose.reflected {
            true => (pose.turn + n - r) % n,
            false => (r + n - pose.turn % n) % n,
        };
        first[r] = fit[plain[at] as usize];
        second[r] = fit[mirrored[at] as usize];
    }
}
