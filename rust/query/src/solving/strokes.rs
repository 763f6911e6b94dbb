//! Strokes on a pattern: which strands carry them, and the best widths under which they do.
//!
//! A stroke asks for a strand of quads that leaves side a at edge i and side b at edge j, give or take
//! the tolerance K. If polychord q carries it, q is a strand 1 wide between two parts of any widths
//! u, w >= 0: x_q = u + 1 + w. The strand cuts side a in two *pieces*, of i + d and L_a - i - 1 - d edges with
//! |d| <= K, and side b likewise. So strokes only cut sides: the rest is the same matching as without
//! them, with pieces in the place of sides, and classes of polychords that join pieces. A tolerance is
//! one more node, of slack 2 K, joined to the two pieces of its cut: what it gives to one it does not
//! give to the other.
//!
//! Several strokes may lie on one polychord, in any order; its two ends see that order reversed.
//! [`add_best_widths`] tries every assignment of strokes to strands.
//!
//! Source: Marcias et al. 2015, section 4, "Edge-flow constraints". Differs from the paper: one system
//! of the matching instead of an integer program for each polychord, every assignment of strokes to
//! polychords is tried, and each of several strokes has a strand of its own.

use crate::solving::balance::{Best, Chord, Class, Part, System};
use crate::solving::branch_and_bound::add_best_solutions;
use crate::solving::matching::is_soluble;

/// Side and edge of one end of a stroke, and of the other, as a pattern sees them.
pub type Stroke = [i32; 4];

/// The boundary of a pattern, and the strands that meet it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Label {
    /// The strand that crosses each edge.
    edges: Vec<usize>,
    /// Where each side begins, and where the last ends.
    side_start: Vec<usize>,
    /// The two edges, ascending, that each strand crosses.
    ends: Vec<[usize; 2]>,
}

impl Label {
    /// Read a label from a word: for every side its length, then the strand that crosses each edge.
    pub fn new(word: &[i16], n_sides: usize) -> Label {
        let mut edges = Vec::with_capacity(word.len() - n_sides);
        let mut side_start = vec![0];
        let mut rest = word;
        while let [length, others @ ..] = rest {
            let (side, others) = others.split_at(*length as usize);
            edges.extend(side.iter().map(|&strand| strand as usize));
            side_start.push(edges.len());
            rest = others;
        }
        Label::of_edges(edges, side_start)
    }

    /// Make a label of the strand that crosses each edge, and of where each side begins and the last
    /// one ends.
    pub fn of_edges(edges: Vec<usize>, side_start: Vec<usize>) -> Label {
        let mut ends = vec![[usize::MAX; 2]; edges.len() / 2];
        for (at, &strand) in edges.iter().enumerate() {
            let ends = &mut ends[strand];
            ends[usize::from(ends[0] != usize::MAX)] = at;
        }
        Label {
            edges,
            side_start,
            ends,
        }
    }

    /// Return the number of strands.
    pub fn n_strands(&self) -> usize {
        self.ends.len()
    }

    fn edges_of(&self, side: usize) -> std::ops::Range<usize> {
        self.side_start[side]..self.side_start[side + 1]
    }

    fn side_of(&self, edge: usize) -> usize {
        self.side_start.partition_point(|&start| start <= edge) - 1
    }
}

/// What is asked of a pattern in one orientation.
#[derive(Clone, Copy, Debug)]
pub struct OrientedProblem<'a> {
    /// Edges of every side.
    pub lengths: &'a [i32],
    /// For each side a row, what the square of a width counts for strands to every side.
    pub weights: &'a [i32],
    /// The strokes.
    pub strokes: &'a [Stroke],
    /// Edges that a strand's end may be off.
    pub tolerance: i32,
}

/// A strand that carries a stroke; flipped, the stroke's first end is the strand's second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Carrier {
    strand: usize,
    flipped: bool,
}

/// Return the strands that may carry a stroke, as far as its own place decides.
fn find_carriers(label: &Label, problem: &OrientedProblem, stroke: &Stroke) -> Vec<Carrier> {
    let [a, i, b, j] = *stroke;
    let (first, second) = (label.edges_of(a as usize), label.edges_of(b as usize));
    // Edges before and after an end, as many as the boundary has at most.
    let has_room = |edge: usize, side: &std::ops::Range<usize>, length: i32, place: i32| {
        (edge - side.start) as i32 <= place + problem.tolerance
            && (side.end - edge) as i32 <= length - place + problem.tolerance
    };
    let carrier = |edge: usize| {
        let strand = label.edges[edge];
        let flipped = label.ends[strand][0] != edge;
        let other = label.ends[strand][usize::from(!flipped)];
        let fits = second.contains(&other)
            && has_room(edge, &first, problem.lengths[a as usize], i)
            && has_room(other, &second, problem.lengths[b as usize], j);
        fits.then_some(Carrier { strand, flipped })
    };
    first.clone().filter_map(carrier).collect()
}

