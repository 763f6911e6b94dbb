//! The uncapacitated b-matching on the sides of one pattern: is there one?
//!
//! Given slack_i >= 0 for every side and classes that join sides (i, j), find integers y_ij >= 0 with
//! sum_j y_ij + 2 y_ii = slack_i: how much wider than 1 the polychords of each class are in sum. Which
//! solutions there are, [`crate::solving::branch_and_bound`] searches. Source: the integer program of
//! Marcias et al. 2015, section 4. Differs from the paper: over classes in place of single polychords,
//! since one class is one variable to the sides.
//!
//! [`decide`] decides whether there is a solution at all. A flow
//! ([`crate::solving::fractional_matching`]) gives a matching with halves. Rounding the halves down
//! leaves some sides short by a few units. The rest is a matching problem in an ordinary graph, solved
//! by augmenting paths (Edmonds, "Paths, trees, and flowers", 1965), so that the decision is exact and
//! takes polynomial time.
//!
//! Give each side as many *copies* as it has slack, and join two copies wherever a class joins their
//! sides (two copies of one side if that side is joined to itself). A matching of the sides is a
//! perfect matching of the copies; one that leaves sides short leaves copies single. If a perfect
//! matching exists, then from every single copy there leads an augmenting path: the difference of the
//! two matchings. So one search from one single copy either shortens the deficit or proves that there
//! is no matching.
//!
//! The copies need not all be made: two pairs of each class are enough, and one of a class that joins
//! a side to itself. Let a shortest augmenting path walk through two pairs of one class in the same
//! direction, (i', j') first and (i'', j'') later, and let x be the copy before i'. Then x is joined
//! to i'' as well, since copies of one side have the same neighbours, and the path that goes from x
//! to i'' at once is shorter. So each direction occurs at most once; a class of a side with itself
//! has only one.

use crate::solving::fractional_matching::{Scratch, Square, Start, doubled, find_flow};
use crate::solving::systems::{Graph, OwnGraph};

/// Pairs of a class that a shortest augmenting path may use: one in each direction.
const PAIRS: i32 = 2;

/// What is known of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// A matching gives every side its slack.
    Matchable,
    /// The sides of [`Scratch::cut`] ask for more than their neighbours have.
    Cut,
    /// Only halves would do.
    Halves,
}

/// Decide whether a matching gives every side its slack. `flow` and `scratch` are overwritten.
#[inline(always)]
pub fn decide(slack: &[i32], graph: &Graph, flow: &mut Square, scratch: &mut Scratch) -> Verdict {
    if !find_flow(slack, graph, Start::Shares, flow, scratch) {
        return Verdict::Cut;
    }
    let is_whole = graph.classes().all(|(i, j)| doubled(flow, i, j) & 1 == 0);
    if is_whole || round(graph, flow, scratch.numbers()) {
        Verdict::Matchable
    } else {
        Verdict::Halves
    }
}

/// Turn a flow into a matching, symmetric; false where there is none.
///
/// `short` has a number for each side, and is overwritten: how many units it lacks.
fn round(graph: &Graph, y: &mut Square, short: &mut [i32]) -> bool {
    short.fill(0);
    for (i, j) in graph.classes() {
        let twice = doubled(y, i, j);
        y[[i, j]] = twice >> 1;
        y[[j, i]] = twice >> 1;
        short[i] += twice & 1;
        short[j] += twice & 1;
    }
    // Two halves each.
    short.iter_mut().for_each(|short| *short >>= 1);
    for (i, j) in graph.classes() {
        let more = if i == j {
            short[i] >> 1
        } else {
            short[i].min(short[j])
        };
        y[[i, j]] += more;
        short[i] -= more;
        short[j] -= more;
        y[[j, i]] = y[[i, j]];
    }
    for side in 0..short.len() {
        while short[side] > 0 {
            // Copies take long to make, and most sides need none.
            if !take_detour(side, graph, y, short) && !augment(side, graph, y, short) {
                return false;
            }
        }
    }
    true
}

fn widen(y: &mut Square, i: usize, j: usize, by: i32) {
    y[[i, j]] += by;
    if i != j {
        y[[j, i]] += by;
    }
}

/// Make a side and another one, or itself once more, less short by one each, by an augmenting path
/// of three edges, if there is one: a class that two neighbours share gives up one.
fn take_detour(side: usize, graph: &Graph, y: &mut Square, short: &mut [i32]) -> bool {
    for one in graph.near(side) {
        for other in graph.near(one) {
            // A side that is joined to itself may be its own neighbour; then it is not short.
            if one == side || other == side || y[[one, other]] == 0 {
                continue;
            }
            for end in graph.near(other) {
                if end != other && short[end] > i32::from(end == side) {
                    widen(y, side, one, 1);
                    widen(y, one, other, -1);
                    widen(y, other, end, 1);
                    short[side] -= 1;
                    short[end] -= 1;
                    return true;
                }
            }
        }
    }
    false
}

