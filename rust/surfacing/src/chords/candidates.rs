//! Candidate chords: from every end to the nearest corner and to the closest point across.
//!
//! Source: Abbasinejad et al. 2013, section 3.1. The answers do not depend on where a loop starts
//! and which way it runs.

use std::cmp::Ordering;

use patterndb_geometry::vector::{Point, cross, dot, length, max, min, subtract};

/// Two lengths, angles or coordinates count as equal below this share of their scale (SAME in
/// patterndb_sketch.surfacing.chords.candidates). A curve sampled from its other end gives points
/// that differ in the 16th digit; 1e-9 is far above that, and far below what can be seen.
const SAME: f64 = 1e-9;

/// A maximum of curvature counts where it exceeds the mean around it by this factor: a circle, and
/// the ripple of a polyline that was sampled again, has no maxima.
const PROMINENCE: f64 = 1.25;

/// The sine of the most that a chord to a corner may lean out of the curve's normal plane where it
/// starts, 40 degrees.
const TO_CORNER: f64 = 0.6427876096865393;

/// That of a chord to the closest point, 30 degrees.
const TO_CLOSEST: f64 = 0.49999999999999994;

/// A chord hugs the loop where the shorter way along the loop is no longer than this many times the
/// chord: it would cut off a sliver (HUGGING in patterndb_sketch.surfacing.chords.candidates). An arc
/// of a circle reaches it at 104 degrees.
const HUGGING: f64 = 1.15;

/// Points are near each other within this many edges of the loop (NEAR_EDGES in
/// patterndb_sketch.surfacing.chords.candidates).
const NEAR_EDGES: f64 = 2.0;

/// Or this share of the chord's length (NEAR_SHARE there).
const NEAR_SHARE: f64 = 0.25;

/// Return the longest side of the box around points.
fn measure_extent(points: &[Point]) -> f64 {
    let sides = [0, 1, 2].map(|d| {
        let along = points.iter().map(|point| point[d]);
        let least = along.clone().fold(f64::INFINITY, min);
        along.fold(f64::NEG_INFINITY, max) - least
    });
    sides.into_iter().fold(0.0, max)
}

/// Compare two points by x, then y, then z.
fn compare_points(a: &Point, b: &Point, tolerance: f64) -> Ordering {
    for (a, b) in a.iter().zip(b) {
        if (a - b).abs() > tolerance {
            return if a < b {
                Ordering::Less
            } else {
                Ordering::Greater
            };
        }
    }
    Ordering::Equal
}

/// Return the positions of a loop's points in the canonical traversal.
///
/// It begins at the vertex with the least x, then y, then z, and goes on to the side where, at the
/// first step that differs, x, then y, then z is less. Coordinates within SAME of the loop's extent
/// are equal.
pub fn order_canonically(points: &[Point]) -> Vec<usize> {
    let n = points.len();
    let tolerance = SAME * measure_extent(points);
    let mut among: Vec<usize> = (0..n).collect();
    for d in [0, 1, 2] {
        let along = among.iter().map(|&i| points[i][d]);
        let least = along.fold(f64::INFINITY, min);
        among.retain(|&i| points[i][d] <= least + tolerance);
    }
    let start = among[0];
    let sides = (1..n).map(|s| {
        let (after, before) = (&points[(start + s) % n], &points[(start + n - s) % n]);
        compare_points(after, before, tolerance)
    });
    let side = sides.into_iter().find(|side| side.is_ne());
    let step = if side == Some(Ordering::Greater) {
        n - 1
    } else {
        1
    };
    (0..n).map(|s| (start + s * step) % n).collect()
}

/// Return the turning angle in radians at every vertex of a closed polyline.
fn measure_turning(points: &[Point]) -> Vec<f64> {
    let n = points.len();
    let turning = (0..n).map(|i| {
        let before = subtract(&points[i], &points[(i + n - 1) % n]);
        let after = subtract(&points[(i + 1) % n], &points[i]);
        length(&cross(&before, &after)).atan2(dot(&before, &after))
    });
    turning.collect()
}

