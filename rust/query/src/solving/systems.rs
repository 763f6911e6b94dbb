//! The linear systems that widths solve, of all signatures of a class.
//!
//! For every side s the widths of the polychords that end on it add up to the edges asked for; a
//! polychord with both ends on s counts twice (Marcias et al. 2015, section 4). The polychords of one
//! pattern that join the same two sides form a *class*: only the sum of their widths matters to the
//! sides. With slack = edges asked for - base length, the sums solve an uncapacitated b-matching on
//! the sides ([`crate::solving::matching`]).
//!
//! Every signature stands for one system, a graph whose nodes are the sides and whose edges are the
//! classes of polychords that join them.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use crate::solving::sieve::MOST_SURPLUS;

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
    /// For each system a row: each side's colour, see [`two_colour`].
    pub colour: &'a [i16],
    /// Whether parity can refuse an even perimeter.
    pub parity: &'a [bool],
    /// The number of each system's graph, in `hall_first`.
    pub graph: &'a [i32],
    /// Where the Hall conditions of each graph begin, and where those of the last end.
    pub hall_first: &'a [i32],
    /// The Hall conditions, see [`crate::solving::hall_conditions`].
    pub hall: &'a [i32],
}

/// The graphs of many systems with the same number of sides.
#[derive(Clone, Copy, Debug)]
pub struct Graphs<'a> {
    /// Where the classes of each graph begin, and where those of the last end.
    pub first: &'a [i32],
    /// One side that each class joins, in the order in which a first flow fills the classes.
    pub class_i: &'a [i16],
    /// The other side.
    pub class_j: &'a [i16],
    /// For each graph a row: the claim of each side. A *claim* is a side and the sides that it is
    /// joined to; there are far fewer of them than sides of all graphs.
    pub claim: &'a [i32],
    /// Where the sides of each claim begin in `near`, and where those of the last end.
    pub near_first: &'a [i32],
    /// The sides that the side of each claim is joined to; one joined to itself is listed once.
    pub near: &'a [i16],
    /// Number of sides of every graph.
    pub n_sides: usize,
}

/// The graph of one system.
#[derive(Clone, Copy, Debug)]
pub struct Graph<'a> {
    class_i: &'a [i16],
    class_j: &'a [i16],
    /// The claim of each side.
    pub claim: &'a [i32],
    near_first: &'a [i32],
    near: &'a [i16],
}

impl<'a> Graphs<'a> {
    /// Return the graph of the system in a row.
    #[inline(always)]
    pub fn graph(&self, row: usize) -> Graph<'a> {
        let classes = self.first[row] as usize..self.first[row + 1] as usize;
        Graph {
            class_i: &self.class_i[classes.clone()],
            class_j: &self.class_j[classes],
            claim: &self.claim[row * self.n_sides..][..self.n_sides],
            near_first: self.near_first,
            near: self.near,
        }
    }
}

impl<'a> Graph<'a> {
    /// Return the number of sides.
    #[inline(always)]
    pub fn n_sides(&self) -> usize {
        self.claim.len()
    }

    /// Return the sides that each class joins.
    #[inline(always)]
    pub fn classes(&self) -> impl Iterator<Item = (usize, usize)> + 'a {
        let pairs = self.class_i.iter().zip(self.class_j);
        pairs.map(|(&i, &j)| (i as usize, j as usize))
    }

    /// Return the classes that are listed with their first side, side by side in their order.
    #[inline(always)]
    pub fn classes_by_side(&self) -> impl Iterator<Item = (usize, &'a [i16])> + 'a {
        let class_j = self.class_j;
        let mut at = 0;
        self.class_i.chunk_by(|i, j| i == j).map(move |run| {
            let others = &class_j[at..at + run.len()];
            at += run.len();
            (run[0] as usize, others)
        })
    }

    /// Return the sides that a side is joined to.
    #[inline(always)]
    pub fn near(&self, side: usize) -> impl Iterator<Item = usize> + Clone + 'a {
        let claim = self.claim[side] as usize;
        let range = self.near_first[claim] as usize..self.near_first[claim + 1] as usize;
        self.near[range].iter().map(|&side| side as usize)
    }
}