/// Strokes on their strands.
struct Assignment<'a> {
    label: &'a Label,
    problem: &'a OrientedProblem<'a>,
    /// Whether each stroke lies flipped on its strand.
    flipped: Vec<bool>,
    /// The strokes on each strand, in the order that its first end sees.
    on: Vec<Vec<usize>>,
}

impl Assignment<'_> {
    /// Return the system of the pieces; None where a piece is too short for its strands.
    fn cut_system(&self) -> Option<System> {
        let OrientedProblem {
            lengths,
            strokes,
            tolerance,
            ..
        } = *self.problem;
        let mut system = System::default();
        // Parts are numbered strand by strand, in the order their first ends see.
        let mut part_first = vec![0];
        for on in &self.on {
            part_first.push(part_first[part_first.len() - 1] + 1 + on.len());
        }
        let mut pieces = vec![[0; 2]; part_first[self.on.len()]];
        let mut side_of = Vec::new();
        // The piece before each cut.
        let mut cuts = Vec::new();
        for (side, &length) in lengths.iter().enumerate() {
            // Edges before the piece, by how many they may be fewer, and edges that the piece needs.
            let (mut left, mut freedom, mut base) = (0, 0, 0);
            for edge in self.label.edges_of(side) {
                let strand = self.label.edges[edge];
                let (first, on) = (part_first[strand], &self.on[strand]);
                let second = self.label.ends[strand][1] == edge;
                let m = on.len();
                for t in 0..m {
                    let part = if second { m - t } else { t };
                    pieces[first + part][usize::from(second)] = system.slack.len();
                    let stroke = on[if second { m - 1 - t } else { t }];
                    let begins = self.flipped[stroke] == second;
                    let place = strokes[stroke][if begins { 1 } else { 3 }];
                    let slack = place - left + freedom + tolerance - base;
                    if slack < 0 {
                        return None;
                    }
                    cuts.push(system.slack.len());
                    system.slack.push(slack);
                    side_of.push(side);
                    (left, freedom, base) = (place + 1, tolerance, 0);
                }
                let last = if second { 0 } else { m };
                pieces[first + last][usize::from(second)] = system.slack.len();
                base += i32::from(m == 0);
            }
            let slack = length - left + freedom - base;
            if slack < 0 {
                return None;
            }
            system.slack.push(slack);
            side_of.push(side);
        }
        self.add_classes(&part_first, &pieces, &side_of, &mut system);
        if tolerance > 0 {
            for before in cuts {
                let node = system.slack.len();
                system.slack.push(2 * tolerance);
                for (piece, weight) in [(before, 1), (before + 1, 0)] {
                    system.classes.push(Class {
                        i: piece,
                        j: node,
                        n: 0,
                        weight,
                    });
                }
            }
        }
        Some(system)
    }

    /// Add the parts and their classes, by the pieces that each part joins.
    fn add_classes(
        &self,
        part_first: &[usize],
        pieces: &[[usize; 2]],
        side_of: &[usize],
        system: &mut System,
    ) {
        let n = side_of.len();
        let mut class_at = vec![None; n * n];
        for (strand, range) in part_first.windows(2).enumerate() {
            for &[one, other] in &pieces[range[0]..range[1]] {
                let (i, j) = (one.min(other), one.max(other));
                let class = *class_at[i * n + j].get_or_insert_with(|| {
                    system.classes.push(Class {
                        i,
                        j,
                        n: 0,
                        weight: self.weight(side_of[i], side_of[j]),
                    });
                    system.classes.len() - 1
                });
                system.classes[class].n += 1;
                system.parts.push(Part {
                    class,
                    chord: strand,
                });
            }
        }
    }

    fn weight(&self, one: usize, other: usize) -> i32 {
        self.problem.weights[one * self.problem.lengths.len() + other]
    }

    /// Return the strands as polychords of a system: the widths that their strokes need.
    fn chords(&self) -> Vec<Chord> {
        let ends = self.label.ends.iter().zip(&self.on);
        ends.map(|(ends, on)| {
            let [one, other] = ends.map(|edge| self.label.side_of(edge));
            Chord {
                own: on.len().max(1) as i32,
                weight: self.weight(one, other),
            }
        })
        .collect()
    }

    /// Put strokes on strands from one on, in all ways; `visit` each system of all strokes until it
    /// returns true, or until `is_cancelled`. Return whether either did.
    fn visit_all(
        &mut self,
        stroke: usize,
        carriers: &[Vec<Carrier>],
        is_cancelled: &impl Fn() -> bool,
        visit: &mut impl FnMut(&Assignment, System) -> bool,
    ) -> bool {
        let Some(own) = carriers.get(stroke) else {
            return false;
        };
        for &Carrier { strand, flipped } in own {
            self.flipped[stroke] = flipped;
            for rank in 0..=self.on[strand].len() {
                if is_cancelled() {
                    return true;
                }
                self.on[strand].insert(rank, stroke);
                if let Some(system) = self.cut_system() {
                    let done = if stroke + 1 < carriers.len() {
                        self.visit_all(stroke + 1, carriers, is_cancelled, visit)
                    } else {
                        visit(self, system)
                    };
                    if done {
                        return true;
                    }
                }
                self.on[strand].remove(rank);
            }
        }
        false
    }
}

