//! The uncapacitated b-matching on the sides of one pattern: is there one, and which are there?
//!
//! Given slack_i >= 0 for every side and classes that join sides (i, j), find integers y_ij >= 0 with
//! sum_j y_ij + 2 y_ii = slack_i: how much wider than 1 the polychords of each class are in sum.
//!
//! [`search_matchings`] lists solutions depth-first; [`choose_class`] states where it branches and
//! within which bounds, and [`Parity`] rejects by parity. Source: the integer program of Marcias et
//! al. 2015, section 4. Differs from the paper: an own search in place of a general solver, over
//! classes in place of single polychords, since one class is one variable to the sides.
//!
//! [`decide`] decides whether there is a solution at all. A flow ([`crate::solving::halves`]) gives a matching with halves. Rounding the halves down leaves some sides
//! short by a few units. The rest is a matching problem in an ordinary graph, solved by augmenting
//! paths (Edmonds, "Paths, trees, and flowers", 1965), so that the decision is exact and takes
//! polynomial time.
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

use crate::solving::graphs::{Graph, Graphs, Square};
use crate::solving::halves::{Class, Scratch, Transport, meet_slack};
use crate::solving::systems::{is_balanced, order_classes, two_colour};

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
    if !meet_slack(slack, graph, flow, scratch) {
        return Verdict::Cut;
    }
    let is_whole = graph.classes().all(|(i, j)| doubled(flow, i, j) & 1 == 0);
    if is_whole || round(graph, flow, scratch.numbers()) {
        Verdict::Matchable
    } else {
        Verdict::Halves
    }
}