/// The graph of one system, by the sides that its classes join.
///
/// Classes may come in any order, and several may join the same sides.
#[derive(Clone, Debug)]
pub struct OwnGraph {
    class_i: Vec<i16>,
    class_j: Vec<i16>,
    claim: Vec<i32>,
    near_first: Vec<i32>,
    near: Vec<i16>,
}

impl OwnGraph {
    /// Make the graph of classes between `n_sides` sides.
    pub fn new(n_sides: usize, pairs: impl Iterator<Item = (usize, usize)>) -> OwnGraph {
        let mut joined = vec![false; n_sides * n_sides];
        for (i, j) in pairs {
            joined[i * n_sides + j] = true;
            joined[j * n_sides + i] = true;
        }
        let mut ordered = Vec::new();
        order_classes(&joined, n_sides, &mut ordered);
        let mut made = OwnGraph {
            class_i: ordered.iter().map(|&(i, _)| i as i16).collect(),
            class_j: ordered.iter().map(|&(_, j)| j as i16).collect(),
            claim: (0..n_sides as i32).collect(),
            near_first: vec![0],
            near: Vec::new(),
        };
        for row in joined.chunks_exact(n_sides) {
            let near = (0..n_sides).filter(|&j| row[j]).map(|j| j as i16);
            made.near.extend(near);
            made.near_first.push(made.near.len() as i32);
        }
        made
    }

    /// Return the graph.
    pub fn graph(&self) -> Graph<'_> {
        Graph {
            class_i: &self.class_i,
            class_j: &self.class_j,
            claim: &self.claim,
            near_first: &self.near_first,
            near: &self.near,
        }
    }
}

/// A hash of small numbers, each multiplied by 2^64 over the golden ratio.
#[derive(Default)]
struct Scatter(u64);

impl Hasher for Scatter {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u8(byte));
    }

    fn write_u8(&mut self, number: u8) {
        self.write_usize(number.into());
    }

    fn write_usize(&mut self, number: usize) {
        let mixed = (self.0 >> 29) ^ self.0 ^ (number as u64 + 1);
        self.0 = mixed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
}

/// The claims of graphs: a *claim* is a side and the sides that it is joined to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Claims {
    /// For each graph a row: the claim of each side.
    pub claim: Vec<i32>,
    /// The side that makes each claim.
    pub claimant: Vec<i16>,
    /// Where the sides of each claim begin in `near`, and where those of the last end.
    pub near_first: Vec<i32>,
    /// The sides that the side of each claim is joined to; one joined to itself is listed once.
    pub near: Vec<i16>,
}

/// Number the claims of graphs of `n_sides` sides, in the order in which they come.
///
/// `joined` has `n_sides` rows for each graph: the sides that each side is joined to.
pub fn number_claims(joined: &[bool], n_sides: usize) -> Claims {
    let mut made = Claims {
        near_first: vec![0],
        ..Claims::default()
    };
    let mut numbers: HashMap<_, _, BuildHasherDefault<Scatter>> = HashMap::default();
    for (at, row) in joined.chunks_exact(n_sides).enumerate() {
        let side = at % n_sides;
        let number = *numbers.entry((side, row)).or_insert_with(|| {
            made.claimant.push(side as i16);
            let near = (0..n_sides).filter(|&j| row[j]).map(|j| j as i16);
            made.near.extend(near);
            made.near_first.push(made.near.len() as i32);
            made.claimant.len() as i32 - 1
        });
        made.claim.push(number);
    }
    made
}

