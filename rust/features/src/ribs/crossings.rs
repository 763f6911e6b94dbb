//! Where edges of segments cross and touch, how far they hang over there, and which segments
//! belong together: they cross, touch, or leave a small gap between them.

use std::cmp::Ordering;

use patterndb_geometry::vector::{max, min};

use super::{Edge, Place, Segments, advance, distance, edge, vector};

/// How many times as long the longer of two overhangs may be at a crossing. Surfaces that were
/// drawn out to meet go on beyond by much the same; one that ends against a lip does not.
const ALIKE: f64 = 5.0;

/// The origin of a slice's frame.
pub(super) const ORIGIN: Place = [0.0, 0.0];

/// Where an edge is nearest to a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Foot {
    /// The distance.
    pub away: f64,
    /// The share of the edge.
    pub share: f64,
}

/// Find the foot of a place on an edge.
#[inline(always)]
pub(super) fn find_foot([p, q]: &Edge, place: Place) -> Foot {
    let d = vector(*p, *q);
    let size = d[0] * d[0] + d[1] * d[1];
    let share = if size > 0.0 {
        let along = (place[0] - p[0]) * d[0] + (place[1] - p[1]) * d[1];
        min(max(along / size, 0.0), 1.0)
    } else {
        0.0
    };
    Foot {
        away: distance(place, advance(*p, share, d)),
        share,
    }
}

/// Return twice the area that an edge sees a place under; above 0 on its left.
#[inline(always)]
fn side([p, q]: &Edge, place: Place) -> f64 {
    let d = vector(*p, *q);
    d[0] * (place[1] - p[1]) - d[1] * (place[0] - p[0])
}

/// Find the share of edge e where edge f crosses it, both from one side to the other.
#[inline(always)]
pub(super) fn find_crossing(e: &Edge, f: &Edge) -> Option<f64> {
    let changes = |a: f64, b: f64| (a > 0.0) != (b > 0.0) && a != 0.0 && b != 0.0;
    let (a, b) = (side(f, e[0]), side(f, e[1]));
    if !changes(a, b) || !changes(side(e, f[0]), side(e, f[1])) {
        return None;
    }
    let share = a / (a - b);
    (share >= 0.0).then_some(share)
}

/// Return whether two edges cross, or come within reach of each other.
fn is_touching(e: &Edge, f: &Edge, reach: f64) -> bool {
    find_crossing(e, f).is_some()
        || f.iter().any(|&place| find_foot(e, place).away <= reach)
        || e.iter().any(|&place| find_foot(f, place).away <= reach)
}

/// Find the share of edge e where edge f crosses it, or else comes nearest to it.
fn find_touch(e: &Edge, f: &Edge) -> f64 {
    if let Some(share) = find_crossing(e, f) {
        return share;
    }
    let ends = [0, 1].map(|k| Foot {
        away: find_foot(f, e[k]).away,
        share: k as f64,
    });
    let feet = f.map(|place| find_foot(e, place));
    let mut nearest = Foot {
        away: f64::INFINITY,
        share: -1.0,
    };
    for foot in ends.into_iter().chain(feet) {
        if foot.away < nearest.away {
            nearest = foot;
        }
    }
    nearest.share
}

/// Return whether edges e and f, which meet at end `common` of e, lie on each other.
fn is_folded(e: &Edge, f: &Edge, common: usize, reach: f64) -> bool {
    let one = e[1 - common];
    let two = if f[1] == e[common] { f[0] } else { f[1] };
    find_foot(f, one).away <= reach || find_foot(e, two).away <= reach
}

/// An edge of one of many segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Owned {
    /// The edge's first point.
    pub first: usize,
    /// The segment that it is of.
    pub segment: usize,
}

/// List the edges of all segments.
pub(super) fn list_edges(segments: &Segments) -> Vec<Owned> {
    let of = |segment| {
        let edges = segments.edges(segment);
        edges.map(move |first| Owned { first, segment })
    };
    (0..segments.len()).flat_map(of).collect()
}