/// A closed polyline in its canonical traversal, with the turning at its vertices.
///
/// Stretches of it lie between two positions a < b, of which b may be beyond the last: positions
/// count modulo the number of vertices.
struct TurningLoop {
    points: Vec<Point>,
    turning: Vec<f64>,
    tolerance: f64,
}

impl TurningLoop {
    fn turning(&self, v: usize) -> f64 {
        self.turning[v % self.turning.len()]
    }

    fn compare(&self, a: usize, b: usize) -> Ordering {
        let n = self.points.len();
        compare_points(&self.points[a % n], &self.points[b % n], self.tolerance)
    }

    /// Return where the loop turns most; of equals, the point that comes first.
    fn find_first_largest(&self) -> usize {
        let mut best = 0;
        for i in 1..self.turning.len() {
            let (here, most) = (self.turning[i], self.turning[best]);
            if here > most + SAME || (here >= most - SAME && self.compare(i, best).is_lt()) {
                best = i;
            }
        }
        best
    }

    /// Return the turning at v and its neighbours with weights 1, 2, 1; ends a and b are left out.
    fn smooth_turning(&self, v: usize, a: usize, b: usize) -> f64 {
        let (mut total, mut weight) = (2.0 * self.turning(v), 2.0);
        if v - 1 > a {
            total += self.turning(v - 1);
            weight += 1.0;
        }
        if v + 1 < b {
            total += self.turning(v + 1);
            weight += 1.0;
        }
        total / weight
    }

    /// Return the vertex between a and b that is the highest maximum of curvature.
    ///
    /// A maximum is highest, and prominent, among the vertices from which the loop turns by no more
    /// than `reach` on the way to it. The first and last vertex of a stretch are none: there
    /// curvature may just be falling off from the end.
    fn find_maximum(&self, a: usize, b: usize, reach: f64) -> Option<usize> {
        let mut smooth = vec![0.0; b - a];
        for v in a + 1..b {
            smooth[v - a] = self.smooth_turning(v, a, b);
        }
        let mut found: Option<usize> = None;
        for v in a + 2..b - 1 {
            let here = smooth[v - a];
            if let Some(found) = found {
                let height = smooth[found - a];
                let lower = here < height - SAME;
                if lower || (here <= height + SAME && self.compare(v, found).is_gt()) {
                    continue;
                }
            }
            let mut around = Around {
                of: self,
                smooth: &smooth,
                from: a,
                here,
                reach,
                total: here,
                count: 1,
            };
            if around.is_highest((a + 1..v).rev())
                && around.is_highest(v + 1..b)
                && here > PROMINENCE * around.total / around.count as f64
            {
                found = Some(v);
            }
        }
        found
    }

    /// Mark the vertices between a and b where 1, 2, .. of `parts` of their turning, `total`, are
    /// reached.
    ///
    /// Where one is reached just between two vertices, the one that comes first is marked: of two
    /// curves side by side, walked in opposite senses, those are opposite each other.
    fn mark_parts(&self, a: usize, b: usize, total: f64, parts: usize, is_end: &mut [bool]) {
        let n = self.turning.len();
        let (mut turned, mut part) = (0.0, 1);
        for v in a + 1..b {
            turned += self.turning(v);
            while part < parts {
                let wanted = part as f64 * total / parts as f64;
                if turned < wanted - SAME {
                    break;
                }
                let between = turned <= wanted + SAME && v + 1 < b;
                let next = between && self.compare(v + 1, v).is_lt();
                is_end[if next { v + 1 } else { v } % n] = true;
                part += 1;
            }
        }
    }
}

/// The smoothed turning around a vertex.
struct Around<'a> {
    of: &'a TurningLoop,
    smooth: &'a [f64],
    from: usize,
    here: f64,
    reach: f64,
    total: f64,
    count: usize,
}

impl Around<'_> {
    /// Count the vertices on one side up to the reach; return whether none is higher.
    fn is_highest(&mut self, side: impl Iterator<Item = usize>) -> bool {
        let mut turned = 0.0;
        for u in side {
            if turned > self.reach {
                break;
            }
            let other = self.smooth[u - self.from];
            self.total += other;
            self.count += 1;
            if other > self.here + SAME {
                return false;
            }
            turned += self.of.turning(u);
        }
        true
    }
}

