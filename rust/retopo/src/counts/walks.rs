//! Walks: closed ways across chains, each of them one edge more or fewer, that make counts better.
//!
//! A way through a patch changes two of its chains by 1, so that it stays even. A walk is closed, or
//! comes from outside and goes back there. It visits no patch twice, so that what it gains is the
//! sum over its steps, and it is found as a shortest path of negative length. Of a cyclic sequence
//! with a negative sum some rotation has negative sums from its beginning to every place (Lin and
//! Kernighan 1973, the gain criterion): ways that have cost something are given up at once.

use std::collections::VecDeque;
use std::iter;

use super::rules::is_cheap;

/// What a patch is after a change: it has a regular fill, it has none, or it may not be so. Also in
/// patterndb_sketch.retopo.counts.walks.
const CHEAP: i8 = 0;
const IRREGULAR: i8 = 1;
const FORBIDDEN: i8 = 2;

/// Edges around a patch, at least. Also in patterndb_sketch.retopo.counts.problem.
const MIN_PERIMETER: i64 = 4;

/// Gains below this are rounding.
const GAIN: f64 = 1e-6;

/// No label, no patch.
const NONE: i32 = -1;

/// The halves of a network: occurrences of chains in patches, two of a chain between patches and one
/// of a chain at the rim.
#[derive(Clone, Copy, Debug)]
pub struct Halves<'a> {
    /// Of each half its chain.
    pub chain: &'a [i32],
    /// Of each half its patch.
    pub patch: &'a [i32],
    /// Of each half its side.
    pub side: &'a [i32],
    /// Of each half its number within the patch.
    pub place: &'a [i32],
    /// Of each half the one on the other side of the chain, -1 where that is outside.
    pub twin: &'a [i32],
    /// The halves of patch f are `first_half[f]` to `first_half[f + 1]`.
    pub first_half: &'a [i32],
    /// The sides of patch f are `first_side[f]` to `first_side[f + 1]`.
    pub first_side: &'a [i32],
    /// Where the table of each patch begins.
    pub first_after: &'a [i64],
}

impl Halves<'_> {
    fn chain(&self, half: usize) -> usize {
        self.chain[half] as usize
    }

    fn patch(&self, half: usize) -> usize {
        self.patch[half] as usize
    }

    fn twin(&self, half: usize) -> Option<usize> {
        usize::try_from(self.twin[half]).ok()
    }

    /// Return the half on the other side of the chain where that is in the same patch.
    fn twin_within(&self, half: usize) -> Option<usize> {
        let twin = self.twin(half)?;
        (self.patch[twin] == self.patch[half]).then_some(twin)
    }

    /// Return the number of halves of a patch.
    fn n_halves(&self, patch: usize) -> usize {
        (self.first_half[patch + 1] - self.first_half[patch]) as usize
    }
}

/// Write what patches are, and would be if a half got one edge more or fewer and another too.
///
/// `lengths`: of all sides. `state`: of every patch. `after`: for every patch of d halves a table of
/// 2 d rows and columns, 2 place + 1 for one edge more and 2 place for one fewer.
pub fn judge_patches(
    halves: &Halves,
    lengths: &[i32],
    patches: &[i32],
    state: &mut [i8],
    after: &mut [i8],
) {
    for &patch in patches {
        let patch = patch as usize;
        let low = halves.first_side[patch] as usize;
        let high = halves.first_side[patch + 1] as usize;
        let mut lengths = lengths[low..high].to_vec();
        let perimeter: i64 = lengths.iter().copied().map(i64::from).sum();
        state[patch] = judge(&lengths);
        let first = halves.first_half[patch] as usize;
        let side = |change: usize| halves.side[first + change / 2] as usize - low;
        let by = |change: usize| if change % 2 == 1 { 1 } else { -1 };
        let n_changes = 2 * halves.n_halves(patch);
        let table = &mut after[halves.first_after[patch] as usize..][..n_changes * n_changes];
        for (one, row) in table.chunks_exact_mut(n_changes.max(1)).enumerate() {
            lengths[side(one)] += by(one);
            for (other, judged) in row.iter_mut().enumerate() {
                *judged = if perimeter + i64::from(by(one) + by(other)) < MIN_PERIMETER {
                    FORBIDDEN
                } else {
                    lengths[side(other)] += by(other);
                    let judged = judge(&lengths);
                    lengths[side(other)] -= by(other);
                    judged
                };
            }
            lengths[side(one)] -= by(one);
        }
    }
}

