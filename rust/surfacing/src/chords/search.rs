//! The exhaustive search for the chords that cut a cycle into the flattest pieces.
//!
//! Source: Abbasinejad et al. 2013, section 3.2, Equations 1 to 3 and Algorithm 1. Differs from the
//! paper: sub-problems are numbered and solved from the smallest up, see
//! [`subcycles`](crate::chords::subcycles), where the paper recurses with a hash table.

use std::collections::TryReserveError;

use patterndb_geometry::vector::{Point, length, min, subtract};

use crate::chords::flatness::{Moments, add_moments, find_determinant, sum_moments};
use crate::chords::subcycles::{Inside, MOST_COUNTED, Path, Span, Subcycles};

/// Costs that differ by no more than this share of S(whole cycle) + alpha are equal. They are sums of
/// some tens of terms, each with an error in the 16th digit.
const TIE: f64 = 1e-12;

/// A cycle and the chords that may cut it.
#[derive(Clone, Copy, Debug)]
pub struct CutProblem<'a> {
    /// The vertices of a closed loop.
    pub points: &'a [Point],
    /// The same in standardised axes ([`standardise`](crate::chords::flatness::standardise)).
    pub own: &'a [Point],
    /// Positions i < j, not neighbours, no two alike.
    pub chords: &'a [[i64; 2]],
    /// How much a cut weighs, relative to S(whole cycle).
    pub alpha: f64,
    /// Whether S is as printed in the paper, the determinant, or relative, its root.
    pub printed: bool,
}

/// The best cuts of a cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cuts {
    /// How many sub-problems there are.
    pub n_subproblems: i64,
    /// The cost relative to S(whole cycle).
    pub cost: f64,
    /// The chosen chords.
    pub chosen: Vec<usize>,
    /// Where all pieces except the last end in `positions`.
    pub bounds: Vec<usize>,
    /// The positions of the pieces, one after another.
    pub positions: Vec<usize>,
}

impl CutProblem<'_> {
    /// Choose chords so that the cost of the pieces and of the cuts is least; nothing is chosen
    /// where there are MOST_COUNTED sub-problems or more.
    ///
    /// Fails where the sub-problems exceed the memory.
    pub fn solve(&self) -> Result<Cuts, TryReserveError> {
        let numbering = Subcycles::new(self.points.len(), self.chords);
        let mut cuts = Cuts {
            n_subproblems: numbering.n_all,
            ..Cuts::default()
        };
        if numbering.n_all >= MOST_COUNTED {
            return Ok(cuts);
        }
        let measures = self.measure_ends(&numbering);
        let mut solutions = Solutions::new(numbering.n_numbers())?;
        let mut search = Search {
            problem: self,
            numbering: &numbering,
            measures: &measures,
            solutions: &mut solutions,
        };
        for wrap in numbering.wraps() {
            search.evaluate(Some(wrap.chord));
        }
        search.evaluate(None);
        cuts.cost = solutions.value.last().copied().unwrap_or_default();
        trace_pieces(self.points.len(), &numbering, &solutions, &mut cuts);
        Ok(cuts)
    }

    fn measure_ends(&self, numbering: &Subcycles) -> Measures {
        let (n, ends) = (self.points.len(), &numbering.ends);
        let distance = |a: usize, b: usize| length(&subtract(&self.points[a], &self.points[b]));
        let mut at = Sums::default();
        let mut up_to = vec![at];
        let following = ends.iter().skip(1).copied();
        let stops = following.chain(ends.first().map(|end| end + n));
        for (&end, stop) in ends.iter().zip(stops) {
            for v in end..stop {
                add_moments(&mut at.moments, &self.own[v % n]);
                at.arc += distance(v % n, (v + 1) % n);
            }
            up_to.push(at);
        }
        let chord = |ends: &[i64; 2]| distance(ends[0] as usize, ends[1] as usize);
        Measures {
            corner: ends.iter().map(|&v| sum_moments([&self.own[v]])).collect(),
            up_to,
            chord: self.chords.iter().map(chord).collect(),
            whole: find_determinant(&sum_moments(self.own)),
        }
    }
}

/// Sums over the cycle from end 0 to before another end.
#[derive(Clone, Copy, Default)]
struct Sums {
    moments: Moments,
    /// The length of the cycle up to that end.
    arc: f64,
}

