//! Branch and bound over classes: the K best solutions of one system, without listing them all.
//!
//! A price u_s on the slack of every side turns the key ([`crate::solving::balance`]) into a constant
//! plus one *excess* >= 0 for each class (Lagrangian duality), so that a partial solution is dropped as
//! soon as the excesses of its decided classes exceed what the K-th best leaves. Any prices give a
//! valid bound; those of the continuous problem give a tight one. Prices are integers in units of
//! 1/SCALE: nothing is lost to rounding. The squares of the parts of a polychord bound the
//! polychord's from below, squares being convex, so the same bound holds where strokes divide it.
//!
//! [`search`] is the one search; a [`Guide`] orders the values of a class and bounds what they cost:
//! [`add_best_solutions`] by prices, [`find_first_solution`] largest values first.

use crate::solving::balance::{Best, Chord, Class, Completion, INFINITE, OFF, System, class_cost};
use crate::solving::matching::{is_soluble, tighten_bounds};
use crate::solving::systems::{is_balanced, two_colour};

/// Units of price for each unit of the key; finer prices no longer tighten the bound.
const SCALE: i64 = 64;

/// Rounds of coordinate ascent on the prices. Fewer give a weaker bound, never a wrong one.
const ROUNDS: usize = 60;

/// Dead ends after which a search no longer trusts its cheap bounds and asks, wherever it branches,
/// whether there is a solution at all. Most searches meet none; those that do may meet millions. From
/// then on the time between two solutions is polynomial.
const PATIENCE: usize = 30;

/// More than any slack: what a class with both ends on one side can absorb.
const UNBOUNDED: i32 = 1 << 24;

