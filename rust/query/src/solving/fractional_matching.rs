//! Fractional matchings: can the sides' slack be met with halves? The relaxation of the matching, by
//! flow.
//!
//! Doubled, a half-integral matching is an integral flow from every side to a copy of every side:
//! slack_i units leave i and arrive at its copy, and class (i, j) carries any number of units from i
//! to the copy of j and from j to the copy of i. Without such a flow, a matching does not exist.
//!
//! [`find_flow`] is for many thousand systems in each query, as lists of neighbours: each begins with a
//! guess that is often right, and without a flow the sides that ask for too much are named, which
//! answers other orientations of the system as well.

use crate::solving::systems::Graph;

/// No side, and no copy.
const NONE: usize = usize::MAX;

/// A square table, such as units that flow from side to side.
#[derive(Clone, Debug, Default)]
pub struct Square {
    n: usize,
    items: Vec<i32>,
}

impl Square {
    /// Return a table of n rows of zeros.
    pub fn new(n: usize) -> Square {
        let items = vec![0; n * n];
        Square { n, items }
    }

    /// Take a table, row by row.
    pub fn from_items(n: usize, items: &[i32]) -> Square {
        let items = items.to_vec();
        Square { n, items }
    }

    /// Return the table, row by row.
    pub fn items(&self) -> &[i32] {
        &self.items
    }
}

impl std::ops::Index<[usize; 2]> for Square {
    type Output = i32;

    #[inline(always)]
    fn index(&self, [i, j]: [usize; 2]) -> &i32 {
        &self.items[i * self.n + j]
    }
}

impl std::ops::IndexMut<[usize; 2]> for Square {
    #[inline(always)]
    fn index_mut(&mut self, [i, j]: [usize; 2]) -> &mut i32 {
        &mut self.items[i * self.n + j]
    }
}

/// Scratch of [`find_flow`].
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Units that a side has still to send.
    supply: Vec<i32>,
    /// Units that a copy has still to receive.
    demand: Vec<i32>,
    /// The copy whose inflow was cut back to reach a side.
    side_by: Vec<usize>,
    /// The side that a copy was reached from.
    copy_by: Vec<usize>,
    /// The sides reached, in order.
    reached: Vec<usize>,
}

impl Scratch {
    /// Return scratch for systems of `n_sides` sides.
    pub fn new(n_sides: usize) -> Scratch {
        Scratch {
            supply: vec![0; n_sides],
            demand: vec![0; n_sides],
            side_by: vec![NONE; n_sides],
            copy_by: vec![NONE; n_sides],
            reached: Vec::with_capacity(n_sides),
        }
    }

    /// Return the sides that ask for more than their neighbours have, after a flow was not found.
    pub fn cut(&self) -> &[usize] {
        &self.reached
    }

    /// Return whether a side is one of these neighbours.
    pub fn is_near_cut(&self, side: usize) -> bool {
        self.copy_by[side] != NONE
    }

    /// Return numbers, one for each side, for another use.
    pub fn numbers(&mut self) -> &mut [i32] {
        &mut self.supply
    }
}

/// How a flow begins, before paths complete it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Each side shares its slack among its neighbours, and paths have mirror images, so that most
    /// flows are whole when halved. The fastest.
    Shares,
    /// Each class takes as much as it can, one way and then back, in ascending order of its sides: the
    /// same flow whatever the order in which the graph has its classes.
    Greedy,
}

/// Find a flow: units from each side to the copies of its neighbours. Return whether there is one.
///
/// Where there is none, [`Scratch::cut`] is why. `flow` is written at neighbours only.
#[inline(always)]
pub fn find_flow(
    slack: &[i32],
    graph: &Graph,
    start: Start,
    flow: &mut Square,
    scratch: &mut Scratch,
) -> bool {
    if start == Start::Greedy {
        take_most(slack, graph, flow, scratch);
    } else if take_shares(slack, graph, flow, &mut scratch.supply) == 0 {
        return true;
    } else {
        scratch.demand.copy_from_slice(&scratch.supply);
    }
    for source in 0..slack.len() {
        while scratch.supply[source] > 0 {
            match reach(source, graph, flow, scratch) {
                Some(sink) => send(source, sink, start == Start::Shares, flow, scratch),
                None => return false,
            }
        }
    }
    true
}

/// Return twice what a class takes in a flow.
#[inline(always)]
pub fn doubled(flow: &Square, i: usize, j: usize) -> i32 {
    if i == j {
        flow[[i, j]]
    } else {
        flow[[i, j]] + flow[[j, i]]
    }
}

/// Begin the flow: each class in ascending order takes as much as it can, one way and then back.
fn take_most(slack: &[i32], graph: &Graph, flow: &mut Square, scratch: &mut Scratch) {
    let Scratch { supply, demand, .. } = scratch;
    supply.copy_from_slice(slack);
    demand.copy_from_slice(slack);
    for i in 0..slack.len() {
        for j in graph.near(i).filter(|&j| j >= i) {
            let there = supply[i].min(demand[j]);
            supply[i] -= there;
            demand[j] -= there;
            flow[[i, j]] = there;
            if i != j {
                let back = supply[j].min(demand[i]);
                supply[j] -= back;
                demand[i] -= back;
                flow[[j, i]] = back;
            }
        }
    }
}

