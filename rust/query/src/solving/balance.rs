//! Balance: how even widths are, and the best solutions of a system.
//!
//! The key of a solution is the sum of w_p x_p^2 over the open polychords, where w_p is 1, or, where
//! the boundary has geometry, grows with the squares of the edge lengths at p's two ends. The strands'
//! ends cover the boundary whichever the solution, so among all solutions of one pattern, in any
//! orientation, this sum and the squared deviation from the mean differ by a constant: the smallest
//! sum is the most even solution, in edges or in length, and the key is an exact integer. Strokes come
//! first: every edge by which a strand's end is off its stroke's counts more than all widths together.
//! Ties go to the lexicographically smaller widths, in label order.
//!
//! A solution is found class by class ([`crate::solving::branch_and_bound`]); [`distribute_widths`]
//! splits each class's slack among its polychords, most evenly first. A polychord that strokes divide
//! is several variables, its *parts*: whole keys are computed where a solution is complete.

/// Above every key.
pub const INFINITE: i64 = 1 << 50;

/// What an edge off a stroke's end counts: more than any sum of squares. Perimeters are at most 2,000,
/// so the squares add up to at most 1,000^2, each times a weight of at most 255.
pub const OFF: i64 = 1 << 28;

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

/// Return the least key that a class of a value adds.
///
/// Of a tolerance's two classes the first counts by how much it differs from the tolerance, and the
/// other, of weight 0, nothing.
pub fn class_cost(class: &Class, tolerance: i32, value: i32) -> i64 {
    let weight = i64::from(class.weight);
    if class.n == 0 {
        OFF * weight * i64::from((value - tolerance).abs())
    } else {
        weight * even_cost(class.n, value)
    }
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
    pub fn limit(&self) -> Option<i64> {
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

/// Which widths [`distribute_widths`] lists.
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
pub fn distribute_widths(
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

/// Makes solutions of the values of all classes.
#[derive(Debug)]
pub struct Completion<'a> {
    system: &'a System,
    chords: &'a [Chord],
    tolerance: i32,
    tag: i32,
    /// Whether strokes divide polychords.
    divided: bool,
    /// What the parts' own squares leave out of a key at least.
    pub missing: i64,
    /// Splits that are listed at a time.
    room: usize,
}

impl<'a> Completion<'a> {
    /// Make the solutions of a system; `tag` is the system's.
    pub fn new(
        system: &'a System,
        chords: &'a [Chord],
        tolerance: i32,
        tag: i32,
    ) -> Completion<'a> {
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
    pub fn add(&mut self, value: &[i32], best: &mut Best, is_cancelled: &impl Fn() -> bool) {
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
            let (rows, above) = distribute_widths(value, classes, parts, wanted, is_cancelled);
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
        let least = |value: i32| {
            let ways =
                (0..=value).flat_map(|a| (0..=value - a).map(move |b| [a, b, value - a - b]));
            ways.map(|way| way.map(|s| i64::from((1 + s) * (1 + s))).iter().sum())
                .min()
        };
        for value in 0..9 {
            assert_eq!(Some(even_cost(3, value)), least(value));
        }
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
            distribute_widths(&[3], &classes, &parts, wanted, &|| false)
        };
        assert_eq!(spread(13, 9), (vec![1, 2, 2, 1], 17));
        assert_eq!(spread(13, 1).0, [1, 2]);
        assert_eq!(spread(17, 9), (vec![0, 3, 3, 0], INFINITE));
        assert_eq!(spread(12, 9), (vec![], 13));
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