fn judge(lengths: &[i32]) -> i8 {
    if is_cheap(lengths) { CHEAP } else { IRREGULAR }
}

/// What walks are searched in.
#[derive(Clone, Copy, Debug)]
pub struct WalkGraph<'a> {
    /// Chains and patches.
    pub halves: Halves<'a>,
    /// See [`judge_patches`].
    pub after: &'a [i8],
    /// See [`judge_patches`].
    pub state: &'a [i8],
    /// What a chain's change by -2, -1, 1, 2 costs, infinite where it may not.
    pub step: &'a [[f64; 4]],
    /// What a patch without a regular fill costs.
    pub regularity: f64,
}

/// A half that gets one edge more, or fewer: 2 half + 1, or 2 half.
///
/// As the label of a search it is a way into the half's patch; the number after all is the outside.
type Change = usize;

impl WalkGraph<'_> {
    /// Return what the patch of a changed half is if each of its halves is changed too: fewer, more.
    fn judged(&self, change: Change) -> &[[i8; 2]] {
        let halves = &self.halves;
        let (half, more) = (change / 2, change % 2);
        let patch = halves.patch(half);
        let width = 2 * halves.n_halves(patch);
        let row = 2 * halves.place[half] as usize + more;
        let first = halves.first_after[patch] as usize + row * width;
        self.after[first..first + width].as_chunks().0
    }

    /// Return what it costs that a patch is as judged, and no longer as it is.
    fn price_patch(&self, judged: i8, state: i8) -> f64 {
        if judged == FORBIDDEN {
            return f64::INFINITY;
        }
        self.regularity * f64::from(judged - state)
    }

    /// Return what a change of two halves of a patch costs more.
    fn price_passage(&self, one: Change, other: Change) -> f64 {
        let place = self.halves.place[other / 2] as usize;
        let judged = self.judged(one)[place][other % 2];
        self.price_patch(judged, self.state[self.halves.patch(one / 2)])
    }

    /// Return what a change of one chain by 1 costs, without the patches.
    fn price_step(&self, change: Change) -> f64 {
        self.step[self.halves.chain(change / 2)][1 + change % 2]
    }

    /// Return what a change of one chain alone costs: by 2, or by 1 if it is in its patch twice.
    fn price_single_change(&self, change: Change) -> f64 {
        let (half, more) = (change / 2, change % 2);
        if let Some(twin) = self.halves.twin_within(half) {
            return self.price_step(change) + self.price_passage(change, 2 * twin + more);
        }
        let step = self.step[self.halves.chain(half)][3 * more];
        let cost = step + self.price_passage(change, change);
        match self.halves.twin(half) {
            Some(twin) => cost + self.price_passage(2 * twin + more, 2 * twin + more),
            None => cost,
        }
    }
}

/// Find the first walk that gains, from any of the halves `starts`, from place `begin` on.
///
/// `walk`, of more than `most_steps + 1` rows, gets chains and their changes. Returns how many there
/// are, 0 where no walk gains; the place of the start looked at last; and the gain.
pub fn find_walk(
    graph: &WalkGraph,
    starts: &[i32],
    begin: usize,
    most_steps: usize,
    walk: &mut [[i32; 2]],
) -> (usize, usize, f64) {
    let halves = &graph.halves;
    let mut search = Search::new(graph, most_steps, walk);
    for (place, &half) in starts.iter().enumerate().skip(begin) {
        let half = half as usize;
        for more in 0..2 {
            let root = 2 * half + more;
            let gain = -graph.price_single_change(root);
            if gain > GAIN {
                let by = if halves.twin_within(half).is_some() {
                    1
                } else {
                    2
                };
                let by = if more == 1 { by } else { -by };
                search.walk[0] = [halves.chain[half], by];
                return (1, place, gain);
            }
            if graph.price_step(root).is_infinite() {
                continue;
            }
            if let Some((n, gain)) = search.run(root, (2 * place + more + 1) as u32) {
                return (n, place, gain);
            }
        }
    }
    (0, starts.len(), 0.0)
}