/// What sub-cycles are summed up from.
struct Measures {
    /// The moments of every end.
    corner: Vec<Moments>,
    /// The sums up to every end, and around the cycle.
    up_to: Vec<Sums>,
    /// The length of every chord.
    chord: Vec<f64>,
    /// The whole cycle's determinant.
    whole: f64,
}

/// What is known of every sub-cycle, by its number.
struct Solutions {
    /// Its cost.
    value: Vec<f64>,
    /// How it is cut.
    choice: Vec<Choice>,
}

#[derive(Clone, Copy, Default)]
struct Choice {
    /// How many chords cut it.
    fewest: u32,
    /// One more than the chord that cuts it first, or 0.
    after_chord: u32,
}

impl Choice {
    fn chord(self) -> Option<usize> {
        self.after_chord.checked_sub(1).map(|chord| chord as usize)
    }
}

impl Solutions {
    fn new(n: i64) -> Result<Solutions, TryReserveError> {
        let n = usize::try_from(n).unwrap_or(usize::MAX);
        let (mut value, mut choice) = (Vec::new(), Vec::new());
        value.try_reserve_exact(n)?;
        choice.try_reserve_exact(n)?;
        value.resize(n, 0.0);
        choice.resize(n, Choice::default());
        Ok(Solutions { value, choice })
    }
}

/// A path up to the end of one of its jumps.
#[derive(Clone, Copy)]
struct Prefix {
    /// The jump, 0 for the begin of the path.
    jump: usize,
    /// From where to where it goes.
    enter: usize,
    leave: usize,
    /// The number, length and moments up to there.
    number: i64,
    length: f64,
    moments: Moments,
    /// How many chords could cut it.
    n_cuts: usize,
    /// Which jumps and chords to look at next.
    next_first: usize,
    next_last: usize,
}

/// A chord that could cut a path.
#[derive(Clone, Copy)]
struct Cut {
    chord: usize,
    /// The number of the part under it.
    under: usize,
    /// The cost of that part.
    value: f64,
    /// By what the path's number changes if that part is replaced by a jump.
    shift: i64,
    /// Its length times alpha.
    price: f64,
}

impl Cut {
    /// Return the number of the remainder of a sub-cycle that it cuts.
    #[inline(always)]
    fn rest(&self, own: i64) -> usize {
        (own + self.shift) as usize
    }
}

/// The solving of sub-cycles in the order of their numbers.
struct Search<'a> {
    problem: &'a CutProblem<'a>,
    numbering: &'a Subcycles,
    measures: &'a Measures,
    solutions: &'a mut Solutions,
}