/// Return which vertices of a loop are ends, from which chords start.
///
/// All corners; then, wherever the loop turns between two ends by more than `bound` (radians, above
/// 0), a local maximum of curvature if there is one, else samples that part the turning evenly.
/// Strictly between neighbouring ends the loop turns by no more than the bound.
///
/// Differs from the paper: it walks along the cycle and places samples as it goes, which would
/// depend on start and sense; here the turning between two ends is parted evenly.
pub fn find_endpoints(points: &[Point], corners: &[bool], bound: f64) -> Vec<bool> {
    let n = points.len();
    let order = order_canonically(points);
    let points: Vec<Point> = order.iter().map(|&i| points[i]).collect();
    let around = TurningLoop {
        turning: measure_turning(&points),
        tolerance: SAME * measure_extent(&points),
        points,
    };
    let mut is_end: Vec<bool> = order.iter().map(|&i| corners[i]).collect();
    if !is_end.contains(&true) {
        is_end[around.find_first_largest()] = true;
    }
    let ends: Vec<usize> = (0..n).filter(|&i| is_end[i]).collect();
    let following = ends.iter().copied().skip(1).chain([ends[0] + n]);
    let mut stretches: Vec<_> = ends.iter().copied().zip(following).collect();
    while let Some((a, b)) = stretches.pop() {
        let total = (a + 1..b).fold(0.0, |total, v| total + around.turning(v));
        if total <= bound * (1.0 + SAME) {
            continue;
        }
        if let Some(top) = around.find_maximum(a, b, bound / 2.0) {
            is_end[top % n] = true;
            stretches.extend([(a, top), (top, b)]);
        } else {
            let parts = (total / bound - SAME).ceil() as usize;
            around.mark_parts(a, b, total, parts, &mut is_end);
        }
    }
    let mut ends = vec![false; n];
    for (&i, is_end) in order.iter().zip(is_end) {
        ends[i] = is_end;
    }
    ends
}

/// A closed polyline in its canonical traversal, with all that chords are judged by.
struct ChordLoop {
    points: Vec<Point>,
    corners: Vec<bool>,
    /// Unit tangents of every vertex: of the edge before, the edge after, and half between.
    tangents: Vec<[Point; 3]>,
    /// The length of the loop up to every vertex, and the whole length.
    along: Vec<f64>,
}

impl ChordLoop {
    fn new(points: Vec<Point>, corners: Vec<bool>) -> ChordLoop {
        let n = points.len();
        let mut tangents = vec![[[0.0; 3]; 3]; n];
        let mut along = Vec::with_capacity(n + 1);
        along.push(0.0);
        for i in 0..n {
            let following = (i + 1) % n;
            let edge = subtract(&points[following], &points[i]);
            let size = length(&edge);
            if size > 0.0 {
                let tangent = edge.map(|x| x / size);
                tangents[i][1] = tangent;
                tangents[following][0] = tangent;
            }
            along.push(along[i] + size);
        }
        for [before, after, between] in &mut tangents {
            let sum = [0, 1, 2].map(|d| before[d] + after[d]);
            let size = length(&sum);
            // Where the loop turns back on itself, nothing is half between.
            *between = sum.map(|x| if size > SAME { x / size } else { 0.0 });
        }
        ChordLoop {
            points,
            corners,
            tangents,
            along,
        }
    }

    fn length(&self) -> f64 {
        self.along[self.points.len()]
    }

    fn distance(&self, a: usize, b: usize) -> f64 {
        length(&subtract(&self.points[a], &self.points[b]))
    }

    /// Return the sine of the angle between the chord from e to p and the normal plane at e.
    fn measure_leaning(&self, e: usize, p: usize) -> f64 {
        let size = self.distance(e, p);
        let chord = subtract(&self.points[p], &self.points[e]);
        let tangents = &self.tangents[e][if self.corners[e] { 0 } else { 2 }..];
        let real = tangents.iter().filter(|tangent| **tangent != [0.0; 3]);
        let leanings = real.map(|tangent| dot(&chord, tangent).abs() / size);
        leanings.fold(1.0, min)
    }

