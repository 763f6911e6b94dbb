//! The most even widths: the K best solutions of one system, without listing them all.
//!
//! The key of a solution is the sum of w_p x_p^2 over the open polychords, where w_p is 1, or, where
//! the boundary has geometry, grows with the squares of the edge lengths at p's two ends. The strands'
//! ends cover the boundary whichever the solution, so among all solutions of one pattern, in any
//! orientation, this sum and the squared deviation from the mean differ by a constant: the smallest
//! sum is the most even solution, in edges or in length, and the key is an exact integer. Strokes come
//! first: every edge by which a strand's end is off its stroke's counts more than all widths together.
//! Ties go to the lexicographically smaller widths, in label order.
//!
//! Branch and bound over classes. A price u_s on the slack of every side turns the key into a constant
//! plus one *excess* >= 0 for each class (Lagrangian duality), so that a partial solution is dropped as
//! soon as the excesses of its decided classes exceed what the K-th best leaves. Any prices give a
//! valid bound; those of the continuous problem give a tight one. Prices are integers in units of
//! 1/SCALE: nothing is lost to rounding.
//!
//! A polychord that strokes divide is several variables to the search, its *parts*. Squares being
//! convex, the parts' own squares bound the polychord's from below, so the same bound holds; whole keys
//! are computed where a solution is complete. Last, [`spread_slack`] splits each class's slack among its
//! polychords, most evenly first.

use crate::solving::halves::{Class, Transport};
use crate::solving::matching::{Choice, PATIENCE, Parity, choose_class};

/// Above every key.
pub const INFINITE: i64 = 1 << 50;

/// Units of price for each unit of the key; finer prices no longer tighten the bound.
const SCALE: i64 = 64;

/// Rounds of coordinate ascent on the prices. Fewer give a weaker bound, never a wrong one.
const ROUNDS: usize = 60;

/// What an edge off a stroke's end counts: more than any sum of squares. Perimeters are at most 2,000,
/// so the squares add up to at most 1,000^2, each times a weight of at most 255.
const OFF: i64 = 1 << 28;

/// A part of a polychord; a polychord that no stroke divides is one part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The class of the part.
    pub class: usize,
    /// The polychord.
    pub chord: usize,
}

/// The system that the parts' widths solve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct System {
    /// How much is left of each node, a piece of a side or a tolerance, when all parts have slack 0.
    pub slack: Vec<i32>,
    /// The classes. Those of a tolerance have n = 0 and follow each other, with the weights 1 and 0.
    pub classes: Vec<Class>,
    /// The parts, polychord after polychord.
    pub parts: Vec<Part>,
}

/// A polychord.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chord {
    /// Its width when its parts have slack 0.
    pub own: i32,
    /// What the square of its width counts.
    pub weight: i32,
}

/// Return the least sum of (1 + s)^2 over `parts` integers s >= 0 that add up to `value`.
pub fn even_cost(parts: i32, value: i32) -> i64 {
    if parts == 0 {
        return 0;
    }
    let (low, more) = (i64::from(value / parts), i64::from(value % parts));
    (i64::from(parts) - more) * (1 + low) * (1 + low) + more * (2 + low) * (2 + low)
}

/// A solution of a system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Solution {
    /// What it is ranked by.
    pub key: i64,
    /// The width of every polychord.
    pub widths: Vec<i32>,
    /// Of which of several systems of the same polychords.
    pub tag: i32,
}

/// The best solutions of some systems of the same polychords, best first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Best {
    /// The solutions.
    pub solutions: Vec<Solution>,
    /// How many there may be.
    pub keep: usize,
}

impl Best {
    /// Return the key that a solution must not exceed to be among the best; None where any is.
    fn limit(&self) -> Option<i64> {
        let last = self
            .solutions
            .last()
            .filter(|_| self.solutions.len() == self.keep);
        last.map(|solution| solution.key)
    }

