//! Repair: segments without what hangs over where they cross others, and with small gaps bridged.
//!
//! Surfaces that were drawn out to meet go on beyond the place where they cross: [`trim_overhangs`]
//! takes that off. Ends that face each other are joined as the surfaces on both sides go on:
//! [`bridge_gaps`]. [`mend_segments`] does both in turn.
//!
//! `SHARPEST`, `GAP` and `OVERHANG` in `patterndb_sketch.features.ribs.repair` are the same as here.

use patterndb_geometry::vector::{max, min};

use super::crossings::{Limits, find_foot, find_nearest_segment, group_segments};
use super::slicing::{chain_ends, outer_ends, stitch_segments};
use super::{Place, Segments, advance, distance, edge, length, vector};

/// The direction of an end is taken over this share of the gap.
const SPAN: f64 = 0.25;

/// Cosine of the sharpest turn at which both sides of a gap are drawn out until they meet: 120
/// degrees. So the corner is no farther than 1.16 times the gap's width from either end.
const SHARPEST: f64 = -0.5;

/// An end that runs at the side of another segment meets it no farther away than this many times
/// the gap: at 30 degrees or more.
const STEEP: f64 = 2.0;

/// Two ends face each other if all others are this many times as far from both.
const LONE: f64 = 1.5;

/// The other segment must not come much closer to an end than its own end does.
const BESIDE: f64 = 0.7;

/// How often overhangs are taken off, and ends joined: what one leaves may be for the next.
const MENDS: usize = 4;

/// Ends this close to others, as a share of the radius, leave a gap that is to be closed: as much
/// as dilation may close within the picture's margin. At the usual radius 0.28 % of the diagonal,
/// or 13 mm of a car.
const GAP: f64 = 0.055;

/// Where two segments cross, both may hang over by this share of the radius: at the usual radius
/// 0.75 % of the diagonal, or 35 mm of a car.
const OVERHANG: f64 = 0.15;

/// Edges this close touch, as a share of the tolerance for stitching: points are computed to some
/// 1e-15 of the diagonal.
pub(super) const TOUCH: f64 = 1e-3;

/// Segments that belong together.
#[derive(Clone, Debug)]
pub(super) struct Mended {
    /// The segments.
    pub segments: Segments,
    /// The widest gap to be closed; None if there is one segment, which has none.
    pub gap: Option<f64>,
    /// Whether anything was taken off or joined.
    pub is_changed: bool,
}

/// Find the segments that belong to the one nearest to the origin, without what hangs over and
/// joined where that leaves no choice.
pub(super) fn mend_segments(mut segments: Segments, radius: f64, tolerance: f64) -> Mended {
    let limits = Limits {
        reach: TOUCH * tolerance,
        gap: GAP * radius,
        overhang: OVERHANG * radius,
    };
    let mut is_changed = false;
    let mut gap = None;
    for step in 0..=MENDS {
        let groups = group_segments(&segments, &limits);
        let Some((nearest, _)) = find_nearest_segment(&segments) else {
            break;
        };
        let nearest = nearest.segment;
        let is_kept = |&s: &usize| groups.label[s] == groups.label[nearest];
        let kept: Vec<usize> = (0..segments.len()).filter(is_kept).collect();
        let tangled = kept.len() > 1 || groups.touching[nearest] || groups.gaps[nearest] > 0.0;
        let widest = kept.iter().map(|&s| groups.gaps[s]).reduce(max);
        gap = widest.filter(|_| tangled);
        let free: Vec<[f64; 2]> = kept.iter().map(|&s| groups.free[s]).collect();
        segments = segments.pick(&kept);
        if !tangled || step == MENDS {
            break;
        }
        let mended = trim_overhangs(&segments, &free, limits.reach, tolerance)
            .or_else(|| bridge_gaps(&segments, &free, limits.gap, tolerance));
        let Some(mended) = mended else {
            break;
        };
        segments = mended;
        is_changed = true;
    }
    Mended {
        segments,
        gap,
        is_changed,
    }
}