impl Search<'_> {
    /// Solve all sub-cycles with one wrap, in the order of their numbers.
    ///
    /// A path is its jumps, with arcs between them and after the last. Each path's extensions by one
    /// more jump are walked before it is solved itself. Chords that could cut are found once the path
    /// is settled up to where they end, and are then known to all extensions.
    fn evaluate(&mut self, wrap: Option<usize>) {
        let (numbering, measures) = (self.numbering, self.measures);
        let (start, stop) = numbering.range(wrap);
        let base = numbering.base_of(wrap);
        let (to_stop, offsets) = (numbering.paths_to(stop), numbering.offsets_to(stop));
        let Inside { by_first, by_last } = numbering.inside(wrap);
        let n_inside = by_last.spans.len();
        let mut cuts: Vec<Cut> = Vec::with_capacity(n_inside);
        let mut totals: Vec<f64> = Vec::with_capacity(n_inside);
        let mut path = vec![Prefix {
            jump: 0,
            enter: start,
            leave: start,
            number: 0,
            length: wrap.map_or(0.0, |c| measures.chord[c]),
            moments: wrap.map_or(Moments::default(), |_| measures.corner[stop]),
            n_cuts: 0,
            next_first: 0,
            next_last: 0,
        }];
        while let Some(prefix) = path.last() {
            let next = by_first.spans.get(prefix.next_first).copied();
            let ahead = next.map_or(stop, |jump| jump.first);
            cuts.truncate(prefix.n_cuts);
            let ending = &by_last.spans[prefix.next_last..by_last.at[ahead + 1]];
            self.find_cuts(ending, &path, to_stop, offsets, &mut cuts);
            let top = path.len() - 1;
            let prefix = &mut path[top];
            prefix.n_cuts = cuts.len();
            prefix.next_last = by_last.at[ahead + 1];
            let (from, to) = (&measures.up_to[prefix.leave], &measures.up_to[ahead]);
            let number = prefix.number + to_stop[prefix.leave] - to_stop[ahead];
            if let Some(jump) = next {
                prefix.next_first += 1;
                let corner = &measures.corner[ahead];
                let longer = Prefix {
                    jump: jump.chord,
                    enter: ahead,
                    leave: jump.last,
                    number: number + offsets[jump.chord],
                    length: prefix.length + to.arc - from.arc + measures.chord[jump.chord],
                    moments: std::array::from_fn(|i| {
                        prefix.moments[i] + (to.moments[i] - from.moments[i]) + corner[i]
                    }),
                    n_cuts: cuts.len(),
                    next_first: by_first.at[jump.last],
                    next_last: by_last.at[jump.last],
                };
                path.push(longer);
                continue;
            }
            // No jump is left: leave the sub-cycle whole, or make the best of its cuts.
            let moments: Moments =
                std::array::from_fn(|i| prefix.moments[i] + (to.moments[i] - from.moments[i]));
            let size = prefix.length + to.arc - from.arc;
            self.solve_one(base + number, &moments, size, &cuts, &mut totals);
            path.pop();
        }
    }

    /// Add those of the chords that could cut a path.
    ///
    /// ending: chords that end where the path is settled, by their last end.
    #[inline(always)]
    fn find_cuts(
        &self,
        ending: &[Span],
        path: &[Prefix],
        to_stop: &[i64],
        offsets: &[i64],
        cuts: &mut Vec<Cut>,
    ) {
        let top = path.len() - 1;
        let (mut previous, mut paths, mut jumps) = (None, &[][..], &[][..]);
        // The number of the part from `behind` on, among the paths to where the chord ends, and the
        // last jump that the part does not contain.
        let (mut number, mut behind, mut t) = (0, 0, 0);
        for &Span { chord, first, last } in ending {
            if previous != Some(last) {
                previous = Some(last);
                paths = self.numbering.paths_to(last);
                jumps = self.numbering.offsets_to(last);
                (number, behind, t) = (0, last, top);
            }
            while path[t].leave > first {
                number += paths[path[t].leave] - paths[behind] + jumps[path[t].jump];
                behind = path[t].enter;
                t -= 1;
            }
            // It begins under a jump.
            if behind < first {
                continue;
            }
            let under = number + paths[first] - paths[behind];
            // Number 0 is the chord itself: it is on the boundary.
            if under > 0 {
                let up_to_first = path[t].number + to_stop[path[t].leave] - to_stop[first];
                let up_to_last = path[top].number + to_stop[path[top].leave] - to_stop[last];
                let under = (self.numbering.base[chord] + under) as usize;
                cuts.push(Cut {
                    chord,
                    under,
                    value: self.solutions.value[under],
                    shift: up_to_first + offsets[chord] - up_to_last,
                    price: self.problem.alpha * self.measures.chord[chord],
                });
            }
        }
    }

    /// Solve one sub-cycle, by its number, of the given moments and length.
    #[inline(always)]
    fn solve_one(
        &mut self,
        own: i64,
        moments: &Moments,
        size: f64,
        cuts: &[Cut],
        totals: &mut Vec<f64>,
    ) {
        let (value, choice) = (&mut self.solutions.value, &mut self.solutions.choice);
        let tie = TIE * (1.0 + self.problem.alpha);
        let mut flat = find_determinant(moments) * (1.0 / self.measures.whole);
        if !self.problem.printed {
            flat = flat.sqrt();
        }
        let share = 1.0 / size;
        let mut least = flat;
        totals.clear();
        totals.extend(cuts.iter().map(|cut| {
            let total = cut.value + value[cut.rest(own)] + share * cut.price;
            least = min(least, total);
            total
        }));
        let mut chosen: Option<(&Cut, f64, u32)> = None;
        if flat > least + tie {
            for (cut, &total) in cuts.iter().zip(&*totals) {
                if total > least + tie {
                    continue;
                }
                let n_chords = 1 + choice[cut.under].fewest + choice[cut.rest(own)].fewest;
                if chosen
                    .is_none_or(|(best, _, fewest)| (n_chords, cut.chord) < (fewest, best.chord))
                {
                    chosen = Some((cut, total, n_chords));
                }
            }
        }
        let own = own as usize;
        value[own] = chosen.map_or(flat, |(_, total, _)| total);
        choice[own] = chosen.map_or(Choice::default(), |(cut, _, fewest)| Choice {
            fewest,
            after_chord: cut.chord as u32 + 1,
        });
    }
}

