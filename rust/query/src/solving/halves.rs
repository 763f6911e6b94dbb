//! Fractional matchings: can the sides' slack be met with halves? The relaxation of the matching, by
//! flow.
//!
//! Doubled, a half-integral matching is an integral flow from every side to a copy of every side:
//! slack_i units leave i and arrive at its copy, and class (i, j) carries any number of units from i
//! to the copy of j and from j to the copy of i. Without such a flow, a matching does not exist.
//!
//! [`meet_slack`] is for many thousand systems in each query, as lists of neighbours: each begins with a
//! guess that is often right, and without a flow the sides that ask for too much are named,
//! which answers other orientations of the system as well.

use crate::solving::graphs::{Graph, Square};

/// No side, and no copy.
const NONE: usize = usize::MAX;

/// Scratch of [`meet_slack`].
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

/// Find a flow: units from each side to the copies of its neighbours. Return whether there is one.
///
/// Where there is none, [`Scratch::cut`] is why. `flow` is written at neighbours only.
#[inline(always)]
pub fn meet_slack(slack: &[i32], graph: &Graph, flow: &mut Square, scratch: &mut Scratch) -> bool {
    if take_shares(slack, graph, flow, &mut scratch.supply) == 0 {
        return true;
    }
    scratch.demand.copy_from_slice(&scratch.supply);
    for source in 0..slack.len() {
        while scratch.supply[source] > 0 {
            match reach(source, graph, flow, scratch) {
                Some(sink) => send(source, sink, flow, scratch),
                None => return false,
            }
        }
    }
    true
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

/// Send as much as can be along the path found, and the same along its mirror image.
///
/// With both, the flow between two sides stays equal in both directions, and so whole when halved,
/// for as long as there is a path from one side to the copy of another.
#[inline(always)]
fn send(source: usize, sink: usize, flow: &mut Square, scratch: &mut Scratch) {
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
    let mut mirrored = source != sink && supply[sink].min(demand[source]) >= amount;
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

/// A class of polychords, or of the parts that strokes divide them into, in the system of one pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Class {
    /// One side that the class joins.
    pub i: usize,
    /// The other, or the same.
    pub j: usize,
    /// How many polychords the class has; 0 for a class of a tolerance.
    pub n: i32,
    /// What the square of a width counts.
    pub weight: i32,
}

impl Class {
    /// Return the other end, seen from a side; None where the class does not end there.
    #[inline(always)]
    pub fn across(&self, side: usize) -> Option<usize> {
        if self.i == side {
            Some(self.j)
        } else if self.j == side {
            Some(self.i)
        } else {
            None
        }
    }
}

/// An arc of a flow: a class, and whether it is passed against its order.
#[derive(Clone, Copy)]
struct Arc {
    class: usize,
    back: usize,
}

/// A flow for one system whose classes are decided one after another.
///
/// The values that one class takes in all flows are an interval ([`Transport::tighten_bounds`]), which
/// cuts a search where it would try in vain value by value.
#[derive(Default)]
pub struct Transport {
    /// Units of each class from i to j, and from j to i (0 where i = j).
    flow: Vec<[i32; 2]>,
    supply: Vec<i32>,
    demand: Vec<i32>,
    /// How breadth-first search reached each side, and each copy.
    side_by: Vec<Option<Arc>>,
    copy_by: Vec<Option<Arc>>,
}

impl Transport {
    /// Return the flow that was found: units of each class from i to j, and from j to i.
    pub fn flow(&self) -> &[[i32; 2]] {
        &self.flow
    }

    /// Find a flow over the open classes that gives every side its slack; false where there is none.
    pub fn find(&mut self, slack: &[i32], classes: &[Class], closed: &[bool]) -> bool {
        let open = || (0..classes.len()).filter(|&k| !closed[k]);
        // Most calls end here: a side asks for more than all its neighbours can give.
        let mut reach = vec![0; slack.len()];
        for k in open() {
            let Class { i, j, .. } = classes[k];
            reach[i] += slack[j];
            reach[j] += slack[i];
        }
        if slack.iter().zip(&reach).any(|(slack, reach)| slack > reach) {
            return false;
        }
        self.supply = slack.to_vec();
        self.demand = slack.to_vec();
        self.flow.clear();
        self.flow.resize(classes.len(), [0; 2]);
        for k in open() {
            let Class { i, j, .. } = classes[k];
            for (back, from, to) in [(0, i, j), (1, j, i)] {
                if back == 0 || i != j {
                    let sent = self.supply[from].min(self.demand[to]);
                    self.flow[k][back] = sent;
                    self.supply[from] -= sent;
                    self.demand[to] -= sent;
                }
            }
        }
        for source in 0..slack.len() {
            while self.supply[source] > 0 {
                match self.reach(source, classes, closed) {
                    Some(sink) => self.send(source, sink, classes),
                    None => return false,
                }
            }
        }
        true
    }

    /// Search, breadth first, for a copy that takes more, from a side that has more to give.
    fn reach(&mut self, source: usize, classes: &[Class], closed: &[bool]) -> Option<usize> {
        let n_sides = self.supply.len();
        self.side_by.clear();
        self.side_by.resize(n_sides, None);
        self.copy_by.clear();
        self.copy_by.resize(n_sides, None);
        let mut reached = vec![source];
        let mut head = 0;
        while let Some(&side) = reached.get(head) {
            head += 1;
            for (k, class) in classes.iter().enumerate() {
                let Some(copy) = class.across(side).filter(|_| !closed[k]) else {
                    continue;
                };
                if self.copy_by[copy].is_some() {
                    continue;
                }
                let back = usize::from(class.i != side);
                self.copy_by[copy] = Some(Arc { class: k, back });
                if self.demand[copy] > 0 {
                    return Some(copy);
                }
                // Units that arrive here can be sent elsewhere by the side they left.
                for (b, class) in classes.iter().enumerate() {
                    for (back, start, end) in [(0, class.i, class.j), (1, class.j, class.i)] {
                        let arrives = self.flow[b][back] != 0 && end == copy;
                        if arrives && start != source && self.side_by[start].is_none() {
                            self.side_by[start] = Some(Arc { class: b, back });
                            reached.push(start);
                        }
                    }
                }
            }
        }
        None
    }

    /// Send as much as can be along the path found.
    fn send(&mut self, source: usize, sink: usize, classes: &[Class]) {
        let ends = |arc: Arc| {
            let Class { i, j, .. } = classes[arc.class];
            if arc.back == 0 { (i, j) } else { (j, i) }
        };
        let mut amount = self.supply[source].min(self.demand[sink]);
        for widen in [false, true] {
            let mut copy = sink;
            loop {
                let arc = self.copy_by[copy].expect("a path leads to the sink");
                let (side, _) = ends(arc);
                if widen {
                    self.flow[arc.class][arc.back] += amount;
                }
                if side == source {
                    break;
                }
                let arc = self.side_by[side].expect("a path leads to the sink");
                copy = ends(arc).1;
                let flow = &mut self.flow[arc.class][arc.back];
                if widen {
                    *flow -= amount;
                } else {
                    amount = amount.min(*flow);
                }
            }
        }
        self.supply[source] -= amount;
        self.demand[sink] -= amount;
    }

    /// Return the least and greatest integer of a range that class k takes in some flow; None where
    /// a flow does not exist.
    ///
    /// `slack` and `closed` are changed, and as they were at the end.
    pub fn tighten_bounds(
        &mut self,
        slack: &mut [i32],
        classes: &[Class],
        closed: &mut [bool],
        k: usize,
        [low, high]: [i32; 2],
    ) -> Option<[i32; 2]> {
        if !self.find(slack, classes, closed) {
            return None;
        }
        let Class { i, j, .. } = classes[k];
        // A flow carries y from either end; a class with both ends on one side carries 2 y.
        let twice = self.flow[k][0] + self.flow[k][1];
        let below = twice / 2;
        let above = twice - below;
        closed[k] = true;
        // Bisect: good is a value that some flow takes, bad one beyond all of them.
        let mut bisect = |mut good: i32, mut bad: i32| {
            while (bad - good).abs() > 1 {
                let middle = (good + bad).div_euclid(2);
                slack[i] -= middle;
                slack[j] -= middle;
                if self.find(slack, classes, closed) {
                    good = middle;
                } else {
                    bad = middle;
                }
                slack[i] += middle;
                slack[j] += middle;
            }
            good
        };
        let least = bisect(below + 1, low - 1);
        let most = bisect(above - 1, high + 1);
        closed[k] = false;
        Some([
            if least <= below { least } else { above },
            if most >= above { most } else { below },
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_of_a_class_are_those_of_all_flows() {
        let class = |i, j| Class {
            i,
            j,
            n: 1,
            weight: 1,
        };
        // A square: what one class takes, its neighbours do not.
        let classes = [class(0, 1), class(1, 2), class(2, 3), class(0, 3)];
        let mut transport = Transport::default();
        let mut slack = [3, 5, 4, 2];
        let mut closed = [false; 4];
        let mut tighten =
            |range| transport.tighten_bounds(&mut slack, &classes, &mut closed, 0, range);
        assert_eq!(tighten([0, 3]), Some([1, 3]));
        slack = [3, 5, 4, 3];
        assert_eq!(
            transport.tighten_bounds(&mut slack, &classes, &mut closed, 0, [0, 3]),
            None
        );
    }
}