    /// Return whether the chord from e to p cuts off more than a sliver, and joins no neighbours.
    fn does_cut(&self, e: usize, p: usize) -> bool {
        let apart = e.abs_diff(p);
        if apart < 2 || apart + 2 > self.points.len() {
            return false;
        }
        let way = (self.along[p] - self.along[e]).abs();
        let way = min(way, self.length() - way);
        let size = self.distance(e, p);
        size > SAME * self.length() && way > HUGGING * size * (1.0 + SAME)
    }

    /// Return whether a is near b, which is at the end of a chord of this size.
    fn is_near(&self, a: usize, b: usize, size: f64) -> bool {
        let edge = self.length() / self.points.len() as f64;
        self.distance(a, b) <= max(NEAR_EDGES * edge, NEAR_SHARE * size) * (1.0 + SAME)
    }
}

/// A chord to the closest point.
struct Closest {
    from: usize,
    to: usize,
    size: f64,
}

/// Return chords from `ends`, positions in a loop, nearly perpendicular to it there.
///
/// Each end has up to two: one to the nearest corner within 40 degrees of the normal plane, one to
/// the closest point within 30. The latter ends at another end near the closest point, if one
/// qualifies. If the corner is near the closest point, only the chord to the corner is kept. At a
/// corner, the curve's tangent is the incoming or the outgoing edge's or half between. No chord joins
/// neighbours or hugs the loop.
///
/// Differs from the paper: it asks in one sentence to drop the chord of an end without a corner, and
/// promises in another at least one chord for every end; here the chord to the closest point stays,
/// and an end may have none.
pub fn find_candidates(points: &[Point], corners: &[bool], ends: &[i64]) -> Vec<[usize; 2]> {
    let n = points.len();
    let order = order_canonically(points);
    let around = ChordLoop::new(
        order.iter().map(|&i| points[i]).collect(),
        order.iter().map(|&i| corners[i]).collect(),
    );
    let tolerance = SAME * around.length();
    let mut given = vec![false; n];
    for &end in ends {
        given[end as usize] = true;
    }
    let mut is_end: Vec<bool> = order.iter().map(|&i| given[i]).collect();
    let mut chords = Vec::new();
    // The chords to corners, and where the closest points are.
    let mut closest_points = Vec::new();
    for e in (0..n).filter(|&e| is_end[e]) {
        let (mut corner, mut closest) = (None, None);
        let (mut to_corner, mut to_closest) = (f64::INFINITY, f64::INFINITY);
        for p in 0..n {
            let size = around.distance(e, p);
            let farther_corner = !around.corners[p] || size >= to_corner - tolerance;
            if (farther_corner && size >= to_closest - tolerance) || !around.does_cut(e, p) {
                continue;
            }
            let leaning = around.measure_leaning(e, p);
            if !farther_corner && leaning <= TO_CORNER + SAME {
                (corner, to_corner) = (Some(p), size);
            }
            if size < to_closest - tolerance && leaning <= TO_CLOSEST + SAME {
                (closest, to_closest) = (Some(p), size);
            }
        }
        if let Some(corner) = corner {
            chords.push([order[e], order[corner]]);
            closest = closest.filter(|&closest| !around.is_near(corner, closest, to_closest));
        }
        if let Some(closest) = closest {
            closest_points.push(Closest {
                from: e,
                to: closest,
                size: to_closest,
            });
        }
    }
    sort_within(&mut closest_points, tolerance);
    // The chords to closest points, shortest first: an end that one makes serves the others.
    for Closest { from, to, size } in closest_points {
        let (mut chosen, mut to_chosen) = (to, f64::INFINITY);
        if !is_end[to] {
            for q in (0..n).filter(|&q| is_end[q]) {
                if !around.is_near(q, to, size) {
                    continue;
                }
                let other = around.distance(from, q);
                if other < to_chosen - tolerance
                    && around.does_cut(from, q)
                    && around.measure_leaning(from, q) <= TO_CLOSEST + SAME
                {
                    (chosen, to_chosen) = (q, other);
                }
            }
            is_end[chosen] = true;
        }
        chords.push([order[from], order[chosen]]);
    }
    chords
}