/// Searches for walks, one root after another, and what each has found out about ways into patches
/// and to the outside: its labels.
struct Search<'a> {
    graph: &'a WalkGraph<'a>,
    most_steps: u32,
    walk: &'a mut [[i32; 2]],
    /// Of each label the search that wrote it, from 1 on.
    stamp: Vec<u32>,
    /// What the way there costs.
    length: Vec<f64>,
    /// The label before, or NONE.
    before: Vec<i32>,
    /// The change by which the way leaves the patch of the label before.
    way_out: Vec<u32>,
    steps: Vec<u32>,
    waiting: Vec<bool>,
    queue: VecDeque<usize>,
    /// The halves at the rim.
    rim: Vec<usize>,
    /// The patches of a walk that is followed back.
    seen: Vec<i32>,
}

/// A step of a way.
struct Passage {
    /// The label before.
    at: usize,
    /// The change by which it leaves.
    change: Change,
    target: usize,
    /// What the way to the target costs.
    reached: f64,
}

impl<'a> Search<'a> {
    fn new(graph: &'a WalkGraph<'a>, most_steps: usize, walk: &'a mut [[i32; 2]]) -> Search<'a> {
        let n_halves = graph.halves.chain.len();
        let n_labels = 2 * n_halves + 1;
        let halves = 0..n_halves;
        Search {
            graph,
            most_steps: most_steps as u32,
            walk,
            stamp: vec![0; n_labels],
            length: vec![0.0; n_labels],
            before: vec![0; n_labels],
            way_out: vec![0; n_labels],
            steps: vec![0; n_labels],
            waiting: vec![false; n_labels],
            queue: VecDeque::new(),
            rim: halves.filter(|&half| graph.halves.twin[half] < 0).collect(),
            seen: Vec::new(),
        }
    }

    /// The number of the label of the outside.
    fn outside(&self) -> usize {
        self.stamp.len() - 1
    }

    /// Search from a root: the length of the walk that gains, and the gain; None where none does.
    fn run(&mut self, root: Change, stamp: u32) -> Option<(usize, f64)> {
        self.length[root] = 0.0;
        self.before[root] = NONE;
        self.steps[root] = 0;
        self.stamp[root] = stamp;
        self.queue.clear();
        self.queue.push_back(root);
        while let Some(at) = self.queue.pop_front() {
            self.waiting[at] = false;
            if self.steps[at] >= self.most_steps {
                continue;
            }
            let found = if at == self.outside() {
                self.enter(root, stamp)
            } else {
                self.leave(at, root, stamp)
            };
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// Go on from outside by each half at the rim.
    fn enter(&mut self, root: Change, stamp: u32) -> Option<(usize, f64)> {
        let at = self.outside();
        let length = self.length[at];
        for k in 0..self.rim.len() {
            for more in 0..2 {
                let change = 2 * self.rim[k] + more;
                let reached = length + self.graph.price_step(change);
                if reached >= -GAIN {
                    continue;
                }
                let passage = Passage {
                    at,
                    change,
                    target: change,
                    reached,
                };
                let found = self.pass(&passage, root, stamp);
                if found.is_some() {
                    return found;
                }
            }
        }
        None
    }

    /// Go on from a way into a patch by each other half of it.
    fn leave(&mut self, at: Change, root: Change, stamp: u32) -> Option<(usize, f64)> {
        let graph = self.graph;
        let halves = &graph.halves;
        let patch = halves.patch(at / 2);
        let state = graph.state[patch];
        let length = self.length[at];
        let first = halves.first_half[patch] as usize;
        for (half, judged) in (first..).zip(graph.judged(at)) {
            if half == at / 2 || halves.twin_within(half).is_some() {
                continue;
            }
            let step = &graph.step[halves.chain(half)];
            for more in 0..2 {
                let mut reached = length + step[1 + more];
                if reached < graph.regularity {
                    reached += graph.price_patch(judged[more], state);
                }
                if reached >= -GAIN {
                    continue;
                }
                let passage = Passage {
                    at,
                    change: 2 * half + more,
                    target: match halves.twin(half) {
                        Some(twin) => 2 * twin + more,
                        None => self.outside(),
                    },
                    reached,
                };
                let found = self.pass(&passage, root, stamp);
                if found.is_some() {
                    return found;
                }
            }
        }
        None
    }

    /// Take a step of a way: return a walk that closes and gains.
    fn pass(&mut self, passage: &Passage, root: Change, stamp: u32) -> Option<(usize, f64)> {
        let &Passage {
            at,
            change,
            target,
            reached,
        } = passage;
        if target == root {
            let found = self.retrace_walk(at, change);
            return found.filter(|&(_, gain)| gain > GAIN);
        }
        let known = self.stamp[target] == stamp;
        if known && reached >= self.length[target] - GAIN || self.is_visited(target, at) {
            return None;
        }
        self.length[target] = reached;
        self.before[target] = at as i32;
        self.way_out[target] = change as u32;
        self.steps[target] = self.steps[at] + 1;
        self.stamp[target] = stamp;
        if !known || !self.waiting[target] {
            self.waiting[target] = true;
            self.queue.push_back(target);
        }
        None
    }

    /// Return a label and all before it on its way.
    fn trace_back(&self, at: usize) -> impl Iterator<Item = usize> {
        iter::successors(Some(at), |&at| usize::try_from(self.before[at]).ok())
    }

    /// Return whether the target's patch, or the outside, is on the way to a label.
    fn is_visited(&self, target: usize, at: usize) -> bool {
        let outside = self.outside();
        let patch = self.graph.halves.patch;
        // Labels change while others still lead to them: such a way may bite its tail.
        let longest = self.before.len();
        self.trace_back(at).enumerate().any(|(steps, at)| {
            steps >= longest
                || if target == outside || at == outside {
                    target == at
                } else {
                    patch[target / 2] == patch[at / 2]
                }
        })
    }

    /// Write the walk that closes by a change: how many chains, and the gain; None if it is not one.
    ///
    /// It is followed back afresh, as labels on the way may have changed since.
    fn retrace_walk(&mut self, last: usize, change: Change) -> Option<(usize, f64)> {
        let (graph, outside) = (self.graph, self.outside());
        let mut cost = 0.0;
        let (mut at, mut leaving) = (last, change);
        self.seen.clear();
        loop {
            let n = self.seen.len();
            if n == self.walk.len() {
                return None;
            }
            let patch = if at == outside {
                NONE
            } else {
                graph.halves.patch[at / 2]
            };
            let chain = graph.halves.chain[leaving / 2];
            let mut before = self.seen.iter().zip(&*self.walk);
            if before.any(|(&place, walked)| place == patch || walked[0] == chain) {
                return None;
            }
            self.seen.push(patch);
            self.walk[n] = [chain, 2 * (leaving % 2) as i32 - 1];
            cost += graph.price_step(leaving);
            if at != outside {
                cost += graph.price_passage(at, leaving);
            }
            if self.before[at] < 0 {
                return Some((n + 1, -cost));
            }
            leaving = self.way_out[at] as usize;
            at = self.before[at] as usize;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One patch of four chains, all at the rim.
    const QUAD: Halves = Halves {
        chain: &[0, 1, 2, 3],
        patch: &[0; 4],
        side: &[0, 1, 2, 3],
        place: &[0, 1, 2, 3],
        twin: &[-1; 4],
        first_half: &[0, 4],
        first_side: &[0, 4],
        first_after: &[0, 64],
    };

    fn judged(lengths: &[i32]) -> ([i8; 1], [i8; 64]) {
        let (mut state, mut after) = ([9], [9; 64]);
        judge_patches(&QUAD, lengths, &[0], &mut state, &mut after);
        (state, after)
    }

    #[test]
    fn patches_are_judged_after_each_two_changes() {
        let (state, after) = judged(&[1, 1, 1, 1]);
        assert_eq!(state, [CHEAP]);
        // Both ways round opposite sides, one edge more.
        assert_eq!(after[8 + 5], CHEAP);
        assert_eq!(after[5 * 8 + 1], CHEAP);
        assert_eq!(after[8 + 3], IRREGULAR);
        assert_eq!(after[0], FORBIDDEN);
    }

    #[test]
    fn a_strip_across_a_patch_is_a_walk() {
        let (state, after) = judged(&[2, 1, 2, 1]);
        let up = [f64::INFINITY, 1.0, -1.0, 0.5];
        let graph = WalkGraph {
            halves: QUAD,
            after: &after,
            state: &state,
            step: &[up, [f64::INFINITY; 4], up, [f64::INFINITY; 4]],
            regularity: 10.0,
        };
        let mut walk = [[0; 2]; 8];
        let found = find_walk(&graph, &[0, 1, 2, 3], 0, 6, &mut walk);
        assert_eq!(found, (2, 0, 2.0));
        assert_eq!(walk[..2], [[0, 1], [2, 1]]);
    }
}
