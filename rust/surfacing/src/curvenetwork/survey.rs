//! Where drawn curves come near each other, the parts of a meeting at a closed curve's seam once.

use patterndb_geometry::vector::{Point, min};

use crate::curvenetwork::meetings::Edge;

/// A join at a closed curve's seam may be part of a meeting beyond it, within this share of it. NEAR_SEAM
/// of `patterndb_sketch.curvenetwork.survey` is the same.
const NEAR_SEAM: f64 = 0.2;

/// Curves: their points, those of a curve in a row.
#[derive(Clone, Copy, Debug)]
pub struct Curves<'a> {
    /// The points.
    pub points: &'a [Point],
    /// The first point of every curve, and the number of points.
    pub starts: &'a [i64],
    /// The arc length of every point from the beginning of its curve.
    pub along: &'a [f64],
    /// Whether each curve ends where it begins.
    pub closed: &'a [bool],
    /// How near another curve must come to meet it.
    pub reaches: &'a [f64],
}

/// Pairs of places on curves that may be one node.
#[derive(Clone, Copy, Debug)]
pub struct SeamJoins<'a> {
    /// The two curves of every pair.
    pub curves: &'a [[i64; 2]],
    /// The arc lengths of the places along them.
    pub lengths: &'a [[f64; 2]],
    /// How far the places are apart.
    pub gaps: &'a [f64],
    /// How far the places are from the seam.
    pub ways: &'a [[f64; 2]],
    /// Which places may be parted from others by the seam.
    pub beside: &'a [[bool; 2]],
}

/// Joins with a place that may be parted from others by a seam, and those of the same two curves.
#[derive(Clone, Copy, Debug)]
pub struct Candidates<'a> {
    /// The joins.
    pub some: &'a [i64],
    /// All joins, those of the same two curves in a row.
    pub by_pair: &'a [i64],
    /// Where in `by_pair` the joins of the same two curves begin, for each candidate.
    pub begin: &'a [i64],
    /// Where they end.
    pub end: &'a [i64],
}

/// Return which joins are not part of the meeting of a nearer one beyond a closed curve's seam.
pub fn select_seam_joins(curves: Curves, joins: SeamJoins, candidates: Candidates) -> Vec<bool> {
    let mut kept = vec![true; joins.gaps.len()];
    let ranges = candidates.begin.iter().zip(candidates.end);
    for (&one, (&begin, &end)) in candidates.some.iter().zip(ranges) {
        let one = one as usize;
        let others = &candidates.by_pair[begin as usize..end as usize];
        let is_part = others.iter().any(|&other| {
            let other = other as usize;
            other != one
                && kept[other]
                && joins.gaps[other] <= joins.gaps[one]
                && (0..2).any(|side| goes_on(curves, joins, [one, other], side))
        });
        kept[one] = !is_part;
    }
    kept
}

/// Return whether the meeting of a join goes on to another beyond the seam of the curve on a side.
fn goes_on(curves: Curves, joins: SeamJoins, [one, other]: [usize; 2], side: usize) -> bool {
    let [curve, partner] = [side, 1 - side].map(|side| joins.curves[one][side] as usize);
    let whole = curves.length(curve);
    let [way, other_way] = [one, other].map(|join| joins.ways[join][side]);
    if !joins.beside[one][side] || way + other_way > NEAR_SEAM * whole {
        return false;
    }
    let lengths = [one, other].map(|join| joins.lengths[join][side]);
    let late = lengths.map(|length| 2.0 * length > whole);
    if way > 0.0 && (!joins.beside[other][side] || late[0] == late[1]) {
        return false;
    }
    let within = min(curves.reaches[curve], curves.reaches[partner]);
    // The other curve goes the same way there.
    let [at, other_at] = [one, other].map(|join| joins.lengths[join][1 - side]);
    let mut apart = (at - other_at).abs();
    if curves.closed[partner] {
        apart = min(apart, curves.length(partner) - apart);
    }
    apart <= 2.0 * (way + other_way + within)
        && lengths.into_iter().zip(late).all(|(length, late)| {
            let way = if late { whole - length } else { length };
            [0.0, 0.5].into_iter().all(|share| {
                let at = share * way;
                let place = curves.locate(curve, if late { whole - at } else { at });
                curves.is_near(partner, &place, within)
            })
        })
}

impl Curves<'_> {
    /// Return the first and the last point of a curve.
    fn ends(&self, curve: usize) -> (usize, usize) {
        let [first, next] = [curve, curve + 1].map(|curve| self.starts[curve] as usize);
        (first, next - 1)
    }

    fn length(&self, curve: usize) -> f64 {
        self.along[self.ends(curve).1]
    }

    /// Return the place at an arc length of a curve.
    fn locate(&self, curve: usize, length: f64) -> Point {
        let (first, last) = self.ends(curve);
        let before = self.along[first..=last].partition_point(|&along| along <= length);
        let edge = (first + before - 1).min(last - 1);
        let size = self.along[edge + 1] - self.along[edge];
        let share = if size > 0.0 {
            (length - self.along[edge]) / size
        } else {
            0.0
        };
        let (from, to) = (&self.points[edge], &self.points[edge + 1]);
        [0, 1, 2].map(|d| (1.0 - share) * from[d] + share * to[d])
    }

    /// Return whether a place is within reach of a curve.
    fn is_near(&self, curve: usize, place: &Point, within: f64) -> bool {
        let (first, last) = self.ends(curve);
        (first..last).any(|edge| Edge::new(self.points, edge).measure_distance(place) <= within)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 1 that begins in the middle of its lower side, and a line along that side at
    /// a height.
    fn square_and_line(height: f64) -> Vec<Point> {
        [
            [0.5, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 1.0],
            [0.0, 0.0],
            [0.5, 0.0],
            [0.0, height],
            [1.0, height],
        ]
        .map(|[x, y]| [x, y, 0.0])
        .to_vec()
    }

    fn select(points: &[Point], lengths: &[[f64; 2]]) -> Vec<bool> {
        let curves = Curves {
            points,
            starts: &[0, 6, 8],
            along: &[0.0, 0.5, 1.5, 2.5, 3.5, 4.0, 0.0, 1.0],
            closed: &[true, false],
            reaches: &[0.1, 0.1],
        };
        let ways: Vec<[f64; 2]> = lengths
            .iter()
            .map(|[a, b]| [a.min(4.0 - a), b.min(1.0 - b)])
            .collect();
        let joins = SeamJoins {
            curves: &[[0, 1]; 2],
            lengths,
            gaps: &[0.02, 0.01],
            ways: &ways,
            beside: &[[true, false]; 2],
        };
        let candidates = Candidates {
            some: &[0, 1],
            by_pair: &[0, 1],
            begin: &[0, 0],
            end: &[2, 2],
        };
        select_seam_joins(curves, joins, candidates)
    }

    #[test]
    fn of_two_joins_at_a_seam_the_nearer_is_kept() {
        let lengths = [[0.1, 0.6], [3.9, 0.4]];
        assert_eq!(select(&square_and_line(0.01), &lengths), [false, true]);
        // The line is not near between them.
        assert_eq!(select(&square_and_line(0.3), &lengths), [true, true]);
        // Both are on one side of the seam.
        let lengths = [[0.1, 0.6], [0.2, 0.7]];
        assert_eq!(select(&square_and_line(0.01), &lengths), [true, true]);
    }
}