/// Find the edge that is nearest to the origin, and its foot.
pub(super) fn find_nearest_segment(segments: &Segments) -> Option<(Owned, Foot)> {
    let mut best: Option<(Owned, Foot)> = None;
    let mut least = f64::INFINITY;
    for owned in list_edges(segments) {
        let foot = find_foot(&edge(&segments.points, owned.first), ORIGIN);
        if foot.away < least {
            least = foot.away;
            best = Some((owned, foot));
        }
    }
    best
}

/// Lengths up to which segments belong together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Edges this close touch.
    pub reach: f64,
    /// Ends this close to another segment, or to a far part of their own, belong to it.
    pub gap: f64,
    /// Both segments may hang over by this at a crossing.
    pub overhang: f64,
}

/// How segments belong together, an item for each.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Groups {
    /// Groups by their first segment.
    pub label: Vec<usize>,
    /// Whether the segment touches another or itself.
    pub touching: Vec<bool>,
    /// The widest gap at an end of the segment, 0 without one.
    pub gaps: Vec<f64>,
    /// How far the segment hangs over at its ends: 0 where it ends on another, infinite where it
    /// is free.
    pub free: Vec<[f64; 2]>,
}

/// Group segments that cross or touch one another, or have ends near others.
///
/// Ends count that are not on the circle, and do not only hang over from where the segment touches
/// another: by no more than the gap, or by no more than the overhang where the other one hangs over
/// as well, by a length that is [`ALIKE`].
pub(super) fn group_segments(segments: &Segments, limits: &Limits) -> Groups {
    let n = segments.len();
    let mut label: Vec<usize> = (0..n).collect();
    let mut touching = vec![false; n];
    let mut overhangs = Overhangs {
        free: vec![[f64::INFINITY; 2]; n],
        alone: vec![[f64::INFINITY; 2]; n],
    };
    for_each_touch(segments, limits.reach, |e, f| {
        let (s, t) = (e.segment, f.segment);
        touching[s] = true;
        touching[t] = true;
        if s != t {
            let one = measure_to_ends(segments, e, f, limits.overhang);
            let two = measure_to_ends(segments, f, e, limits.overhang);
            overhangs.note(s, one, two, limits);
            overhangs.note(t, two, one, limits);
        }
        unite(&mut label, s, t);
    });
    let mut free = overhangs.settle(segments, limits.gap);
    let mut gaps = vec![0.0; n];
    for (s, ends) in free.iter_mut().enumerate() {
        for (side, over) in ends.iter_mut().enumerate() {
            if !segments.has_end(s, side) {
                *over = 0.0;
            }
            if *over < f64::INFINITY {
                continue;
            }
            let neighbours = find_neighbours(segments, s, side, limits.gap);
            let found = neighbours.iter().flatten();
            // An end is not nearer than the segment that it is of.
            if let Some(&(away, _)) = found.clone().last() {
                gaps[s] = max(gaps[s], away);
            }
            for &(_, neighbour) in found {
                unite(&mut label, s, neighbour);
            }
        }
    }
    let label = (0..n).map(|s| find_root(&mut label, s)).collect();
    Groups {
        label,
        touching,
        gaps,
        free,
    }
}

/// Call `visit` with all pairs of edges that touch; neighbours of a segment, where they lie on each
/// other.
fn for_each_touch(segments: &Segments, reach: f64, mut visit: impl FnMut(Owned, Owned)) {
    let points = &segments.points;
    let low = |e: &Owned, c: usize| min(points[e.first][c], points[e.first + 1][c]);
    let high = |e: &Owned, c: usize| max(points[e.first][c], points[e.first + 1][c]);
    let mut edges: Vec<(f64, Owned)> = list_edges(segments)
        .into_iter()
        .map(|e| (low(&e, 0), e))
        .collect();
    edges.sort_by(|a, b| a.0.partial_cmp(&b.0).unwrap_or(Ordering::Equal));
    for (i, &(_, e)) in edges.iter().enumerate() {
        let right = high(&e, 0) + reach;
        let (bottom, top) = (low(&e, 1) - reach, high(&e, 1) + reach);
        for &(left, f) in &edges[i + 1..] {
            if left > right {
                break;
            }
            if low(&f, 1) > top || high(&f, 1) < bottom {
                continue;
            }
            let (one, two) = (edge(points, e.first), edge(points, f.first));
            let met = match find_common_end(segments, e, f) {
                Some(common) => is_folded(&one, &two, common, reach),
                None => is_touching(&one, &two, reach),
            };
            if met {
                visit(e, f);
            }
        }
    }
}

