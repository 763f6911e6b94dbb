//! The Hall conditions of systems: several sides can be no wider together than their neighbours, which
//! rejects systems without a flow.
//!
//! Sides of which no two are joined, and none to itself, can be no wider together than all sides
//! that any of them is joined to:
//!
//! ```text
//! sum of need_i over a set S <= sum of need_j over its neighbours N(S)
//! ```
//!
//! where need is by how much a length exceeds the base length. A single side's condition is the
//! sieve's ([`crate::solving::sieve`]); those of all sets together say exactly whether a fractional matching
//! would do, as the flow of [`crate::solving::fractional_matching`] does: a set that breaks its condition is a cut. Of a
//! graph of 12 sides there are some 50 sets that no others imply. Those likeliest to be broken are
//! listed for each graph, and reject nine in ten of the systems that the flow would, at a twentieth of
//! its price. A system that meets them all may still have no solution.
//!
//! A condition is one number, the set's bits below those of its neighbours. Sums over sets are looked
//! up: for every five sides the 32 sums of needs.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Sides of the largest graphs with conditions: a set and its neighbours are 30 bits of a number.
pub const MOST_SIDES: usize = 15;

/// Conditions of a graph: of what all, some 48 of 12 sides, would reject 24 reject 90 %, 32 reject 93 %
/// (2,489 systems that passed the sieve); a line of the processor's cache holds 16.
const MOST_CONDITIONS: usize = 32;

/// Sets of a graph that are looked at, smallest first: beyond some 12 sides not all.
const MOST_SETS: usize = 512;

/// Sides whose sums stand in one table.
const TABLE_SIDES: usize = 5;

/// Sums in each table.
const SUMS: usize = 1 << TABLE_SIDES;

/// The Hall conditions of the graphs of many systems.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HallConditions {
    /// The number of each system's graph; systems of equal graphs have one.
    pub graph: Vec<i32>,
    /// Where the conditions of each graph begin, and where those of the last end.
    pub first: Vec<i32>,
    /// The conditions.
    pub conditions: Vec<i32>,
}

/// List the Hall conditions of graphs of `n_sides` sides, given by the claim of each side.
///
/// `near_first` and `near` are the sides of the claims, see [`crate::solving::systems::Graphs`].
pub fn list_hall_conditions(
    claim: &[i32],
    n_sides: usize,
    near_first: &[i32],
    near: &[i16],
) -> HallConditions {
    let mut made = HallConditions {
        first: vec![0],
        ..HallConditions::default()
    };
    let mut numbers = HashMap::new();
    let mut seen = vec![false; 1 << n_sides];
    for claim in claim.chunks_exact(n_sides) {
        let number = match numbers.entry(claim) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(place) => {
                let joined: Vec<i32> = claim
                    .iter()
                    .map(|&q| {
                        let sides =
                            near_first[q as usize] as usize..near_first[q as usize + 1] as usize;
                        near[sides].iter().fold(0, |set, side| set | 1 << side)
                    })
                    .collect();
                made.conditions.extend(list_of_graph(&joined, &mut seen));
                made.first.push(made.conditions.len() as i32);
                *place.insert(made.first.len() as i32 - 2)
            }
        };
        made.graph.push(number);
    }
    made
}

