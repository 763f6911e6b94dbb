//! Reflex cuts: chords that take a reflex corner away.
//!
//! A side that ends at a reflex corner is prolonged through it by a chord to an inner vertex of
//! another side. The corner becomes convex in the one part and flat in the other, the chord's far end
//! convex in both: the cut itself costs no irregular vertex.

/// Sides between a reflex corner and the far end of its chord, counted the shorter way round.
const REACH: usize = 8;

/// Reflex corners from which cuts are tried; where there are more, the first ones.
const MOST_REFLEX: usize = 8;

/// Lengths of a chord, and places along a side, that are tried one by one; where there are more, they
/// are tried in larger steps, and those that make two sides equal.
const MOST_STEPS: i64 = 24;

/// One side of a cut, of whose sides one varies with the chord.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Part {
    lengths: Vec<i64>,
    /// Corners that are not convex.
    n_reflex: i64,
    /// The side that varies.
    varying: usize,
    /// Edges of the other sides.
    total: i64,
    /// Edges of the longest of them.
    longest: i64,
    /// How many of them have one edge.
    n_unit: i64,
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
        let turned = |items: &[i64]| [&items[corner..], &items[..corner]].concat();
        let (from_corner, counts) = (turned(lengths), turned(counts));
        for back in [false, true] {
            // The part in which the corner is flat has to keep a second side, to be an outline.
            let reachable = if back { 1..n } else { 0..n.saturating_sub(1) };
            for far in reachable.filter(|&far| far.min(n - 1 - far) <= REACH) {
                let cut = Cut {
                    corner,
                    lengths: &from_corner,
                    counts: &counts,
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
    /// Edges of the sides from the corner on.
    lengths: &'a [i64],
    /// Quads at the corners from this one on.
    counts: &'a [i64],
    back: bool,
    far: usize,
}

impl Cut<'_> {
    /// Return the cut with the smallest guess, if any.
    ///
    /// `lengths` are those that are tried in any case, in their order.
    fn find_best(&self, lengths: &[i64], most_perimeter: i64) -> Option<Prolongation> {
        let whole: i64 = self.lengths.iter().sum();
        let side = self.lengths[self.far];
        let inner: i64 = self.lengths[..self.far].iter().sum();
        let mut best: Option<Prolongation> = None;
        for place in list_steps(1, side - 1, lengths) {
            let arc = inner + place;
            let rest = whole - arc;
            let longest = arc.min(rest).min(most_perimeter - arc.max(rest));
            let [mut flat, mut chord] = self.split(place);
            let flat_length = flat.lengths[flat.varying];
            for length in list_steps(2, longest, lengths) {
                if (arc + length) % 2 != 0 {
                    continue;
                }
                let mut guess = flat.guess_irregular(flat_length + length);
                guess += chord.guess_irregular(length);
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

    /// Return the part in which a side continues into the chord, and the part in which the chord is
    /// a side.
    fn split(&self, place: i64) -> [Part; 2] {
        let n_reflex = |counts: &[i64]| counts.iter().filter(|&&count| count != 1).count() as i64;
        let mut left = self.lengths[..=self.far].to_vec();
        let mut right = self.lengths[self.far..].to_vec();
        left[self.far] = place;
        right[0] -= place;
        // The first corner of either part is convex.
        let n_left = n_reflex(&self.counts[1..=self.far]);
        let n_right = n_reflex(&self.counts[self.far + 1..]);
        if self.back {
            right.push(0);
            let chord = right.len() - 1;
            [Part::new(left, n_left, 0), Part::new(right, n_right, chord)]
        } else {
            left.push(0);
            let (chord, last) = (left.len() - 1, right.len() - 1);
            [
                Part::new(right, n_right, last),
                Part::new(left, n_left, chord),
            ]
        }
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

impl Part {
    fn new(lengths: Vec<i64>, n_reflex: i64, varying: usize) -> Part {
        let others = || lengths[..varying].iter().chain(&lengths[varying + 1..]);
        Part {
            n_reflex,
            varying,
            total: others().sum(),
            longest: others().copied().fold(0, i64::max),
            n_unit: others().filter(|&&length| length == 1).count() as i64,
            lengths,
        }
    }

    /// Return roughly how many irregular vertices the best fill has, where the side that varies has
    /// this length.
    ///
    /// Exact for convex outlines of 3 to 5 sides that have a fill with the fewest; else the mean of
    /// what the complete family of patterns with at most 4 needs.
    fn guess_irregular(&mut self, length: i64) -> f64 {
        self.lengths[self.varying] = length;
        let (sides, n_reflex) = (&self.lengths[..], self.n_reflex);
        let n = sides.len();
        let total = self.total + length;
        let longest = self.longest.max(length);
        let n_unit = self.n_unit + i64::from(length == 1);
        if n < 2 || total < 4 {
            return f64::INFINITY;
        }
        let is_long = 2 * longest >= total;
        let mut value = match n {
            _ if n_reflex > 0 => (n as i64 - 2 * n_reflex - 4).abs() as f64 + 1.5 * n_reflex as f64,
            2 => return 2.0,
            3 => return if !is_long && n_unit == 0 { 1.0 } else { 3.0 },
            4 if sides[0] == sides[2] && sides[1] == sides[3] => {
                return 0.0;
            }
            5 if (0..5).all(|i| 2 * (sides[i] + sides[(i + 1) % 5]) < total) => return 1.0,
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