/// What is needed of systems besides their claims.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Classes {
    /// Where the classes of each graph begin, and where those of the last end.
    pub first: Vec<i32>,
    /// One side that each class joins, in the order of [`order_classes`].
    pub class_i: Vec<i16>,
    /// The other side.
    pub class_j: Vec<i16>,
    /// For each system a row, one more than what the base lengths of a side's neighbours have beyond
    /// its own, at most MOST_SURPLUS; 0 where it is joined to itself: it asks no other.
    pub surplus: Vec<u8>,
    /// For each system a row: the first side of each side's component.
    pub component: Vec<i16>,
    /// For each system a row: each side's colour, see [`two_colour`].
    pub colour: Vec<i16>,
    /// Whether parity can refuse an even perimeter: not in a graph that is in one piece and has an
    /// odd cycle.
    pub parity: Vec<bool>,
}

/// List the classes of systems, what neighbours have, and parity.
///
/// `base` has for each system a row of base lengths, `joined` as for [`number_claims`].
pub fn list_classes(base: &[i16], joined: &[bool], n_sides: usize) -> Classes {
    let w = n_sides;
    let mut made = Classes {
        first: vec![0],
        ..Classes::default()
    };
    let mut classes = Vec::new();
    let mut component = vec![0; w];
    let mut colour = vec![0; w];
    for (base, joined) in base.chunks_exact(w).zip(joined.chunks_exact(w * w)) {
        order_classes(joined, w, &mut classes);
        made.class_i.extend(classes.iter().map(|&(i, _)| i as i16));
        made.class_j.extend(classes.iter().map(|&(_, j)| j as i16));
        made.first.push(made.class_i.len() as i32);
        for (i, row) in joined.chunks_exact(w).enumerate() {
            let near = base.iter().zip(row).filter(|(_, joined)| **joined);
            let surplus: i32 = near.map(|(&base, _)| i32::from(base)).sum();
            let surplus = (surplus + 1 - i32::from(base[i])).clamp(0, MOST_SURPLUS);
            made.surplus.push(if row[i] { 0 } else { surplus as u8 });
        }
        two_colour(&classes, &mut component, &mut colour);
        let mut sides = component.iter().zip(&colour);
        made.parity
            .push(sides.any(|(&component, &colour)| component > 0 || colour != 0));
        made.component.extend(&component);
        made.colour.extend(&colour);
    }
    made
}

/// List the classes, those of the side with the fewest first.
///
/// A side that has one class leaves it no choice, so taking as much as possible of each in this
/// order often meets every side. What a side sends to itself is its last resort.
pub fn order_classes(joined: &[bool], n_sides: usize, classes: &mut Vec<(usize, usize)>) {
    let rows: Vec<&[bool]> = joined.chunks_exact(n_sides).collect();
    // Classes of each side that are not listed, none once the side is done.
    let count = |row: &&[bool]| Some(row.iter().filter(|joined| **joined).count());
    let mut left: Vec<Option<usize>> = rows.iter().map(count).collect();
    classes.clear();
    for _ in 0..n_sides {
        let sides = (0..n_sides).filter(|&side| left[side].is_some());
        let Some(side) = sides.min_by_key(|&side| left[side]) else {
            return;
        };
        for j in (0..n_sides).filter(|&j| j != side && rows[side][j]) {
            if let Some(left) = &mut left[j] {
                classes.push((side, j));
                *left -= 1;
            }
        }
        if rows[side][side] {
            classes.push((side, side));
        }
        left[side] = None;
    }
}

/// Write each side's component under some classes, and its colour there.
///
/// A component is named by its first side. Colours are 1 and -1 such that classes join unlike
/// colours, 0 where the component has no such colouring.
pub fn two_colour(classes: &[(usize, usize)], component: &mut [i16], colour: &mut [i16]) {
    component.fill(-1);
    let mut reached = Vec::with_capacity(component.len());
    for root in 0..component.len() {
        if component[root] >= 0 {
            continue;
        }
        component[root] = root as i16;
        colour[root] = 1;
        reached.clear();
        reached.push(root);
        let mut head = 0;
        let mut bipartite = true;
        while let Some(&side) = reached.get(head) {
            head += 1;
            for &(i, j) in classes {
                let other = if i == side {
                    j
                } else if j == side {
                    i
                } else {
                    continue;
                };
                if component[other] < 0 {
                    component[other] = root as i16;
                    colour[other] = -colour[side];
                    reached.push(other);
                } else if colour[other] == colour[side] {
                    bipartite = false;
                }
            }
        }
        if !bipartite {
            reached.iter().for_each(|&side| colour[side] = 0);
        }
    }
}