/// Visit the systems of all ways in which strands lie on all strokes, until `visit` returns true or
/// `is_cancelled` does.
fn visit_systems(
    label: &Label,
    problem: &OrientedProblem,
    is_cancelled: &impl Fn() -> bool,
    mut visit: impl FnMut(&Assignment, System) -> bool,
) {
    let strokes = problem.strokes.iter();
    let carriers: Vec<_> = strokes
        .map(|stroke| find_carriers(label, problem, stroke))
        .collect();
    if carriers.iter().any(Vec::is_empty) {
        return;
    }
    let mut assignment = Assignment {
        label,
        problem,
        flipped: vec![false; carriers.len()],
        on: vec![Vec::new(); label.n_strands()],
    };
    if !carriers.is_empty() {
        assignment.visit_all(0, &carriers, is_cancelled, &mut visit);
    } else if let Some(system) = assignment.cut_system() {
        visit(&assignment, system);
    }
}

/// Return whether strands can lie on all the strokes. Once `is_cancelled`, the answer is of no use.
pub fn can_carry(
    label: &Label,
    problem: &OrientedProblem,
    is_cancelled: &impl Fn() -> bool,
) -> bool {
    let mut found = false;
    visit_systems(label, problem, is_cancelled, |_, system| {
        found = is_soluble(
            &system.slack,
            system.classes.iter().map(|class| (class.i, class.j)),
        );
        found
    });
    found
}

/// Add the best widths under which strands lie on all the strokes, with a tag.
///
/// Once `is_cancelled`, the answer is of no use.
pub fn add_best_widths(
    label: &Label,
    problem: &OrientedProblem,
    tag: i32,
    best: &mut Best,
    is_cancelled: &impl Fn() -> bool,
) {
    visit_systems(label, problem, is_cancelled, |assignment, system| {
        let chords = assignment.chords();
        add_best_solutions(&system, &chords, problem.tolerance, tag, best, is_cancelled);
        false
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of one quad: strand 0 from side 0 to side 2, strand 1 from side 1 to side 3.
    const SQUARE: [i16; 8] = [1, 0, 1, 1, 1, 0, 1, 1];

    fn solve(lengths: [i32; 4], strokes: &[Stroke], tolerance: i32) -> Vec<(i64, Vec<i32>)> {
        let problem = OrientedProblem {
            lengths: &lengths,
            weights: &[1; 16],
            strokes,
            tolerance,
        };
        let label = Label::new(&SQUARE, 4);
        let mut best = Best {
            keep: 5,
            ..Best::default()
        };
        add_best_widths(&label, &problem, 0, &mut best, &|| false);
        assert_eq!(
            can_carry(&label, &problem, &|| false),
            !best.solutions.is_empty()
        );
        let found = best.solutions.into_iter();
        found
            .map(|solution| (solution.key, solution.widths))
            .collect()
    }

    #[test]
    fn a_rectangle_has_its_widths() {
        assert_eq!(solve([3, 2, 3, 2], &[], 0), [(13, vec![3, 2])]);
        assert!(solve([3, 2, 4, 2], &[], 0).is_empty());
    }

    #[test]
    fn a_stroke_ends_at_its_edges_give_or_take_the_tolerance() {
        assert_eq!(solve([3, 2, 3, 2], &[[0, 0, 2, 2]], 0), [(13, vec![3, 2])]);
        assert!(solve([3, 2, 3, 2], &[[0, 0, 2, 1]], 0).is_empty());
        let found = solve([3, 2, 3, 2], &[[0, 0, 2, 1]], 1);
        assert_eq!(found, [(13 + (1 << 28), vec![3, 2])]);
    }
}