/// Make a side and another one, or itself once more, less short by one each. False where no augmenting
/// path begins at the side: then a matching does not exist.
fn augment(root_side: usize, graph: &Graph, y: &mut Square, short: &mut [i32]) -> bool {
    let copies = Copies::new(graph, y, short);
    let mut forest = Forest::new(&copies, root_side);
    let Some(path) = forest.search(graph) else {
        return false;
    };
    short[root_side] -= 1;
    short[copies.side_of[path[0]]] -= 1;
    // Single edges and pairs in turn, from the far end on.
    for (k, ends) in path.windows(2).enumerate() {
        let [one, other] = [ends[0], ends[1]].map(|copy| copies.side_of[copy]);
        widen(y, one, other, if k % 2 == 0 { 1 } else { -1 });
    }
    true
}

/// The copies that a shortest augmenting path may need.
struct Copies {
    /// Where the copies of each side begin, and where those of the last end.
    start: Vec<usize>,
    /// The side of each copy.
    side_of: Vec<usize>,
    /// The copy that each is paired with.
    mate: Vec<Option<usize>>,
}

impl Copies {
    fn new(graph: &Graph, y: &Square, short: &[i32]) -> Copies {
        let pairs = |i: usize, j: usize| y[[i, j]].min(if i == j { 1 } else { PAIRS }) as usize;
        let mut start = vec![0];
        let mut side_of = Vec::new();
        for (i, &short) in short.iter().enumerate() {
            // Both copies of a pair of a side with itself are this side's.
            let paired = graph.near(i).map(|j| pairs(i, j) << usize::from(i == j));
            let count = short as usize + paired.sum::<usize>();
            side_of.resize(side_of.len() + count, i);
            start.push(side_of.len());
        }
        let mut mate = vec![None; side_of.len()];
        let mut free = start.clone();
        let mut take = |side: usize| {
            free[side] += 1;
            free[side] - 1
        };
        for i in 0..short.len() {
            for j in graph.near(i).filter(|&j| j >= i) {
                for _ in 0..pairs(i, j) {
                    let (one, other) = (take(i), take(j));
                    mate[one] = Some(other);
                    mate[other] = Some(one);
                }
            }
        }
        Copies {
            start,
            side_of,
            mate,
        }
    }
}

/// The alternating paths from a single copy, odd cycles shrunk.
struct Forest<'a> {
    copies: &'a Copies,
    root: usize,
    /// For a copy at odd distance from the root, the copy before it on an alternating path.
    by: Vec<Option<usize>>,
    /// The copy that stands for each, once its odd cycle is shrunk.
    base: Vec<usize>,
    /// Whether an alternating path of even length reaches a copy.
    even: Vec<bool>,
    /// The even copies, as they were reached.
    queue: Vec<usize>,
}