    /// Insert a solution, unless it is worse than all of a full list.
    ///
    /// `distinct`: no widths come twice; else equal ones stay once, with the smaller key.
    fn insert(&mut self, new: Solution, distinct: bool) {
        let mut at = self.solutions.len();
        let mut equal = None;
        for (i, other) in self.solutions.iter().enumerate().rev() {
            let order = (&new.widths, new.tag).cmp(&(&other.widths, other.tag));
            if order.is_eq() && other.key <= new.key {
                return;
            }
            if (new.key.cmp(&other.key)).then(order).is_lt() {
                at = i;
            } else if distinct {
                break;
            }
            if order.is_eq() {
                equal = Some(i);
            }
        }
        if at == self.keep {
            return;
        }
        if let Some(equal) = equal {
            self.solutions.remove(equal);
        } else if self.solutions.len() == self.keep {
            self.solutions.pop();
        }
        self.solutions.insert(at, new);
    }
}

/// Which widths [`spread_slack`] lists.
#[derive(Clone, Copy)]
pub struct Wanted {
    /// The greatest key.
    pub budget: i64,
    /// Whether only this key is wanted.
    pub exactly: bool,
    /// How many at most.
    pub room: usize,
}

/// List the ways to split each class's value among its parts; return the slack of every part, row
/// after row, and the least key above the budget, or INFINITE.
///
/// In lexicographic order. The bound is met by a real solution, so no branch is in vain. Once
/// `is_cancelled`, the rest is left out.
pub fn spread_slack(
    value: &[i32],
    classes: &[Class],
    parts: &[Part],
    wanted: Wanted,
    is_cancelled: &impl Fn() -> bool,
) -> (Vec<i32>, i64) {
    let n = parts.len();
    let cost = |class: &Class, n: i32, value: i32| i64::from(class.weight) * even_cost(n, value);
    let bound: i64 = classes
        .iter()
        .zip(value)
        .map(|(class, &value)| cost(class, class.n, value))
        .sum();
    if bound > wanted.budget {
        return (Vec::new(), bound);
    }
    let mut left = value.to_vec();
    let mut open: Vec<i32> = classes.iter().map(|class| class.n).collect();
    let mut extra = vec![-1; n];
    let mut bounds = vec![bound; n + 1];
    let mut above = INFINITE;
    let mut rows = Vec::new();
    let mut count = 0;
    let mut c = 0;
    while count < wanted.room && !is_cancelled() {
        if c == n {
            if bounds[n] == wanted.budget || !wanted.exactly {
                rows.extend(&extra);
                count += 1;
            }
        } else {
            let k = parts[c].class;
            let class = &classes[k];
            if extra[c] >= 0 {
                left[k] += extra[c];
                open[k] += 1;
            }
            let before = bounds[c] - cost(class, open[k], left[k]);
            let mut e = extra[c] + 1;
            if open[k] == 1 {
                e = e.max(left[k]);
            }
            let mut chosen = None;
            while e <= left[k] {
                let own = i64::from(1 + e) * i64::from(1 + e);
                let rest = even_cost(open[k] - 1, left[k] - e);
                let bound = before + i64::from(class.weight) * (own + rest);
                if bound <= wanted.budget {
                    chosen = Some(e);
                    bounds[c + 1] = bound;
                    break;
                }
                above = above.min(bound);
                // Beyond the mean every further unit costs more.
                if e * open[k] > left[k] {
                    break;
                }
                e += 1;
            }
            extra[c] = chosen.unwrap_or(-1);
            if let Some(e) = chosen {
                left[k] -= e;
                open[k] -= 1;
                c += 1;
                continue;
            }
        }
        if c == 0 {
            break;
        }
        c -= 1;
    }
    (rows, above)
}

/// Return the widths of all ways to split the slack of classes among their polychords.
///
/// `values` holds rows of the slack of every class, and `class_of` the class of each polychord. The
/// widths of one row are in lexicographic order.
pub fn list_splits(values: &[i32], class_n: &[i32], class_of: &[i32]) -> Vec<i32> {
    let class = |&n: &i32| Class {
        i: 0,
        j: 0,
        n,
        weight: 1,
    };
    let classes: Vec<Class> = class_n.iter().map(class).collect();
    let part = |(chord, &class): (usize, &i32)| Part {
        class: class as usize,
        chord,
    };
    let parts: Vec<Part> = class_of.iter().enumerate().map(part).collect();
    let wanted = Wanted {
        budget: INFINITE,
        exactly: false,
        room: usize::MAX,
    };
    let mut widths = Vec::new();
    for value in values.chunks_exact(classes.len().max(1)) {
        let (extra, _) = spread_slack(value, &classes, &parts, wanted, &|| false);
        widths.extend(extra.iter().map(|extra| 1 + extra));
    }
    widths
}