/// Write the chosen chords, and the pieces' positions with the bounds between them.
fn trace_pieces(n: usize, numbering: &Subcycles, solutions: &Solutions, cuts: &mut Cuts) {
    let mut open = vec![(None, numbering.n_paths() - 1)];
    while let Some((wrap, number)) = open.pop() {
        let path = numbering.path_of(wrap, number);
        let place = (numbering.base_of(wrap) + number) as usize;
        let Some(chord) = solutions.choice[place].chord() else {
            write_piece(n, numbering, wrap, &path, &mut cuts.positions);
            cuts.bounds.push(cuts.positions.len());
            continue;
        };
        cuts.chosen.push(chord);
        let Span { first, last, .. } = numbering.spans[chord];
        let from = path.ends.partition_point(|&end| end < first);
        let to = path.ends.partition_point(|&end| end < last);
        let (_, stop) = numbering.range(wrap);
        let without = numbering.sum_offsets(&path, from, to, stop);
        open.push((Some(chord), numbering.sum_offsets(&path, from, to, last)));
        open.push((wrap, number - without + numbering.offsets_to(stop)[chord]));
    }
    cuts.bounds.pop();
}

/// Add a piece's positions.
fn write_piece(
    n: usize,
    numbering: &Subcycles,
    wrap: Option<usize>,
    path: &Path,
    positions: &mut Vec<usize>,
) {
    let ends = &numbering.ends;
    for (&end, jump) in path.ends.iter().zip(&path.jumps) {
        let begin = ends[end];
        let stop = match jump {
            Some(_) => begin + 1,
            None => ends.get(end + 1).map_or(ends[0] + n, |&next| next),
        };
        positions.extend((begin..stop).map(|v| v % n));
    }
    if wrap.is_some() {
        positions.extend(path.ends.last().map(|&end| ends[end]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chords::flatness::standardise;

    fn solve(points: &[Point], chords: &[[i64; 2]], alpha: f64) -> Cuts {
        let (own, _) = standardise(points);
        let problem = CutProblem {
            points,
            own: &own,
            chords,
            alpha,
            printed: false,
        };
        problem.solve().unwrap()
    }

    /// Return a square folded along the diagonal from 0 to 4, with a vertex in every side.
    fn fold() -> Vec<Point> {
        vec![
            [0.0, 0.0, 0.0],
            [0.5, 0.0, 0.5],
            [1.0, 0.0, 1.0],
            [1.0, 0.5, 0.5],
            [1.0, 1.0, 0.0],
            [0.5, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.5, 0.0],
        ]
    }

    #[test]
    fn a_fold_is_cut_along_its_edge() {
        let chords = [[2, 6], [0, 4], [1, 5]];
        let cuts = solve(&fold(), &chords, 0.1);
        assert_eq!(cuts.chosen, [1]);
        assert_eq!(cuts.bounds, [5]);
        assert_eq!(cuts.positions, [0, 4, 5, 6, 7, 0, 1, 2, 3, 4]);
        let around = 2.0 + 2.0 * 2.0_f64.sqrt();
        assert!((cuts.cost - 0.1 * 2.0_f64.sqrt() / around).abs() < 1e-12);
    }

    #[test]
    fn cuts_that_cost_too_much_are_not_made() {
        let cuts = solve(&fold(), &[[0, 4]], 10.0);
        assert!((cuts.cost - 1.0).abs() < 1e-12);
        assert!(cuts.chosen.is_empty() && cuts.bounds.is_empty());
        assert_eq!(cuts.positions, [0, 1, 2, 3, 4, 5, 6, 7]);
    }
}