impl<'a> Forest<'a> {
    fn new(copies: &'a Copies, root_side: usize) -> Forest<'a> {
        let n = copies.mate.len();
        let mut root = copies.start[root_side];
        while copies.mate[root].is_some() {
            root += 1;
        }
        let mut even = vec![false; n];
        even[root] = true;
        Forest {
            copies,
            root,
            by: vec![None; n],
            base: (0..n).collect(),
            even,
            queue: vec![root],
        }
    }

    /// Return an augmenting path, the root last.
    fn search(&mut self, graph: &Graph) -> Option<Vec<usize>> {
        let Copies {
            start,
            side_of,
            mate,
        } = self.copies;
        let mut head = 0;
        while let Some(&v) = self.queue.get(head) {
            head += 1;
            for u in graph
                .near(side_of[v])
                .flat_map(|side| start[side]..start[side + 1])
            {
                if self.base[u] == self.base[v] || mate[v] == Some(u) {
                    continue;
                }
                let is_even = mate[u].is_some_and(|mate| self.by[mate].is_some());
                if u == self.root || is_even {
                    self.contract(u, v);
                } else if self.by[u].is_none() {
                    self.by[u] = Some(v);
                    let Some(next) = mate[u] else {
                        return Some(self.path(u));
                    };
                    self.even[next] = true;
                    self.queue.push(next);
                }
            }
        }
        None
    }

    /// Return the path from a copy to the root.
    fn path(&self, end: usize) -> Vec<usize> {
        let mut path = vec![end];
        while let Some(before) = self.by[path[path.len() - 1]] {
            path.push(before);
            path.extend(self.copies.mate[before]);
            if self.copies.mate[before].is_none() {
                break;
            }
        }
        path
    }

    /// Return the copy before an odd one.
    fn before(&self, copy: usize) -> usize {
        self.by[copy].expect("the copy is at odd distance from the root")
    }

    /// Return the mate of a copy other than the root.
    fn mate(&self, copy: usize) -> usize {
        self.copies.mate[copy].expect("only the root is single")
    }

    /// Shrink the odd cycle that the edge (u, v) closes; its copies are all even then.
    fn contract(&mut self, u: usize, v: usize) {
        let n = self.base.len();
        let mut marked = vec![false; n];
        let mut a = self.base[u];
        loop {
            marked[a] = true;
            match self.copies.mate[a] {
                Some(mate) => a = self.base[self.before(mate)],
                None => break,
            }
        }
        let mut stem = self.base[v];
        while !marked[stem] {
            stem = self.base[self.before(self.mate(stem))];
        }
        marked.fill(false);
        for (from, towards) in [(v, u), (u, v)] {
            let (mut a, mut child) = (from, towards);
            while self.base[a] != stem {
                let mate = self.mate(a);
                marked[self.base[a]] = true;
                marked[self.base[mate]] = true;
                self.by[a] = Some(child);
                child = mate;
                a = self.before(child);
            }
        }
        for copy in 0..n {
            if marked[self.base[copy]] {
                self.base[copy] = stem;
                if !self.even[copy] {
                    self.even[copy] = true;
                    self.queue.push(copy);
                }
            }
        }
    }
}

/// Decide exactly whether classes between sides meet the slack.
pub fn is_soluble(slack: &[i32], pairs: impl Iterator<Item = (usize, usize)>) -> bool {
    let w = slack.len();
    let graph = OwnGraph::new(w, pairs);
    let (mut flow, mut scratch) = (Square::new(w), Scratch::new(w));
    decide(slack, &graph.graph(), &mut flow, &mut scratch) == Verdict::Matchable
}

/// Return the least and the greatest integer of a range that the first of some classes takes in a
/// fractional matching; None where a matching does not exist.
///
/// The values that a class takes in all fractional matchings are an interval.
pub fn tighten_bounds(
    slack: &[i32],
    pairs: &[(usize, usize)],
    [low, high]: [i32; 2],
) -> Option<[i32; 2]> {
    let w = slack.len();
    let (i, j) = pairs[0];
    let (mut flow, mut scratch) = (Square::new(w), Scratch::new(w));
    let all = OwnGraph::new(w, pairs.iter().copied());
    let graph = all.graph();
    if !find_flow(slack, &graph, Start::Shares, &mut flow, &mut scratch) {
        return None;
    }
    // Half of it is a value that some flow takes.
    let twice = doubled(&flow, i, j);
    if !round(&graph, &mut flow, scratch.numbers()) {
        return None;
    }
    let (below, above) = (twice / 2, twice - twice / 2);
    let others = OwnGraph::new(w, pairs[1..].iter().copied());
    let mut rest = slack.to_vec();
    // Bisect: good is a value that some flow takes, bad one beyond all of them.
    let mut bisect = |mut good: i32, mut bad: i32| {
        while (bad - good).abs() > 1 {
            let middle = (good + bad).div_euclid(2);
            rest.copy_from_slice(slack);
            rest[i] -= middle;
            rest[j] -= middle;
            let graph = others.graph();
            if find_flow(&rest, &graph, Start::Shares, &mut flow, &mut scratch) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        good
    };
    let least = bisect(below + 1, low - 1);
    let most = bisect(above - 1, high + 1);
    Some([
        if least <= below { least } else { above },
        if most >= above { most } else { below },
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three sides, each joined to both others.
    const TRIANGLE: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

    #[test]
    fn an_odd_cycle_has_halves_alone_where_the_sum_is_odd() {
        for (slack, soluble) in [
            ([2, 2, 2], true),
            ([1, 2, 3], true),
            ([1, 1, 1], false),
            ([5, 1, 2], false),
        ] {
            assert_eq!(is_soluble(&slack, TRIANGLE.into_iter()), soluble);
        }
    }

    #[test]
    fn halves_are_rounded_along_augmenting_paths() {
        // Two triangles joined at one side each: a half is left over in both.
        let mut pairs = TRIANGLE.to_vec();
        pairs.extend([(3, 4), (3, 5), (4, 5), (2, 3)]);
        assert!(is_soluble(&[1; 6], pairs.iter().copied()));
        pairs.pop();
        assert!(!is_soluble(&[1; 6], pairs.iter().copied()));
    }

    #[test]
    fn bounds_of_a_class_are_those_of_all_flows() {
        // A square: what one class takes, its neighbours do not.
        let pairs = [(0, 1), (1, 2), (2, 3), (0, 3)];
        assert_eq!(tighten_bounds(&[3, 5, 4, 2], &pairs, [0, 3]), Some([1, 3]));
        assert_eq!(tighten_bounds(&[3, 5, 4, 3], &pairs, [0, 3]), None);
    }
}