/// Return whether the classes can absorb the residual, component by component, by parity.
///
/// A class takes as much from one end as from the other. So in a component whose sides are
/// two-coloured both colours must add up to the same; in any other the sum must be even. `sums` is
/// scratch, one for each side.
#[inline(always)]
pub fn is_balanced(residual: &[i32], component: &[i16], colour: &[i16], sums: &mut [i32]) -> bool {
    sums.fill(0);
    for ((residual, &component), &colour) in residual.iter().zip(component).zip(colour) {
        let sign = if colour == 0 { 1 } else { i32::from(colour) };
        sums[component as usize] += sign * residual;
    }
    // Sides that name no component sum nothing.
    let mut sides = sums.iter().zip(component).zip(colour).enumerate();
    sides.all(|(s, ((&sum, &component), &colour))| {
        component as usize != s || if colour == 0 { sum % 2 == 0 } else { sum == 0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sides 0 and 1 are joined to side 2, and side 3 to itself.
    fn joined() -> Vec<bool> {
        let mut joined = vec![false; 16];
        for (i, j) in [(0, 2), (2, 0), (1, 2), (2, 1), (3, 3)] {
            joined[4 * i + j] = true;
        }
        joined
    }

    #[test]
    fn a_side_and_its_neighbours_have_one_claim() {
        let made = number_claims(&[joined(), joined()].concat(), 4);
        assert_eq!(made.claim, [0, 1, 2, 3, 0, 1, 2, 3]);
        assert_eq!(made.near, [2, 2, 0, 1, 3]);
        assert_eq!(made.near_first, [0, 1, 2, 4, 5]);
    }

    #[test]
    fn sides_with_one_class_come_first() {
        let made = list_classes(&[1, 2, 5, 3], &joined(), 4);
        assert_eq!(made.class_i, [0, 1, 3]);
        assert_eq!(made.class_j, [2, 2, 3]);
        assert_eq!(made.surplus, [5, 4, 0, 0]);
        assert_eq!(made.component, [0, 0, 0, 3]);
        assert_eq!(made.colour, [1, 1, -1, 0]);
        assert_eq!(made.parity, [true]);
    }

    #[test]
    fn both_colours_must_add_up_to_the_same() {
        let mut sums = [0; 4];
        let mut check =
            |residual: [i32; 4]| is_balanced(&residual, &[0, 0, 0, 3], &[1, 1, -1, 0], &mut sums);
        assert!(check([1, 2, 3, 4]));
        assert!(!check([1, 2, 4, 4]));
        assert!(!check([1, 2, 3, 5]));
    }

    #[test]
    fn a_graph_lists_its_classes_by_side() {
        let graphs = Graphs {
            first: &[0, 0, 3],
            class_i: &[0, 0, 2],
            class_j: &[1, 2, 2],
            claim: &[0, 0, 0, 1, 2, 3],
            near_first: &[0, 0, 2, 3, 5],
            near: &[1, 2, 0, 0, 2],
            n_sides: 3,
        };
        let graph = graphs.graph(1);
        assert!(graph.classes().eq([(0, 1), (0, 2), (2, 2)]));
        let by_side: Vec<_> = graph.classes_by_side().collect();
        assert_eq!(by_side, [(0, &[1, 2][..]), (2, &[2][..])]);
        assert!(graph.near(2).eq([0, 2]));
        assert_eq!(graphs.graph(0).classes().count(), 0);
    }
}