/// Return twice what a class takes in a flow.
#[inline(always)]
fn doubled(flow: &Square, i: usize, j: usize) -> i32 {
    if i == j {
        flow[[i, j]]
    } else {
        flow[[i, j]] + flow[[j, i]]
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

/// Decide exactly whether open classes meet the slack, where several may join the same sides.
pub fn is_soluble(slack: &[i32], classes: &[Class]) -> bool {
    let w = slack.len();
    let mut joined = vec![false; w * w];
    for class in classes {
        joined[class.i * w + class.j] = true;
        joined[class.j * w + class.i] = true;
    }
    let mut ordered = Vec::new();
    order_classes(&joined, w, &mut ordered);
    let class_i: Vec<i16> = ordered.iter().map(|&(i, _)| i as i16).collect();
    let class_j: Vec<i16> = ordered.iter().map(|&(_, j)| j as i16).collect();
    let claim: Vec<i32> = (0..w as i32).collect();
    let mut near_first = vec![0];
    let mut near = Vec::new();
    for row in joined.chunks_exact(w) {
        near.extend((0..w).filter(|&j| row[j]).map(|j| j as i16));
        near_first.push(near.len() as i32);
    }
    let graphs = Graphs {
        first: &[0, class_i.len() as i32],
        class_i: &class_i,
        class_j: &class_j,
        claim: &claim,
        near_first: &near_first,
        near: &near,
        n_sides: w,
    };
    let (mut flow, mut scratch) = (Square::new(w), Scratch::new(w));
    decide(slack, &graphs.graph(0), &mut flow, &mut scratch) == Verdict::Matchable
}

/// Dead ends after which a search no longer trusts its cheap bounds and asks, wherever it branches,
/// whether there is a solution at all. Most searches meet none; those that do may meet millions. From
/// then on the time between two solutions is polynomial.
pub const PATIENCE: usize = 30;

/// More than any slack: what a class with both ends on one side can absorb.
const UNBOUNDED: i32 = 1 << 24;

/// What a search does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Decide a class, with the least and the greatest value that it may take.
    Class(usize, [i32; 2]),
    /// All classes are decided and no slack is left.
    Done,
    /// A side asks for more than its neighbours can give.
    Dead,
}

/// Choose the open class to decide next: one of the side with the fewest open classes; one left means
/// one value.
///
/// `residual` is the slack not yet given to a class, `closed` says which classes are decided.
pub fn choose_class(residual: &[i32], classes: &[Class], closed: &[bool]) -> Choice {
    let n_sides = residual.len();
    let mut degree = vec![0; n_sides];
    let mut reach = vec![0; n_sides];
    for (&Class { i, j, .. }, _) in classes.iter().zip(closed).filter(|(_, closed)| !**closed) {
        degree[i] += 1;
        if i == j {
            reach[i] += UNBOUNDED;
        } else {
            degree[j] += 1;
            reach[i] += residual[j];
            reach[j] += residual[i];
        }
    }
    if residual
        .iter()
        .zip(&reach)
        .any(|(residual, reach)| residual > reach)
    {
        return Choice::Dead;
    }
    // Nothing left means that all classes of the side are 0: as good as decided.
    let open = (0..n_sides).filter(|&side| degree[side] > 0);
    let Some(side) = open.min_by_key(|&side| if residual[side] > 0 { degree[side] } else { 1 })
    else {
        return Choice::Done;
    };
    let mut ends = classes.iter().zip(closed);
    let first = ends.position(|(class, closed)| !closed && class.across(side).is_some());
    let k = first.expect("the side has an open class");
    let Class { i, j, .. } = classes[k];
    let (a, b) = (residual[i], residual[j]);
    let bounds = if i == j {
        [((a - (reach[i] - UNBOUNDED)).max(0) + 1) / 2, a / 2]
    } else {
        let least = (a - (reach[i] - b)).max(b - (reach[j] - a));
        [least.max(0), a.min(b)]
    };
    Choice::Class(k, bounds)
}

/// What parity refuses, with scratch for many calls.
pub struct Parity {
    open: Vec<(usize, usize)>,
    component: Vec<i16>,
    colour: Vec<i16>,
    sums: Vec<i32>,
}

impl Parity {
    /// Make scratch for systems of some number of sides.
    pub fn new(n_sides: usize) -> Parity {
        Parity {
            open: Vec::new(),
            component: vec![0; n_sides],
            colour: vec![0; n_sides],
            sums: vec![0; n_sides],
        }
    }

    /// Return whether the open classes can absorb the residual, for all that parity shows.
    pub fn allows(&mut self, residual: &[i32], classes: &[Class], closed: &[bool]) -> bool {
        let open = classes.iter().zip(closed).filter(|(_, closed)| !**closed);
        self.open.clear();
        self.open.extend(open.map(|(class, _)| (class.i, class.j)));
        two_colour(&self.open, &mut self.component, &mut self.colour);
        is_balanced(residual, &self.component, &self.colour, &mut self.sums)
    }
}

/// Counting stops here, far above what a caller asks for; a product of two still fits.
pub const MANY: i64 = 1 << 30;

/// Count the ways to write `value` as an ordered sum of `parts` integers >= 0, at most [`MANY`].
pub fn count_splits(value: i64, parts: i64) -> i64 {
    let mut ways = 1;
    for p in 1..parts {
        // C(value + p, p) from C(value + p - 1, p - 1): the division is exact.
        if ways > MANY {
            return MANY;
        }
        ways = ways * (value + p) / p;
    }
    ways.min(MANY)
}

/// Solutions of a matching.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Matchings {
    /// For each solution the values of all classes.
    pub rows: Vec<i32>,
    /// The number of widths that they stand for, at most [`MANY`].
    pub n_widths: i64,
}

/// A decided class of a search, and the least value that it may take.
struct Decision {
    class: usize,
    least: i32,
}