/// Sort chords by size, where those equal within the tolerance keep their order.
///
/// By insertion: being equal within a tolerance is not transitive, as other sorts need it.
fn sort_within(chords: &mut [Closest], tolerance: f64) {
    for i in 1..chords.len() {
        let size = chords[i].size + tolerance;
        let before = chords[..i].iter().rev();
        let passed = before.take_while(|other| other.size > size).count();
        chords[i - passed..=i].rotate_right(1);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Return a closed curve of n vertices that turns unevenly.
    fn curve(n: usize) -> Vec<Point> {
        let at = |i| {
            let angle = TAU * i as f64 / n as f64;
            [
                3.0 * angle.cos(),
                angle.sin(),
                0.3 * (2.0 * angle).sin() + 0.1 * angle.cos(),
            ]
        };
        (0..n).map(at).collect()
    }

    fn chords_of(points: &[Point], corners: &[bool]) -> Vec<[usize; 2]> {
        let ends = find_endpoints(points, corners, 0.8);
        let ends = (0..points.len()).filter(|&i| ends[i]);
        let ends: Vec<i64> = ends.map(|i| i as i64).collect();
        let mut chords = find_candidates(points, corners, &ends);
        chords.iter_mut().for_each(|chord| chord.sort_unstable());
        chords.sort_unstable();
        chords.dedup();
        chords
    }

    #[test]
    fn the_canonical_order_begins_at_the_least_and_goes_to_the_lesser() {
        let square = [
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0],
        ];
        assert_eq!(order_canonically(&square), [3, 2, 1, 0]);
    }

    #[test]
    fn ends_and_chords_do_not_depend_on_start_and_sense() {
        let points = curve(40);
        let corners: Vec<bool> = (0..40).map(|i| i == 3 || i == 25).collect();
        let expected = find_endpoints(&points, &corners, 0.8);
        let chords = chords_of(&points, &corners);
        assert!(!chords.is_empty());
        for start in [1, 7, 39] {
            let (mut turned, mut turned_corners) = (points.clone(), corners.clone());
            turned.rotate_left(start);
            turned_corners.rotate_left(start);
            let mut ends = find_endpoints(&turned, &turned_corners, 0.8);
            ends.rotate_right(start);
            assert_eq!(ends, expected);
            let back = chords_of(&turned, &turned_corners);
            let mut back: Vec<[usize; 2]> = back
                .into_iter()
                .map(|chord| {
                    let mut chord = chord.map(|v| (v + start) % 40);
                    chord.sort_unstable();
                    chord
                })
                .collect();
            back.sort_unstable();
            assert_eq!(back, chords);
        }
        let (mut reversed, mut reversed_corners) = (points, corners);
        reversed.reverse();
        reversed_corners.reverse();
        let mut ends = find_endpoints(&reversed, &reversed_corners, 0.8);
        ends.reverse();
        assert_eq!(ends, expected);
    }

    #[test]
    fn the_loop_turns_between_ends_by_no_more_than_the_bound() {
        let points = curve(200);
        let ends = find_endpoints(&points, &[false; 200], 0.5);
        let turning = measure_turning(&points);
        let first = ends.iter().position(|&end| end).unwrap();
        let mut turned = 0.0;
        for v in (first..first + 200).map(|v| v % 200) {
            turned = if ends[v] { 0.0 } else { turned + turning[v] };
            assert!(turned <= 0.5 * (1.0 + 1e-6));
        }
    }

    #[test]
    fn equals_within_the_tolerance_keep_their_order() {
        let sizes = [3.0, 1.05, 1.0, 2.0, 1.02];
        let at = |(from, size)| Closest { from, to: 0, size };
        let mut chords: Vec<Closest> = sizes.into_iter().enumerate().map(at).collect();
        sort_within(&mut chords, 0.1);
        let order: Vec<usize> = chords.iter().map(|chord| chord.from).collect();
        assert_eq!(order, [1, 2, 4, 3, 0]);
    }
}