/// Return the price of one unit of each node's slack, in units of 1/SCALE.
///
/// Coordinate ascent on the dual of: minimise sum w_k n_k (1 + y_k / n_k)^2 over real y >= 0 that meet
/// the slack. At the optimum y_k = n_k max(0, (u_i + u_j) / (2 w_k) - 1); one node's price is the root
/// of an increasing piecewise linear function. A node of tolerance costs nothing: its price is what
/// makes its classes cost least.
fn find_prices(slack: &[i32], classes: &[Class]) -> Vec<i64> {
    /// A class as one of its ends sees it.
    #[derive(Clone, Copy)]
    struct End {
        n: f64,
        weight: f64,
        /// The other end; None where both are one side.
        other: Option<usize>,
    }
    let with_parts = || classes.iter().filter(|class| class.n > 0);
    let ends: Vec<Vec<End>> = (0..slack.len())
        .map(|side| {
            let ends = with_parts().filter_map(|class| {
                Some(End {
                    other: class
                        .across(side)
                        .map(|other| (other != side).then_some(other))?,
                    n: f64::from(class.n),
                    weight: f64::from(class.weight),
                })
            });
            ends.collect()
        })
        .collect();
    let mut u = vec![1.0; slack.len()];
    let mut active = Vec::new();
    for _ in 0..ROUNDS {
        for (side, ends) in ends.iter().enumerate() {
            active.clear();
            active.extend_from_slice(ends);
            let mut root = u[side];
            // The root over the active classes; those that would turn negative leave.
            loop {
                let (mut slope, mut level) = (0.0, f64::from(slack[side]));
                for &End { n, weight, other } in &active {
                    if let Some(other) = other {
                        slope += 0.5 * n / weight;
                        level += n * (1.0 - 0.5 * u[other] / weight);
                    } else {
                        slope += 2.0 * n / weight;
                        level += 2.0 * n;
                    }
                }
                if slope == 0.0 {
                    break;
                }
                root = level / slope;
                let before = active.len();
                active.retain(|&End { weight, other, .. }| {
                    let starts = other.map_or(weight, |other| 2.0 * weight - u[other]);
                    starts <= root
                });
                if active.len() == before {
                    break;
                }
            }
            u[side] = root;
        }
    }
    // The two classes of a tolerance follow each other: half the sum of the pieces' prices.
    let of_tolerance = || classes.iter().filter(|class| class.n == 0);
    of_tolerance().for_each(|class| u[class.j] = 0.0);
    for class in of_tolerance() {
        u[class.j] -= 0.5 * u[class.i];
    }
    u.into_iter()
        .map(|u| (u * SCALE as f64).round_ties_even() as i64)
        .collect()
}

/// Return the least key that a class of a value adds.
///
/// Of a tolerance's two classes the first counts by how much it differs from the tolerance, and the
/// other, of weight 0, nothing.
fn class_cost(class: &Class, tolerance: i32, value: i32) -> i64 {
    let weight = i64::from(class.weight);
    if class.n == 0 {
        OFF * weight * i64::from((value - tolerance).abs())
    } else {
        weight * even_cost(class.n, value)
    }
}

/// The prices of classes: the excess of a class at y is SCALE * cost(y) - price * y - floor.
struct Price {
    price: i64,
    /// The value whose excess is 0.
    bottom: i32,
    floor: i64,
}

impl Price {
    fn new(class: &Class, tolerance: i32, u: &[i64]) -> Price {
        let price = u[class.i] + u[class.j];
        let bottom = if class.n > 0 {
            // Widening all from 1 + q to 2 + q pays off while weight * (2 q + 3) <= price.
            let step = price.div_euclid(SCALE * i64::from(class.weight));
            let q = (step - 3).div_euclid(2) + 1;
            q.max(0) as i32 * class.n
        } else if class.weight > 0 && price.abs() <= SCALE * OFF {
            tolerance
        } else if price > 0 {
            2 * tolerance
        } else {
            0
        };
        let cost = SCALE * class_cost(class, tolerance, bottom);
        Price {
            price,
            bottom,
            floor: cost - price * i64::from(bottom),
        }
    }

    fn excess(&self, class: &Class, tolerance: i32, y: i32) -> i64 {
        SCALE * class_cost(class, tolerance, y) - self.price * i64::from(y) - self.floor
    }
}