/// Return the end of edge e, 0 or 1, that edge f goes on from along the same segment.
fn find_common_end(segments: &Segments, e: Owned, f: Owned) -> Option<usize> {
    let s = e.segment;
    if s != f.segment {
        return None;
    }
    let (begin, last) = (segments.end(s, 0), segments.end(s, 1));
    let follows = |one: usize, other: usize| {
        other == one + 1 || (segments.closed[s] && other == begin && one + 1 == last)
    };
    if follows(e.first, f.first) {
        Some(1)
    } else {
        follows(f.first, e.first).then_some(0)
    }
}

/// Return the lengths from both ends of a segment to where its edge e touches edge f; infinite for
/// those above `most`, and from ends that are none, or on the circle.
fn measure_to_ends(segments: &Segments, e: Owned, f: Owned, most: f64) -> [f64; 2] {
    let (points, s) = (&segments.points, e.segment);
    if segments.closed[s] {
        return [f64::INFINITY; 2];
    }
    let own = edge(points, e.first);
    let share = find_touch(&own, &edge(points, f.first));
    let size = distance(own[0], own[1]);
    let (mut before, mut after) = (share * size, (1.0 - share) * size);
    let mut k = e.first;
    while before <= most && k > segments.offsets[s] {
        before += distance(points[k - 1], points[k]);
        k -= 1;
    }
    k = e.first + 1;
    while after <= most && k + 1 < segments.offsets[s + 1] {
        after += distance(points[k], points[k + 1]);
        k += 1;
    }
    let [first, last] = segments.rims[s];
    let bounded = |length, is_rim| {
        if length > most || is_rim {
            f64::INFINITY
        } else {
            length
        }
    };
    [bounded(before, first), bounded(after, last)]
}

/// The least length of each segment from either end to where it touches another.
struct Overhangs {
    /// Where both hang over.
    free: Vec<[f64; 2]>,
    /// Where this one alone does.
    alone: Vec<[f64; 2]>,
}

impl Overhangs {
    /// Note the lengths `own` of segment s from where it touches another, which has the lengths
    /// `other` from there to its ends.
    fn note(&mut self, s: usize, own: [f64; 2], other: [f64; 2], limits: &Limits) {
        let mut beyond = min(other[0], other[1]);
        if beyond <= limits.reach {
            // The other one ends here, or all of it hangs over.
            beyond = max(other[0], other[1]);
        }
        for (side, length) in own.into_iter().enumerate() {
            let alike =
                length < f64::INFINITY && beyond <= ALIKE * length && length <= ALIKE * beyond;
            if alike || length <= limits.reach {
                self.free[s][side] = min(self.free[s][side], length);
            } else if length <= limits.gap {
                self.alone[s][side] = min(self.alone[s][side], length);
            }
        }
    }

    /// Return how far segments hang over: those that do so alone as well, but not at ends that have
    /// another free end within the gap. There the surface goes on, and what touches it is behind it.
    fn settle(self, segments: &Segments, gap: f64) -> Vec<[f64; 2]> {
        let Self { free: wide, alone } = self;
        let is_faced = |s: usize, end: Place| {
            (0..segments.len()).filter(|&t| t != s).any(|t| {
                (0..2).any(|side| {
                    segments.has_end(t, side)
                        && wide[t][side] == f64::INFINITY
                        && distance(end, segments.points[segments.end(t, side)]) <= gap
                })
            })
        };
        let mut free = wide.clone();
        for (s, least) in alone.iter().enumerate() {
            for side in 0..2 {
                if least[side] < free[s][side]
                    && !is_faced(s, segments.points[segments.end(s, side)])
                {
                    free[s][side] = least[side];
                }
            }
        }
        free
    }
}