/// Return the segments without what hangs over, then end to end where two ends meet; None where
/// nothing hangs over, or nothing would be left.
///
/// Segments of which all hangs over from one end go; others stay whole if they would lose more than
/// they would keep.
fn trim_overhangs(
    segments: &Segments,
    free: &[[f64; 2]],
    reach: f64,
    tolerance: f64,
) -> Option<Segments> {
    let mut trimmed = Segments::default();
    let mut any_over = false;
    for (s, free) in free.iter().enumerate() {
        let points = segments.points_of(s);
        let size = measure(points);
        let is_over = |length: f64| length < f64::INFINITY && length > reach;
        let mut cut = free.map(|length| if is_over(length) { length } else { 0.0 });
        let left = size - cut[0] - cut[1];
        if left <= reach && free.iter().any(|&length| length <= reach) {
            any_over = true;
            continue;
        }
        if left <= cut[0] + cut[1] {
            cut = [0.0; 2];
        }
        any_over = any_over || cut != [0.0; 2];
        let n = trimmed.points.len();
        append_trimmed(points, cut[0], size - cut[1], &mut trimmed.points);
        if trimmed.points.len() > n {
            trimmed.finish_segment(segments.closed[s], segments.rims[s]);
        }
    }
    if !any_over || trimmed.is_empty() {
        return None;
    }
    let stitched = stitch_segments(&trimmed, tolerance);
    (!stitched.is_empty()).then_some(stitched)
}

/// Return the length of a polyline.
pub(super) fn measure(points: &[Place]) -> f64 {
    let steps = points.windows(2);
    steps.fold(0.0, |total, step| total + distance(step[0], step[1]))
}

/// Append the points of a segment from the length `first` to the length `last` along it.
fn append_trimmed(points: &[Place], first: f64, last: f64, result: &mut Vec<Place>) {
    let mut along = 0.0;
    for pair in points.windows(2) {
        let d = vector(pair[0], pair[1]);
        let step = length(d);
        if step > 0.0 && along + step > first && along < last {
            if along <= first {
                result.push(advance(pair[0], (first - along) / step, d));
            }
            let share = min((last - along) / step, 1.0);
            result.push(if share < 1.0 {
                advance(pair[0], share, d)
            } else {
                pair[1]
            });
        }
        along += step;
    }
}

/// Return the segments joined where two free ends face each other within the gap, and drawn out
/// where one runs at the side of another; None where none do.
///
/// Source: feature curve recovery paper, section 4.3.2. Differs from the paper: it bridges gaps by
/// pixels and takes points of the segments alone, which cuts corners off where surfaces end just
/// short of the edge at which they would meet. There both are drawn out until they do.
fn bridge_gaps(
    segments: &Segments,
    free: &[[f64; 2]],
    gap: f64,
    tolerance: f64,
) -> Option<Segments> {
    let is_open = |end: usize| {
        segments.has_end(end >> 1, end & 1) && free[end >> 1][end & 1] == f64::INFINITY
    };
    let open: Vec<bool> = (0..2 * segments.len()).map(is_open).collect();
    let faced = find_facing(segments, &open, gap);
    let unmated: Vec<usize> = (0..open.len())
        .filter(|&end| open[end] && faced[end].is_none())
        .collect();
    let drawn = draw_ends_out(segments, &unmated, gap, tolerance);
    if faced.iter().all(Option::is_none) {
        return drawn;
    }
    let segments = drawn.as_ref().unwrap_or(segments);
    let mates: Vec<Option<usize>> = faced.iter().map(|faced| faced.map(|f| f.end)).collect();
    let mut result = Segments::default();
    for (entered, is_loop) in chain_ends(&mates).iter() {
        let (begin, last) = outer_ends(entered);
        let first = result.points.len();
        for &end in entered {
            segments.append_entered(end, &mut result.points);
            let corner = faced[end ^ 1].and_then(|faced| faced.corner);
            result.points.extend(corner);
        }
        if is_loop {
            result.points.push(result.points[first]);
        }
        let whole = is_loop || segments.closed[begin >> 1];
        let rims = [begin, last].map(|end| !whole && segments.is_rim(end));
        result.finish_segment(whole, rims);
    }
    Some(result)
}

/// Return the segments, those ends drawn out of the given ones that run at another segment within
/// the gap; None where none do.
fn draw_ends_out(
    segments: &Segments,
    ends: &[usize],
    gap: f64,
    tolerance: f64,
) -> Option<Segments> {
    let mut added = vec![None; 2 * segments.len()];
    for &end in ends {
        let (s, side) = (end >> 1, end & 1);
        let place = segments.place(end);
        let near = measure_to_others(segments, s, s, place).others;
        if !(tolerance < near && near <= gap) {
            continue;
        }
        let heading = find_heading(segments.points_of(s), side, SPAN * near);
        let away = measure_ahead(segments, s, place, heading);
        if away <= STEEP * near {
            added[end] = Some(advance(place, away, heading));
        }
    }
    if added.iter().all(Option::is_none) {
        return None;
    }
    let mut result = Segments::default();
    for s in 0..segments.len() {
        result.points.extend(added[2 * s]);
        result.points.extend_from_slice(segments.points_of(s));
        result.points.extend(added[2 * s + 1]);
        result.finish_segment(segments.closed[s], segments.rims[s]);
    }
    Some(result)
}