/// Begin the flow: each side in turn shares its slack among its neighbours not yet served, in
/// proportion to theirs. Writes the rest to supply; returns the sum of it.
#[inline(always)]
fn take_shares(slack: &[i32], graph: &Graph, flow: &mut Square, supply: &mut [i32]) -> i32 {
    supply.copy_from_slice(slack);
    let mut left: i32 = slack.iter().sum();
    for (i, others) in graph.classes_by_side() {
        let mut own = supply[i];
        let reach: i32 = others.iter().map(|&j| supply[j as usize]).sum();
        // Where a side is joined to itself, it counts as its own neighbour here.
        let share = if reach > 0 {
            f64::from(own) / f64::from(reach)
        } else {
            0.0
        };
        for &j in others {
            let j = j as usize;
            if i == j {
                flow[[i, i]] = own;
                left -= own;
                own = 0;
                continue;
            }
            let other = supply[j];
            let sent = own.min(other).min((f64::from(other) * share + 0.5) as i32);
            flow[[i, j]] = sent;
            flow[[j, i]] = sent;
            own -= sent;
            supply[j] = other - sent;
            left -= 2 * sent;
        }
        supply[i] = own;
    }
    left
}

/// Search, breadth first, for a copy that takes more, from a side that has more to give.
#[inline(always)]
fn reach(source: usize, graph: &Graph, flow: &Square, scratch: &mut Scratch) -> Option<usize> {
    scratch.side_by.fill(NONE);
    scratch.copy_by.fill(NONE);
    scratch.side_by[source] = source;
    scratch.reached.clear();
    scratch.reached.push(source);
    let mut head = 0;
    while let Some(&side) = scratch.reached.get(head) {
        head += 1;
        for copy in graph.near(side) {
            if scratch.copy_by[copy] != NONE {
                continue;
            }
            scratch.copy_by[copy] = side;
            if scratch.demand[copy] > 0 {
                return Some(copy);
            }
            // Units that arrive here can be sent elsewhere by the side they left.
            for other in graph.near(copy) {
                if scratch.side_by[other] == NONE && flow[[other, copy]] > 0 {
                    scratch.side_by[other] = copy;
                    scratch.reached.push(other);
                }
            }
        }
    }
    None
}

/// Send as much as can be along the path found; with `mirror` the same along its mirror image, if it
/// has as much.
///
/// With both, the flow between two sides stays equal in both directions, and so whole when halved,
/// for as long as there is a path from one side to the copy of another.
#[inline(always)]
fn send(source: usize, sink: usize, mirror: bool, flow: &mut Square, scratch: &mut Scratch) {
    let Scratch {
        supply,
        demand,
        side_by,
        copy_by,
        ..
    } = scratch;
    let mut amount = supply[source].min(demand[sink]);
    let mut side = copy_by[sink];
    while side != source {
        amount = amount.min(flow[[side, side_by[side]]]);
        side = copy_by[side_by[side]];
    }
    let mut copy = sink;
    loop {
        let side = copy_by[copy];
        flow[[side, copy]] += amount;
        if side == source {
            break;
        }
        copy = side_by[side];
        flow[[side, copy]] -= amount;
    }
    supply[source] -= amount;
    demand[sink] -= amount;
    let mut mirrored = mirror && source != sink && supply[sink].min(demand[source]) >= amount;
    let mut side = copy_by[sink];
    while mirrored && side != source {
        let copy = side_by[side];
        mirrored = flow[[copy, side]] >= amount;
        side = copy_by[copy];
    }
    if !mirrored {
        return;
    }
    let mut copy = sink;
    loop {
        let side = copy_by[copy];
        flow[[copy, side]] += amount;
        if side == source {
            break;
        }
        copy = side_by[side];
        flow[[copy, side]] -= amount;
    }
    supply[sink] -= amount;
    demand[source] -= amount;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solving::systems::OwnGraph;

    #[test]
    fn both_starts_find_a_flow_where_there_is_one() {
        // A triangle has halves where the sum is odd, and nothing where a side asks for too much.
        let triangle = OwnGraph::new(3, [(0, 1), (0, 2), (1, 2)].into_iter());
        for start in [Start::Shares, Start::Greedy] {
            for (slack, found) in [([1, 1, 1], true), ([2, 4, 4], true), ([5, 1, 2], false)] {
                let (mut flow, mut scratch) = (Square::new(3), Scratch::new(3));
                let graph = triangle.graph();
                let is_found = find_flow(&slack, &graph, start, &mut flow, &mut scratch);
                assert_eq!(is_found, found);
                for i in (0..3).filter(|_| found) {
                    let sent: i32 = (0..3).map(|j| flow[[i, j]]).sum();
                    let arrived: i32 = (0..3).map(|j| flow[[j, i]]).sum();
                    assert_eq!([sent, arrived], [slack[i]; 2]);
                }
                if !found {
                    assert_eq!(scratch.cut(), [0]);
                    assert!(!scratch.is_near_cut(0) && scratch.is_near_cut(1));
                }
            }
        }
    }
}