/// Find the segment and the end nearest to an end of segment s, where they are within the gap:
/// their distances and segments.
fn find_neighbours(
    segments: &Segments,
    s: usize,
    side: usize,
    gap: f64,
) -> [Option<(f64, usize)>; 2] {
    let points = &segments.points;
    let end = segments.end(s, side);
    let place = points[end];
    // The part of its own that the end hangs on does not count.
    let (own_low, own_high) = (segments.end(s, 0), segments.end(s, 1));
    let mut along = 0.0;
    let mut k = end;
    let (own_low, own_high) = if side == 0 {
        while k < own_high && along < 3.0 * gap {
            along += distance(points[k], points[k + 1]);
            k += 1;
        }
        (k, own_high)
    } else {
        while k > own_low && along < 3.0 * gap {
            along += distance(points[k], points[k - 1]);
            k -= 1;
        }
        (own_low, k)
    };
    let mut to_edge = (f64::INFINITY, s);
    let mut to_end = (f64::INFINITY, s);
    for t in 0..segments.len() {
        let (begin, stop) = if t == s {
            (own_low, own_high)
        } else {
            (segments.end(t, 0), segments.end(t, 1))
        };
        for e in begin..stop {
            let away = find_foot(&edge(points, e), place).away;
            if away < to_edge.0 {
                to_edge = (away, t);
            }
        }
        for other in 0..2 {
            let k = segments.end(t, other);
            if !segments.has_end(t, other) || k == end || k < begin || k > stop {
                continue;
            }
            let away = distance(points[k], place);
            if away < to_end.0 {
                to_end = (away, t);
            }
        }
    }
    [to_edge, to_end].map(|found| (found.0 <= gap).then_some(found))
}

/// Unite the groups of two segments.
fn unite(label: &mut [usize], i: usize, j: usize) {
    let (one, two) = (find_root(label, i), find_root(label, j));
    label[one.max(two)] = one.min(two);
}

/// Find the first segment of a group, halving the path to it.
fn find_root(label: &mut [usize], mut i: usize) -> usize {
    while label[i] != i {
        label[i] = label[label[i]];
        i = label[i];
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Open segments, none of which ends on the circle.
    fn segments(parts: &[&[Place]]) -> Segments {
        let mut made = Segments::default();
        for part in parts {
            made.points.extend_from_slice(part);
            made.finish_segment(false, [false; 2]);
        }
        made
    }

    const LIMITS: Limits = Limits {
        reach: 1e-9,
        gap: 0.1,
        overhang: 0.5,
    };

    #[test]
    fn edges_cross_from_one_side_to_the_other() {
        let level = [[0.0, 0.0], [4.0, 0.0]];
        assert_eq!(
            find_crossing(&level, &[[1.0, -1.0], [1.0, 1.0]]),
            Some(0.25)
        );
        assert_eq!(find_crossing(&level, &[[1.0, 0.0], [1.0, 1.0]]), None);
        assert_eq!(find_crossing(&level, &[[5.0, -1.0], [5.0, 1.0]]), None);
    }

    #[test]
    fn a_foot_is_an_end_where_a_place_lies_beyond_it() {
        let foot = find_foot(&[[0.0, 0.0], [2.0, 0.0]], [5.0, 4.0]);
        assert_eq!((foot.away, foot.share), (5.0, 1.0));
        let foot = find_foot(&[[1.0, 1.0], [1.0, 1.0]], [1.0, 3.0]);
        assert_eq!((foot.away, foot.share), (2.0, 0.0));
    }

    #[test]
    fn segments_that_cross_hang_over_alike() {
        let made = segments(&[
            &[[-3.75, 0.0], [0.25, 0.0]],
            &[[0.0, -3.75], [0.0, 0.25]],
            &[[9.0, 9.0], [9.0, 8.0]],
        ]);
        let groups = group_segments(&made, &LIMITS);
        assert_eq!(groups.label, [0, 0, 2]);
        assert_eq!(groups.touching, [true, true, false]);
        assert_eq!(groups.free[0], [f64::INFINITY, 0.25]);
        assert_eq!(groups.free[1], [f64::INFINITY, 0.25]);
    }

    #[test]
    fn segments_with_a_small_gap_belong_together() {
        let made = segments(&[&[[0.0, 0.0], [1.0, 0.0]], &[[1.0625, 0.0], [2.0, 0.0]]]);
        let groups = group_segments(&made, &LIMITS);
        assert_eq!(groups.label, [0, 0]);
        assert_eq!(groups.touching, [false; 2]);
        assert_eq!(groups.gaps, [0.0625; 2]);
    }
}