/// A decided class of a search, and its untried values: low..=left and right..=high.
struct Level {
    class: usize,
    low: i32,
    left: i32,
    right: i32,
    high: i32,
    /// The excesses of the classes decided before.
    spent: i64,
}

/// Add the solutions of a system to the list of the best.
///
/// `chords` are the polychords, `tag` is the system's. At the end `best` holds the best of all; where
/// fewer than it keeps, all there are. Equal widths with unlike tags are two solutions. Once
/// `is_cancelled`, some are missing.
pub fn add_most_even(
    system: &System,
    chords: &[Chord],
    tolerance: i32,
    tag: i32,
    best: &mut Best,
    is_cancelled: &impl Fn() -> bool,
) {
    let System { slack, classes, .. } = system;
    let u = find_prices(slack, classes);
    let prices: Vec<Price> = classes
        .iter()
        .map(|class| Price::new(class, tolerance, &u))
        .collect();
    let by_slack: i64 = u
        .iter()
        .zip(slack)
        .map(|(u, &slack)| u * i64::from(slack))
        .sum();
    let constant = by_slack + prices.iter().map(|price| price.floor).sum::<i64>();
    let mut completion = Completion::new(system, chords, tolerance, tag);
    let mut residual = slack.clone();
    let mut closed = vec![false; classes.len()];
    let mut value = vec![0; classes.len()];
    let mut parity = Parity::new(slack.len());
    let mut transport = Transport::default();
    let mut levels: Vec<Level> = Vec::new();
    // The excesses of all decided classes.
    let mut spent = 0;
    let mut dead_ends = 0;
    let mut down = true;
    while !is_cancelled() {
        if down {
            down = false;
            let mut choice = choose_class(&residual, classes, &closed);
            if let Choice::Class(k, bounds) = choice
                && dead_ends > PATIENCE
                && bounds[0] < bounds[1]
            {
                let tightened =
                    transport.tighten_bounds(&mut residual, classes, &mut closed, k, bounds);
                choice = tightened.map_or(Choice::Dead, |bounds| Choice::Class(k, bounds));
            }
            let ready = match choice {
                Choice::Done => {
                    dead_ends = 0;
                    completion.add(&value, best, is_cancelled);
                    continue;
                }
                Choice::Class(k, [low, high]) if low < high => parity
                    .allows(&residual, classes, &closed)
                    .then_some((k, low, high)),
                Choice::Class(k, [low, high]) => (low == high).then_some((k, low, high)),
                Choice::Dead => None,
            };
            if let Some((class, low, high)) = ready {
                let left = prices[class].bottom.max(low).min(high);
                levels.push(Level {
                    class,
                    low,
                    left,
                    right: left + 1,
                    high,
                    spent,
                });
                closed[class] = true;
            } else {
                dead_ends += 1;
            }
            continue;
        }
        let Some(level) = levels.last_mut() else {
            break;
        };
        let k = level.class;
        let class = &classes[k];
        residual[class.i] += value[k];
        residual[class.j] += value[k];
        value[k] = 0;
        let budget = best.limit().map_or(INFINITE, |limit| {
            SCALE * (limit - completion.missing) - constant
        });
        let mut excess = INFINITE;
        let mut y = level.left;
        if level.left >= level.low {
            excess = prices[k].excess(class, tolerance, y);
        }
        if level.right <= level.high {
            let other = prices[k].excess(class, tolerance, level.right);
            if other < excess {
                excess = other;
                y = level.right;
            }
        }
        if excess == INFINITE || level.spent + excess > budget {
            closed[k] = false;
            levels.pop();
            continue;
        }
        if y == level.left {
            level.left -= 1;
        } else {
            level.right += 1;
        }
        spent = level.spent + excess;
        value[k] = y;
        residual[class.i] -= y;
        residual[class.j] -= y;
        down = true;
    }
}

/// Makes solutions of the values of all classes.
struct Completion<'a> {
    system: &'a System,
    chords: &'a [Chord],
    tolerance: i32,
    tag: i32,
    /// Whether strokes divide polychords.
    divided: bool,
    /// What the parts' own squares leave out of a key at least.
    missing: i64,
    /// Splits that are listed at a time.
    room: usize,
}