/// Find the unit direction in which a segment leaves its first (side 0) or last point, as the chord
/// over the length `span` before it; 0 where that has no length.
fn find_heading(points: &[Place], side: usize, span: f64) -> Place {
    let from_end = |k: usize| points[if side == 0 { k } else { points.len() - 1 - k }];
    let end = from_end(0);
    let mut back = end;
    let mut left = span;
    for k in 1..points.len() {
        if left <= 0.0 {
            break;
        }
        let d = vector(from_end(k - 1), from_end(k));
        let size = length(d);
        let share = if size > 0.0 {
            min(left / size, 1.0)
        } else {
            1.0
        };
        back = advance(from_end(k - 1), share, d);
        left -= size;
    }
    let chord = vector(back, end);
    let size = length(chord);
    if size == 0.0 {
        return [0.0; 2];
    }
    chord.map(|x| x / size)
}

/// How two ends that face each other are joined.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bridge {
    /// At the corner where both, drawn out, meet.
    Corner(Place),
    /// By their chord.
    Chord,
}

/// Find how lines from p along the unit direction u and from q along v meet: ahead of both, or by
/// their chord where they do not meet so, or turn by more than [`SHARPEST`] has, but run towards
/// each other. None where they do not.
fn find_bridge([p, u]: [Place; 2], [q, v]: [Place; 2]) -> Option<Bridge> {
    let d = vector(p, q);
    let size = length(d);
    let turn = u[0] * v[1] - u[1] * v[0];
    if turn.abs() > 1e-3 && -(u[0] * v[0] + u[1] * v[1]) >= SHARPEST {
        let a = (d[0] * v[1] - d[1] * v[0]) / turn;
        let b = (d[0] * u[1] - d[1] * u[0]) / turn;
        // Nearer to an end than that, the chord is as good.
        if min(a, b) > 1e-3 * size {
            return Some(Bridge::Corner(advance(p, a, u)));
        }
    }
    let ahead = u[0] * d[0] + u[1] * d[1] >= 0.5 * size;
    let back = -(v[0] * d[0] + v[1] * d[1]) >= 0.5 * size;
    (ahead && back).then_some(Bridge::Chord)
}

/// Distances of a place from other segments.
struct Apart {
    /// From one of them.
    one: f64,
    /// From all others.
    others: f64,
}

/// Measure the distances of a place from segment t, and from all segments but s and t.
fn measure_to_others(segments: &Segments, s: usize, t: usize, place: Place) -> Apart {
    let mut apart = Apart {
        one: f64::INFINITY,
        others: f64::INFINITY,
    };
    for r in (0..segments.len()).filter(|&r| r != s) {
        let least = if r == t {
            &mut apart.one
        } else {
            &mut apart.others
        };
        for e in segments.edges(r) {
            *least = min(*least, find_foot(&edge(&segments.points, e), place).away);
        }
    }
    apart
}

/// What an end faces.
#[derive(Clone, Copy, Debug)]
struct Faced {
    /// The other end.
    end: usize,
    /// The corner between them; None for a straight bridge.
    corner: Option<Place>,
}

/// The end nearest to one, and how far it and the next one are.
#[derive(Clone, Copy)]
struct Nearest {
    end: usize,
    least: f64,
    second: f64,
}

/// Find the open end nearest to each open end; None for others.
fn find_nearest_ends(segments: &Segments, open: &[bool]) -> Vec<Option<Nearest>> {
    let opens = || (0..open.len()).filter(|&end| open[end]);
    let mut found = vec![None; open.len()];
    for i in opens() {
        let mut nearest: Option<Nearest> = None;
        for j in opens().filter(|&j| j != i) {
            let away = distance(segments.place(i), segments.place(j));
            match &mut nearest {
                Some(best) if away >= best.least => best.second = min(best.second, away),
                best => {
                    let second = best.map_or(f64::INFINITY, |best| best.least);
                    *best = Some(Nearest {
                        end: j,
                        least: away,
                        second,
                    });
                }
            }
        }
        found[i] = nearest;
    }
    found
}