/// Return the conditions of one graph, those likeliest to be broken first.
///
/// `joined` has the sides that each side is joined to, as bits, each of two sides the other. `seen` has
/// a place for each set, false before and after.
fn list_of_graph(joined: &[i32], seen: &mut [bool]) -> Vec<i32> {
    // The sides that are not joined to themselves.
    let apart = (0..joined.len()).filter(|&i| joined[i] >> i & 1 == 0);
    let apart = apart.fold(0, |sides, i| sides | 1 << i);
    // Sets of sides, and their neighbours.
    let mut sets: Vec<(i32, i32)> = sides_of(apart).map(|i| (1 << i, joined[i])).collect();
    sets.iter().for_each(|&(set, _)| seen[set as usize] = true);
    // Conditions and how likely each is to be broken: the lower the likelier.
    let mut found: Vec<(f64, i32)> = Vec::new();
    let mut head = 0;
    while let Some(&(some, around)) = sets.get(head) {
        head += 1;
        // Sides that add no neighbour make the condition stronger; without them it is implied.
        let mut whole = true;
        for v in sides_of(apart & !(some | around)) {
            let own = joined[v];
            whole &= own & !around != 0;
            let more = some | 1 << v;
            // Two sets whose neighbours are apart imply the condition of both.
            if own & around != 0 && sets.len() < MOST_SETS && !seen[more as usize] {
                seen[more as usize] = true;
                sets.push((more, around | own));
            }
        }
        let (n_some, n_around) = (some.count_ones() as i32, around.count_ones() as i32);
        if !whole || n_some < 2 {
            continue;
        }
        // Needs are alike, so that sums grow with numbers, and scatter with their roots.
        let margin = f64::from(n_around - n_some) / f64::from(n_around + n_some).sqrt();
        let at = found.partition_point(|&(other, _)| other <= margin);
        if at < MOST_CONDITIONS {
            found.truncate(MOST_CONDITIONS - 1);
            found.insert(at, (margin, around << MOST_SIDES | some));
        }
    }
    for (set, _) in sets {
        seen[set as usize] = false;
    }
    found.into_iter().map(|(_, condition)| condition).collect()
}

/// Return the sides of a set, ascending.
fn sides_of(mut set: i32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let side = (set != 0).then(|| set.trailing_zeros() as usize);
        set &= set.wrapping_sub(1);
        side
    })
}

/// The sums of needs over all sets of the first, second and third five sides.
#[derive(Clone, Debug, Default)]
pub struct Sums([[i32; SUMS]; MOST_SIDES / TABLE_SIDES]);

impl Sums {
    /// Take sums that [`Sums::items`] returned.
    pub fn from_items(items: &[i32]) -> Sums {
        let mut sums = Sums::default();
        sums.0.as_flattened_mut().copy_from_slice(items);
        sums
    }

    /// Return the sums, one five after the other.
    pub fn items(&self) -> &[i32] {
        self.0.as_flattened()
    }

    /// Sum the needs of sets of five sides, for every five.
    #[inline(always)]
    pub fn fill(&mut self, need: &[i32; MOST_SIDES]) {
        for (sums, need) in self.0.iter_mut().zip(need.as_chunks::<TABLE_SIDES>().0) {
            for (side, need) in need.iter().enumerate() {
                let (lower, higher) = sums.split_at_mut(1 << side);
                for (sum, lower) in higher.iter_mut().zip(lower) {
                    *sum = *lower + need;
                }
            }
        }
    }

    #[inline(always)]
    fn of(&self, set: i32) -> i32 {
        let [low, middle, high] = &self.0;
        let part = |k: i32| (set >> (k * TABLE_SIDES as i32)) as usize % SUMS;
        low[part(0)] + middle[part(1)] + high[part(2)]
    }

    /// Return whether one of some conditions is broken.
    #[inline(always)]
    pub fn break_any(&self, conditions: &[i32]) -> bool {
        conditions
            .iter()
            .any(|&some| self.of(some >> MOST_SIDES) < self.of(some))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sides 0 and 1 are both joined to side 2 alone.
    const JOINED: [i32; 3] = [0b100, 0b100, 0b011];

    #[test]
    fn two_sides_with_one_neighbour_have_a_condition() {
        let mut seen = vec![false; 8];
        let conditions = list_of_graph(&JOINED, &mut seen);
        assert_eq!(conditions, [0b100 << MOST_SIDES | 0b011]);
        assert!(seen.into_iter().all(|seen| !seen));
        let mut need = [0; MOST_SIDES];
        let mut sums = Sums::default();
        for (last, broken) in [(3, false), (2, true)] {
            need[..3].copy_from_slice(&[1, 2, last]);
            sums.fill(&need);
            assert_eq!(sums.break_any(&conditions), broken);
        }
    }

    #[test]
    fn equal_graphs_have_one_number() {
        let (near_first, near) = ([0, 1, 2, 4], [2, 2, 0, 1]);
        let made = list_hall_conditions(&[0, 1, 2, 0, 1, 2], 3, &near_first, &near);
        assert_eq!(made.graph, [0, 0]);
        assert_eq!(made.first, [0, 1]);
    }
}