impl<'a> Completion<'a> {
    fn new(system: &'a System, chords: &'a [Chord], tolerance: i32, tag: i32) -> Completion<'a> {
        let of_part = |part: &Part| i64::from(system.classes[part.class].weight);
        let of_chord = |chord: &Chord| {
            let own = i64::from(chord.own);
            i64::from(chord.weight) * own * own
        };
        let of_parts: i64 = system.parts.iter().map(of_part).sum();
        Completion {
            system,
            chords,
            tolerance,
            tag,
            divided: system.parts.len() > chords.len(),
            missing: chords.iter().map(of_chord).sum::<i64>() - of_parts,
            room: 0,
        }
    }

    /// Add the solutions that split the values of the classes among their parts.
    fn add(&mut self, value: &[i32], best: &mut Best, is_cancelled: &impl Fn() -> bool) {
        let System { classes, parts, .. } = self.system;
        let (mut off, mut parts_key) = (0, 0);
        for (class, &value) in classes.iter().zip(value) {
            let cost = class_cost(class, self.tolerance, value);
            *(if class.n == 0 {
                &mut off
            } else {
                &mut parts_key
            }) += cost;
        }
        self.room = self.room.max(best.keep);
        let mut got = 0;
        while (self.divided || got < best.keep) && parts_key < INFINITE && !is_cancelled() {
            if best
                .limit()
                .is_some_and(|limit| off + parts_key + self.missing > limit)
            {
                break;
            }
            let room = if self.divided {
                self.room
            } else {
                best.keep - got
            };
            let wanted = Wanted {
                budget: parts_key,
                exactly: true,
                room,
            };
            let (rows, above) = spread_slack(value, classes, parts, wanted, is_cancelled);
            let found = rows.len() / parts.len().max(1);
            if self.divided && found == room {
                // Unlike keys may hide among equal ones of the parts: take them all.
                self.room *= 4;
                continue;
            }
            for extra in rows.chunks_exact(parts.len().max(1)) {
                self.insert(off, extra, best);
            }
            got += found;
            parts_key = above;
        }
    }

    /// Insert the solution in which the parts have some slack.
    fn insert(&self, off: i64, extra: &[i32], best: &mut Best) {
        let mut widths: Vec<i32> = self.chords.iter().map(|chord| chord.own).collect();
        for (part, extra) in self.system.parts.iter().zip(extra) {
            widths[part.chord] += extra;
        }
        let square = |(width, chord): (&i32, &Chord)| {
            let width = i64::from(*width);
            i64::from(chord.weight) * width * width
        };
        let key = off + widths.iter().zip(self.chords).map(square).sum::<i64>();
        if best.limit().is_none_or(|limit| key <= limit) {
            let tag = self.tag;
            best.insert(Solution { key, widths, tag }, !self.divided);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slack_is_spread_evenly_first() {
        assert_eq!(even_cost(3, 4), 4 + 4 + 9);
        assert_eq!(even_cost(0, 4), 0);
        let classes = [Class {
            i: 0,
            j: 1,
            n: 2,
            weight: 1,
        }];
        let parts = [0, 1].map(|chord| Part { class: 0, chord });
        let spread = |budget, room| {
            let wanted = Wanted {
                budget,
                exactly: true,
                room,
            };
            spread_slack(&[3], &classes, &parts, wanted, &|| false)
        };
        assert_eq!(spread(13, 9), (vec![1, 2, 2, 1], 17));
        assert_eq!(spread(13, 1).0, [1, 2]);
        assert_eq!(spread(17, 9), (vec![0, 3, 3, 0], INFINITE));
        assert_eq!(spread(12, 9), (vec![], 13));
    }

    #[test]
    fn every_row_is_split() {
        assert_eq!(list_splits(&[1, 0], &[2], &[0, 0]), [1, 2, 2, 1, 1, 1]);
    }

    #[test]
    fn the_best_are_kept_in_order() {
        let mut best = Best {
            keep: 2,
            ..Best::default()
        };
        for (key, width) in [(5, 1), (3, 2), (4, 3), (3, 1)] {
            let solution = Solution {
                key,
                widths: vec![width],
                tag: 0,
            };
            best.insert(solution, true);
        }
        let kept: Vec<_> = best
            .solutions
            .iter()
            .map(|s| (s.key, s.widths[0]))
            .collect();
        assert_eq!(kept, [(3, 1), (3, 2)]);
    }
}
