//! Prolong: cuts that take a reflex corner away.
//!
//! A side that ends at a reflex corner is prolonged through it by a chord to an inner vertex of
//! another side. The corner becomes convex in the one part and flat in the other, the chord's far end
//! convex in both: the cut itself costs no irregular vertex.

/// Sides between a reflex corner and the far end of its chord, counted the shorter way round.
const REACH: usize = 8;

/// Reflex corners from which cuts are tried; where there are more, the first ones. Python has the same
/// number.
const MOST_REFLEX: usize = 8;

/// Lengths of a chord, and places along a side, that are tried one by one; where there are more, they
/// are tried in larger steps, and those that make two sides equal.
const MOST_STEPS: i64 = 24;

/// A side of an outline and the corner at which it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Side {
    length: i64,
    /// Quads at the corner.
    count: i64,
}

/// A chord from a reflex corner, with a guess of the irregular vertices of its best fill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prolongation {
    /// The corner: it is where side `corner` begins.
    pub corner: usize,
    /// Whether side `corner` is prolonged, else the one before it.
    pub back: bool,
    /// The chord ends on side `corner + far`.
    pub far: usize,
    /// Edges of that side before the chord's end.
    pub place: i64,
    /// Edges of the chord.
    pub length: i64,
    /// Irregular vertices of both parts, roughly.
    pub guess: f64,
}

/// Return the best cut between each reflex corner and each side, prolonging the one side or the other.
///
/// `lengths` and `counts` are the edges of the sides and the quads at the corners of an outline. No
/// part is longer than `most_perimeter`.
pub fn list_prolongations(
    lengths: &[i64],
    counts: &[i64],
    most_perimeter: i64,
) -> Vec<Prolongation> {
    let n = lengths.len();
    let mut found = Vec::new();
    let reflex = (0..n).filter(|&k| counts[k] != 1).take(MOST_REFLEX);
    for corner in reflex {
        let sides: Vec<Side> = (0..n)
            .map(|i| Side {
                length: lengths[(corner + i) % n],
                count: counts[(corner + i) % n],
            })
            .collect();
        for back in [false, true] {
            // The part in which the corner is flat has to keep a second side, to be an outline.
            let reachable = if back { 1..n } else { 0..n.saturating_sub(1) };
            for far in reachable.filter(|&far| far.min(n - 1 - far) <= REACH) {
                let cut = Cut {
                    corner,
                    sides: &sides,
                    back,
                    far,
                };
                found.extend(cut.find_best(lengths, most_perimeter));
            }
        }
    }
    found
}

/// Cuts between a corner and a side.
struct Cut<'a> {
    corner: usize,
    /// The sides from the corner on.
    sides: &'a [Side],
    back: bool,
    far: usize,
}

impl Cut<'_> {
    /// Return the cut with the smallest guess, if any. `lengths` are those of the outline.
    fn find_best(&self, lengths: &[i64], most_perimeter: i64) -> Option<Prolongation> {
        let whole: i64 = lengths.iter().sum();
        let side = self.sides[self.far].length;
        let inner: i64 = self.sides[..self.far].iter().map(|side| side.length).sum();
        let mut best: Option<Prolongation> = None;
        for place in list_steps(1, side - 1, lengths) {
            let arc = inner + place;
            let rest = whole - arc;
            let longest = arc.min(rest).min(most_perimeter - arc.max(rest));
            let [left, right] = self.split(place);
            for length in list_steps(2, longest, lengths) {
                if (arc + length) % 2 != 0 {
                    continue;
                }
                let [mut left, mut right] = [left.clone(), right.clone()];
                if self.back {
                    // Side `corner` continues into the chord.
                    left[0].length += length;
                    right.push(Side { length, count: 1 });
                } else {
                    left.push(Side { length, count: 1 });
                    let last = right.len() - 1;
                    right[last].length += length;
                }
                let mut guess = guess_irregular(&left);
                guess += guess_irregular(&right);
                // Among equals the shortest chord, and the longest of the parts' sides.
                let share = place.min(side - place) as f64;
                guess += 1e-3 * length as f64 / (arc + length) as f64 - 1e-3 * share / whole as f64;
                if guess < best.map_or(f64::INFINITY, |best| best.guess) {
                    best = Some(Prolongation {
                        corner: self.corner,
                        back: self.back,
                        far: self.far,
                        place,
                        length,
                        guess,
                    });
                }
            }
        }
        best
    }

    /// Return the sides of both parts without the chord.
    fn split(&self, place: i64) -> [Vec<Side>; 2] {
        let mut left = self.sides[..=self.far].to_vec();
        let mut right = self.sides[self.far..].to_vec();
        left[self.far].length = place;
        left[0].count = 1;
        right[0].length -= place;
        right[0].count = 1;
        [left, right]
    }
}