/// Find what each open end faces within the gap.
fn find_facing(segments: &Segments, open: &[bool], gap: f64) -> Vec<Option<Faced>> {
    let nearest = find_nearest_ends(segments, open);
    let mut faced = vec![None; open.len()];
    for (i, found) in nearest.iter().enumerate() {
        let Some(Nearest {
            end: j,
            least,
            second,
        }) = *found
        else {
            continue;
        };
        let (s, t) = (i >> 1, j >> 1);
        let Some(back) = nearest[j].filter(|back| back.end == i) else {
            continue;
        };
        if j < i || least > gap || s == t || min(second, back.second) < LONE * least {
            continue;
        }
        let (p, q) = (segments.place(i), segments.place(j));
        let (one, two) = (
            measure_to_others(segments, s, t, p),
            measure_to_others(segments, t, s, q),
        );
        if min(one.one, two.one) < BESIDE * least || min(one.others, two.others) < least {
            continue;
        }
        let heading =
            |end: usize| find_heading(segments.points_of(end >> 1), end & 1, SPAN * least);
        let Some(bridge) = find_bridge([p, heading(i)], [q, heading(j)]) else {
            continue;
        };
        let corner = match bridge {
            Bridge::Corner(place) => Some(place),
            Bridge::Chord => None,
        };
        faced[i] = Some(Faced { end: j, corner });
        faced[j] = Some(Faced { end: i, corner });
    }
    faced
}

/// Measure how far along a unit direction from a place the next segment other than s is; infinite
/// if there is none.
fn measure_ahead(segments: &Segments, s: usize, place: Place, [ux, uy]: Place) -> f64 {
    let mut best = f64::INFINITY;
    for r in (0..segments.len()).filter(|&r| r != s) {
        for e in segments.edges(r) {
            let [p, q] = edge(&segments.points, e).map(|end| vector(place, end));
            let (one, two) = (ux * p[1] - uy * p[0], ux * q[1] - uy * q[0]);
            if (one > 0.0) == (two > 0.0) {
                continue;
            }
            let at = advance(p, one / (one - two), vector(p, q));
            let away = ux * at[0] + uy * at[1];
            if 0.0 < away && away < best {
                best = away;
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segments(parts: &[&[Place]]) -> Segments {
        let mut made = Segments::default();
        for part in parts {
            made.points.extend_from_slice(part);
            made.finish_segment(false, [true, false]);
        }
        made
    }

    #[test]
    fn sheets_drawn_out_to_meet_end_at_their_crossing() {
        let made = segments(&[&[[-3.0, 0.0], [0.125, 0.0]], &[[0.0, 3.0], [0.0, -0.125]]]);
        let mended = mend_segments(made, 2.0, 1e-6);
        assert!(mended.is_changed);
        assert_eq!(
            mended.segments.points,
            [[-3.0, 0.0], [0.0, 0.0], [0.0, 3.0]]
        );
        assert_eq!(mended.gap, None);
    }

    #[test]
    fn ends_that_face_each_other_meet_at_a_corner() {
        let made = segments(&[&[[-3.0, 0.0], [-0.0625, 0.0]], &[[0.0, 3.0], [0.0, 0.0625]]]);
        let mended = mend_segments(made, 2.0, 1e-6);
        assert_eq!(
            mended.segments.points,
            [
                [-3.0, 0.0],
                [-0.0625, 0.0],
                [0.0, 0.0],
                [0.0, 0.0625],
                [0.0, 3.0]
            ]
        );
        assert_eq!(mended.segments.rims, [[true; 2]]);
    }

    #[test]
    fn lines_that_run_apart_have_no_bridge() {
        let one = [[0.0, 0.0], [-1.0, 0.0]];
        assert_eq!(find_bridge(one, [[1.0, 0.0], [1.0, 0.0]]), None);
        let towards = [[0.0, 0.0], [1.0, 0.0]];
        assert_eq!(
            find_bridge(towards, [[1.0, 0.0], [-1.0, 0.0]]),
            Some(Bridge::Chord)
        );
    }

    #[test]
    fn trimmed_points_lie_between_two_lengths() {
        let mut result = Vec::new();
        let points = [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]];
        append_trimmed(&points, 1.0, 3.0, &mut result);
        assert_eq!(result, [[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]);
    }
}