/// What a search does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Choice {
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
fn choose_class(residual: &[i32], classes: &[Class], closed: &[bool]) -> Choice {
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
struct Parity {
    open: Vec<(usize, usize)>,
    component: Vec<i16>,
    colour: Vec<i16>,
    sums: Vec<i32>,
}

impl Parity {
    /// Make scratch for systems of some number of sides.
    fn new(n_sides: usize) -> Parity {
        Parity {
            open: Vec::new(),
            component: vec![0; n_sides],
            colour: vec![0; n_sides],
            sums: vec![0; n_sides],
        }
    }

    /// Return whether the open classes can absorb the residual, for all that parity shows.
    fn allows(&mut self, residual: &[i32], classes: &[Class], closed: &[bool]) -> bool {
        let open = classes.iter().zip(closed).filter(|(_, closed)| !**closed);
        self.open.clear();
        self.open.extend(open.map(|(class, _)| (class.i, class.j)));
        two_colour(&self.open, &mut self.component, &mut self.colour);
        is_balanced(residual, &self.component, &self.colour, &mut self.sums)
    }
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

/// How a search orders the values of a class, and what it keeps.
trait Guide {
    /// Return the value within bounds that is tried first; those next to it follow, cheapest first.
    fn first_value(&self, class: usize, bounds: [i32; 2]) -> i32;

    /// Return what a value costs beyond the cheapest, 0 or more.
    fn excess(&self, class: usize, value: i32) -> i64;

    /// Return the most that the excesses of all classes may add up to.
    fn budget(&self) -> i64;

    /// Keep a solution; return whether the search is to go on.
    fn keep(&mut self, values: &[i32]) -> bool;
}

/// Search depth-first for the values of classes that give every side its slack, until the guide has
/// enough or `is_cancelled`.
fn search(
    slack: &[i32],
    classes: &[Class],
    guide: &mut impl Guide,
    is_cancelled: &impl Fn() -> bool,
) {
    let mut residual = slack.to_vec();
    let mut closed = vec![false; classes.len()];
    let mut value = vec![0; classes.len()];
    let mut parity = Parity::new(slack.len());
    let mut open = Vec::new();
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
                let others = (0..classes.len()).filter(|&other| other != k && !closed[other]);
                let pair = |k: usize| (classes[k].i, classes[k].j);
                open.clear();
                open.extend(std::iter::once(k).chain(others).map(pair));
                let tightened = tighten_bounds(&residual, &open, bounds);
                choice = tightened.map_or(Choice::Dead, |bounds| Choice::Class(k, bounds));
            }
            let ready = match choice {
                Choice::Done => {
                    dead_ends = 0;
                    if !guide.keep(&value) {
                        return;
                    }
                    continue;
                }
                // Parity is dear to test: only where there is a choice to be spared.
                Choice::Class(k, bounds @ [low, high]) if low < high => parity
                    .allows(&residual, classes, &closed)
                    .then_some((k, bounds)),
                Choice::Class(k, bounds @ [low, high]) => (low == high).then_some((k, bounds)),
                Choice::Dead => None,
            };
            if let Some((class, [low, high])) = ready {
                let left = guide.first_value(class, [low, high]);
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
        let mut excess = INFINITE;
        let mut y = level.left;
        if level.left >= level.low {
            excess = guide.excess(k, y);
        }
        if level.right <= level.high {
            let other = guide.excess(k, level.right);
            if other < excess {
                excess = other;
                y = level.right;
            }
        }
        if excess == INFINITE || level.spent + excess > guide.budget() {
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

/// Cheapest values first, by prices; every solution may be among the best.
struct Cheapest<'a, 'b, F> {
    classes: &'a [Class],
    tolerance: i32,
    prices: Vec<Price>,
    /// What all solutions have in common, in units of 1/SCALE.
    constant: i64,
    completion: Completion<'a>,
    best: &'b mut Best,
    is_cancelled: &'b F,
}

impl<F: Fn() -> bool> Guide for Cheapest<'_, '_, F> {
    fn first_value(&self, class: usize, [low, high]: [i32; 2]) -> i32 {
        self.prices[class].bottom.max(low).min(high)
    }

    fn excess(&self, class: usize, value: i32) -> i64 {
        self.prices[class].excess(&self.classes[class], self.tolerance, value)
    }

    fn budget(&self) -> i64 {
        self.best.limit().map_or(INFINITE, |limit| {
            SCALE * (limit - self.completion.missing) - self.constant
        })
    }

    fn keep(&mut self, values: &[i32]) -> bool {
        self.completion.add(values, self.best, self.is_cancelled);
        true
    }
}

/// Add the solutions of a system to the list of the best.
///
/// `chords` are the polychords, `tag` is the system's. At the end `best` holds the best of all; where
/// fewer than it keeps, all there are. Equal widths with unlike tags are two solutions. Once
/// `is_cancelled`, some are missing.
pub fn add_best_solutions(
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
    let mut guide = Cheapest {
        classes,
        tolerance,
        constant: by_slack + prices.iter().map(|price| price.floor).sum::<i64>(),
        prices,
        completion: Completion::new(system, chords, tolerance, tag),
        best,
        is_cancelled,
    };
    search(slack, classes, &mut guide, is_cancelled);
}

/// Largest values first; the first solution is enough.
#[derive(Default)]
struct Largest {
    found: Option<Vec<i32>>,
}

impl Guide for Largest {
    fn first_value(&self, _: usize, [_, high]: [i32; 2]) -> i32 {
        high
    }

    fn excess(&self, _: usize, _: i32) -> i64 {
        0
    }

    fn budget(&self) -> i64 {
        0
    }

    fn keep(&mut self, values: &[i32]) -> bool {
        self.found = Some(values.to_vec());
        false
    }
}

/// Return values of classes that give every side its slack, those of the first classes as large as can
/// be; None where there are none.
pub fn find_first_solution(slack: &[i32], classes: &[Class]) -> Option<Vec<i32>> {
    if !is_soluble(slack, classes.iter().map(|class| (class.i, class.j))) {
        return None;
    }
    let mut guide = Largest::default();
    search(slack, classes, &mut guide, &|| false);
    guide.found
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

    #[test]
    fn the_first_solution_has_the_largest_values() {
        // Two classes between the same two sides as far as a third allows.
        let classes = [class(0, 1), class(0, 1), class(1, 1)];
        assert_eq!(find_first_solution(&[2, 4], &classes), Some(vec![2, 0, 1]));
        assert_eq!(find_first_solution(&[2, 3], &classes), None);
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