/// Return the whole numbers `low..=high`, or a selection of them.
fn list_steps(low: i64, high: i64, lengths: &[i64]) -> Vec<i64> {
    let step = (high - low).div_euclid(MOST_STEPS).max(1);
    let mut steps: Vec<i64> = (low..=high).step_by(step as usize).collect();
    if step > 1 {
        let others = lengths.iter().copied();
        steps.extend(
            others.filter(|length| (low..=high).contains(length) && (length - low) % step != 0),
        );
    }
    steps
}

/// Return roughly how many irregular vertices the best fill of an outline has.
///
/// Exact for convex outlines of 3 to 5 sides that have a fill with the fewest; else the mean of what
/// the complete family of patterns with at most 4 needs.
fn guess_irregular(sides: &[Side]) -> f64 {
    let n = sides.len();
    let mut total = 0;
    let mut longest = 0;
    let mut pair = 0;
    let mut n_reflex = 0;
    let mut n_unit = 0;
    for (i, side) in sides.iter().enumerate() {
        total += side.length;
        longest = longest.max(side.length);
        pair = pair.max(side.length + sides[if i + 1 < n { i + 1 } else { 0 }].length);
        n_reflex += i64::from(side.count != 1);
        n_unit += i64::from(side.length == 1);
    }
    if n < 2 || total < 4 {
        return f64::INFINITY;
    }
    let is_long = 2 * longest >= total;
    let mut value = match n {
        _ if n_reflex > 0 => (n as i64 - 2 * n_reflex - 4).abs() as f64 + 1.5 * n_reflex as f64,
        2 => return 2.0,
        3 => return if !is_long && n_unit == 0 { 1.0 } else { 3.0 },
        4 if sides[0].length == sides[2].length && sides[1].length == sides[3].length => {
            return 0.0;
        }
        5 if 2 * pair < total => return 1.0,
        4 | 5 => 2.0,
        6 => 2.2,
        7 => 2.4,
        _ => (n as i64 - 5) as f64,
    };
    if is_long {
        value += 1.5;
    }
    value + 0.3 * n_unit as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ell_is_cut_into_two_rectangles() {
        // Sides 4, 4, 2, 2, 2, 2; the corner before side 4 is reflex.
        let cuts = list_prolongations(&[4, 4, 2, 2, 2, 2], &[1, 1, 1, 1, 3, 1], 100);
        let best = cuts.iter().min_by(|a, b| a.guess.total_cmp(&b.guess));
        let best = best.expect("there is a cut");
        assert_eq!((best.corner, best.length, best.place), (4, 2, 2));
        assert!(best.guess < 0.01);
    }

    #[test]
    fn long_ranges_are_tried_in_steps_and_at_equal_sides() {
        assert_eq!(list_steps(2, 1, &[]), []);
        assert_eq!(list_steps(1, 4, &[3]), [1, 2, 3, 4]);
        let steps = list_steps(1, 100, &[5, 6, 200]);
        assert_eq!(steps[..3], [1, 5, 9]);
        assert_eq!(steps[steps.len() - 1], 6);
    }
}