/// List solutions, depth-first, until they stand for more than `limit` widths.
///
/// A solution stands for the product of its classes' [`count_splits`]. The list is whole exactly if
/// the number of widths is at most the limit.
pub fn search_matchings(slack: &[i32], classes: &[Class], limit: i64) -> Matchings {
    let mut found = Matchings::default();
    let mut residual = slack.to_vec();
    let mut closed = vec![false; classes.len()];
    let mut value = vec![0; classes.len()];
    let mut decided: Vec<Decision> = Vec::new();
    let mut parity = Parity::new(slack.len());
    let mut transport = Transport::default();
    let mut dead_ends = 0;
    loop {
        let mut choice = choose_class(&residual, classes, &closed);
        if dead_ends > PATIENCE
            && let Choice::Class(k, bounds) = choice
            && bounds[0] < bounds[1]
        {
            let open = classes.iter().zip(&closed).filter(|(_, closed)| !**closed);
            let open: Vec<Class> = open.map(|(class, _)| *class).collect();
            let soluble = is_soluble(&residual, &open);
            let tightened = soluble
                .then(|| transport.tighten_bounds(&mut residual, classes, &mut closed, k, bounds));
            choice = match tightened.flatten() {
                Some(bounds) => Choice::Class(k, bounds),
                None => Choice::Dead,
            };
        }
        match choice {
            Choice::Done => {
                found.rows.extend(&value);
                let ways = classes
                    .iter()
                    .zip(&value)
                    .fold(1, |ways: i64, (class, &value)| {
                        (ways * count_splits(value.into(), class.n.into())).min(MANY)
                    });
                found.n_widths = (found.n_widths + ways).min(MANY);
                if found.n_widths > limit {
                    return found;
                }
            }
            // Parity is dear to test: only where there is a choice to be spared.
            Choice::Class(k, [least, most])
                if least == most || least < most && parity.allows(&residual, classes, &closed) =>
            {
                decided.push(Decision { class: k, least });
                closed[k] = true;
                value[k] = most;
                residual[classes[k].i] -= most;
                residual[classes[k].j] -= most;
                continue;
            }
            Choice::Class(..) | Choice::Dead => {
                dead_ends += 1;
                if dead_ends == PATIENCE + 1 {
                    // Begin again, this time with flows.
                    found = Matchings::default();
                    residual.copy_from_slice(slack);
                    closed.fill(false);
                    decided.clear();
                    continue;
                }
            }
        }
        // Lower the last class that may take less.
        loop {
            let Some(&Decision { class: k, least }) = decided.last() else {
                return found;
            };
            let lowered = value[k] > least;
            let back = if lowered { 1 } else { value[k] };
            value[k] -= back;
            residual[classes[k].i] += back;
            residual[classes[k].j] += back;
            if lowered {
                break;
            }
            closed[k] = false;
            decided.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn class(i: usize, j: usize) -> Class {
        Class {
            i,
            j,
            n: 1,
            weight: 1,
        }
    }

    /// Three sides, each joined to both others.
    fn triangle() -> [Class; 3] {
        [class(0, 1), class(0, 2), class(1, 2)]
    }

    #[test]
    fn an_odd_cycle_has_halves_alone_where_the_sum_is_odd() {
        assert!(is_soluble(&[2, 2, 2], &triangle()));
        assert!(is_soluble(&[1, 2, 3], &triangle()));
        assert!(!is_soluble(&[1, 1, 1], &triangle()));
        assert!(!is_soluble(&[5, 1, 2], &triangle()));
    }

    #[test]
    fn halves_are_rounded_along_augmenting_paths() {
        // Two triangles joined at one side each: a half is left over in both.
        let mut classes: Vec<Class> = triangle().into();
        classes.extend([class(3, 4), class(3, 5), class(4, 5), class(2, 3)]);
        assert!(is_soluble(&[1; 6], &classes));
        classes.pop();
        assert!(!is_soluble(&[1; 6], &classes));
    }

    #[test]
    fn all_matchings_are_listed_largest_values_first() {
        // Two classes between the same two sides as far as a triangle allows.
        let classes = [class(0, 1), class(0, 1), class(1, 1)];
        let found = search_matchings(&[2, 4], &classes, 9);
        assert_eq!(found.rows, [2, 0, 1, 1, 1, 1, 0, 2, 1]);
        assert_eq!(found.n_widths, 3);
        assert_eq!(search_matchings(&[2, 4], &classes, 0).rows, [2, 0, 1]);
        assert!(search_matchings(&[2, 3], &classes, 9).rows.is_empty());
    }

    #[test]
    fn splits_are_counted() {
        assert_eq!(count_splits(3, 1), 1);
        assert_eq!(count_splits(3, 3), 10);
        assert_eq!(count_splits(5000, 40), MANY);
    }

    #[test]
    fn the_side_with_the_fewest_classes_is_decided_first() {
        let classes = [class(0, 1), class(1, 2), class(1, 1)];
        let choice = choose_class(&[2, 9, 3], &classes, &[false; 3]);
        assert_eq!(choice, Choice::Class(0, [2, 2]));
        assert_eq!(choose_class(&[0; 3], &classes, &[true; 3]), Choice::Done);
        assert_eq!(
            choose_class(&[1, 0, 0], &classes, &[false; 3]),
            Choice::Dead
        );
    }
}
