//! The polygon of a rib in its plane: put together from runs, made simple, sampled with normals.
//!
//! Polygons run so that the outside is on their right.

use patterndb_geometry::vector::{max, min};

use super::crossings::{ORIGIN, find_crossing, find_foot};
use super::repair::measure;
use super::walking::{Drawn, Run, floor};
use super::{Edge, Place, advance, distance, edge, length, vector};

/// The share of its last edge that a polygon loses where its two ends would meet.
const SHORTER: f64 = 0.02;

/// Return the place at a length along a segment, in pixels.
fn find_place(drawn: &Drawn<'_>, segment: usize, mut t: f64) -> Place {
    let segments = drawn.segments;
    let (low, high) = (segments.end(segment, 0), segments.end(segment, 1));
    if segments.closed[segment] {
        let whole = drawn.whole(segment);
        t -= floor(t / whole) * whole;
    }
    let behind = drawn.along[low..=high].partition_point(|&along| along <= t);
    let k = (low + behind).saturating_sub(1).clamp(low, high - 1);
    let (from, to) = (drawn.along[k], drawn.along[k + 1]);
    let [p, q] = edge(&segments.points, k);
    let share = find_share(t, from, to);
    if share == 1.0 {
        q
    } else {
        advance(p, share, vector(p, q))
    }
}

/// Return the share of the way between two lengths, 0 to 1, that a length is at.
#[inline(always)]
fn find_share(t: f64, from: f64, to: f64) -> f64 {
    let size = to - from;
    if size > 0.0 {
        min(max((t - from) / size, 0.0), 1.0)
    } else {
        0.0
    }
}

/// Collect the points that runs pass, from within the first run, with those of the changes; with the
/// end of the last run if `with_last`.
pub(super) fn collect_points(drawn: &Drawn<'_>, runs: &[Run], with_last: bool) -> Vec<Place> {
    let segments = drawn.segments;
    let mut result = Vec::new();
    for (r, run) in runs.iter().enumerate() {
        let s = run.segment;
        let is_closed = segments.closed[s];
        let whole = drawn.whole(s);
        if r > 0 {
            result.push(find_place(drawn, s, run.begin));
        }
        let (least, most) = (min(run.begin, run.end), max(run.begin, run.end));
        let mut turn = if is_closed {
            floor(least / whole) * whole
        } else {
            0.0
        };
        let mut numbers = segments.range(s);
        if is_closed {
            numbers.end -= 1;
        }
        let first = result.len();
        while turn <= most {
            for k in numbers.clone() {
                // Runs that begin at a point both go on from there, and one has to take it.
                let place = drawn.along[k] + turn;
                if (least < place && place < most) || (r == 0 && place == run.begin) {
                    result.push(segments.points[k]);
                }
            }
            if !is_closed {
                break;
            }
            turn += whole;
        }
        if run.end < run.begin {
            result[first..].reverse();
        }
        if with_last || r + 1 < runs.len() {
            result.push(find_place(drawn, s, run.end));
        }
    }
    result
}

/// Return points without those within reach of the one before.
pub(super) fn thin_points(points: &[Place], reach: f64) -> Vec<Place> {
    let mut result: Vec<Place> = Vec::with_capacity(points.len());
    for &point in points {
        if result
            .last()
            .is_none_or(|&last| distance(last, point) > reach)
        {
            result.push(point);
        }
    }
    result
}

/// A place of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Nearest {
    /// Its edge, by its first point, and the share of that.
    edge: usize,
    share: f64,
}

/// Find the polygon's place nearest to the origin, and its distance, infinite without edges.
fn find_nearest_place(points: &[Place]) -> (Option<Nearest>, f64) {
    let (mut found, mut least) = (None, f64::INFINITY);
    for (k, pair) in points.windows(2).enumerate() {
        let foot = find_foot(&[pair[0], pair[1]], ORIGIN);
        if foot.away < least {
            least = foot.away;
            found = Some(Nearest {
                edge: k,
                share: foot.share,
            });
        }
    }
    (found, least)
}

/// Return the distance of the origin from a polygon.
pub fn measure_off_backbone(points: &[Place]) -> f64 {
    find_nearest_place(points).1
}

/// Return the share of edge e where edge f crosses it or comes within reach.
#[inline(always)]
fn find_meeting(e: &Edge, f: &Edge, reach: f64) -> Option<f64> {
    for c in 0..2 {
        if max(e[0][c], e[1][c]) + reach < min(f[0][c], f[1][c])
            || min(e[0][c], e[1][c]) - reach > max(f[0][c], f[1][c])
        {
            return None;
        }
    }
    if let Some(share) = find_crossing(e, f) {
        return Some(share);
    }
    for k in 0..2 {
        let foot = find_foot(e, f[k]);
        if foot.away <= reach {
            return Some(foot.share);
        }
        if find_foot(f, e[k]).away <= reach {
            return Some(k as f64);
        }
    }
    None
}

/// Find the first two edges of a polygon, not neighbours, that meet, and the share of the first.
fn find_first_meeting(
    points: &[Place],
    is_closed: bool,
    reach: f64,
) -> Option<(usize, usize, f64)> {
    let n = points.len().saturating_sub(1);
    (0..n).find_map(|e| {
        let one = edge(points, e);
        // Of a closed polygon the last edge goes on to the first.
        let stop = if is_closed && e == 0 { n - 1 } else { n };
        (e + 2..stop)
            .find_map(|f| find_meeting(&one, &edge(points, f), reach).map(|share| (e, f, share)))
    })
}

/// Return a polygon with its loops cut off where it crosses itself, or comes within reach.
///
/// What hangs between the two passes of a crossing goes, unless it goes around something and the
/// place nearest to the origin is there, and not at the crossing: then the two ends go, and a
/// little more of the last, so that they stay apart. A closed polygon, its first point also its
/// last, keeps the longer part.
pub(super) fn cut_loops(mut points: Vec<Place>, is_closed: bool, reach: f64) -> Vec<Place> {
    while let Some((e, f, share)) = find_first_meeting(&points, is_closed, reach) {
        let meeting = advance(points[e], share, vector(points[e], points[e + 1]));
        let mut cut = [&[meeting], &points[e + 1..=f], &[meeting]].concat();
        let rest = [&points[..=e], &[meeting], &points[f + 1..]].concat();
        let kept = if is_closed {
            if measure(&cut) > measure(&rest) {
                cut
            } else {
                rest
            }
        } else if measure_off_backbone(&cut) < measure_off_backbone(&rest) - reach
            && !is_spike(&cut, reach)
        {
            let k = cut.len() - 1;
            let size = distance(cut[k - 1], cut[k]);
            let back = if size > 0.0 {
                min(max(4.0 * reach / size, SHORTER), 1.0)
            } else {
                1.0
            };
            cut[k] = advance(cut[k], back, vector(cut[k], cut[k - 1]));
            cut
        } else {
            rest
        };
        points = thin_points(&kept, reach);
        if is_closed {
            close(&mut points);
        }
    }
    points
}

/// Set the last point of a polygon to its first.
pub(super) fn close(points: &mut [Place]) {
    if let [first, .., last] = points {
        *last = *first;
    }
}

/// Return whether a loop goes out and back the same way.
fn is_spike(cut: &[Place], reach: f64) -> bool {
    let mut area = 0.0;
    for pair in cut.windows(2) {
        let (p, q) = (vector(cut[0], pair[0]), vector(cut[0], pair[1]));
        area += p[0] * q[1];
        area -= p[1] * q[0];
    }
    f64::abs(area) <= 2.0 * reach * measure(cut)
}

/// Return the unit normals to the right: the mean of the two edges' normals, by their lengths.
///
/// A rounded edge keeps the normals of the flat sides that it joins. Where a polygon turns right
/// back, the normal of the edge before.
fn compute_normals(points: &[Place], is_closed: bool) -> Vec<Place> {
    let n = points.len();
    let mut normals = vec![[0.0; 2]; n];
    for k in 0..n - 1 {
        let [dx, dy] = vector(points[k], points[k + 1]);
        for normal in &mut normals[k..=k + 1] {
            normal[0] += dy;
            normal[1] -= dx;
        }
    }
    if is_closed {
        let last = normals[n - 1];
        normals[0] = [normals[0][0] + last[0], normals[0][1] + last[1]];
        normals[n - 1] = normals[0];
    }
    for (v, normal) in normals.iter_mut().enumerate() {
        let k = v.saturating_sub(1);
        let [dx, dy] = vector(points[k], points[k + 1]);
        let mut size = length(*normal);
        let edge = length([dx, dy]);
        if size <= 1e-9 * edge {
            (*normal, size) = ([dy, -dx], edge);
        }
        *normal = normal.map(|x| x / size);
    }
    normals
}

/// Samples of a polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// The samples.
    pub places: Vec<Place>,
    /// Unit normals to the right.
    pub normals: Vec<Place>,
    /// The number of the sample nearest to the origin.
    pub nearest: Option<usize>,
}

/// Sample a polygon of two or more points at equal arc length.
///
/// A closed polygon is cut open opposite the origin. Normals are interpolated along edges between
/// those of the vertices: feature curve recovery paper, section 4.3.3.
pub fn sample_polygon(points: &[Place], is_closed: bool, count: usize) -> Samples {
    let n = points.len();
    let mut along = vec![0.0; n];
    for k in 1..n {
        along[k] = along[k - 1] + distance(points[k - 1], points[k]);
    }
    let whole = along[n - 1];
    let normals = compute_normals(points, is_closed);
    let begin = match find_nearest_place(points).0 {
        Some(Nearest { edge: k, share }) if is_closed => {
            along[k] + share * (along[k + 1] - along[k]) + 0.5 * whole
        }
        _ => 0.0,
    };
    let mut samples = Samples {
        places: Vec::with_capacity(count),
        normals: Vec::with_capacity(count),
        nearest: None,
    };
    let mut least = f64::INFINITY;
    let mut k = 0;
    for i in 0..count {
        let mut t = begin + whole * i as f64 / (count - 1) as f64;
        if is_closed {
            t -= floor(t / whole) * whole;
            if k > 0 && t < along[k] {
                k = 0;
            }
        }
        while k + 2 < n && along[k + 1] < t {
            k += 1;
        }
        let s = find_share(t, along[k], along[k + 1]);
        let between =
            |values: &[Place]| [0, 1].map(|c| (1.0 - s) * values[k][c] + s * values[k + 1][c]);
        let (place, direction) = (between(points), between(&normals));
        let size = length(direction);
        samples.places.push(place);
        samples.normals.push(if size <= 1e-9 {
            normals[k]
        } else {
            direction.map(|x| x / size)
        });
        let away = length(place);
        if away < least {
            least = away;
            samples.nearest = Some(i);
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_is_cut_off() {
        let points = vec![[0.0, 1.0], [3.0, 1.0], [3.0, 2.0], [2.0, 2.0], [2.0, 0.0]];
        let cut = cut_loops(points, false, 1e-9);
        assert_eq!(cut, [[0.0, 1.0], [2.0, 1.0], [2.0, 0.0]]);
    }

    #[test]
    fn thinned_points_are_apart() {
        let points = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.5, 0.0]];
        assert_eq!(thin_points(&points, 0.6), [[0.0, 0.0], [1.0, 0.0]]);
    }

    #[test]
    fn samples_of_a_square_are_evenly_spaced_and_face_outward() {
        let square = [
            [1.0, 1.0],
            [-1.0, 1.0],
            [-1.0, -1.0],
            [1.0, -1.0],
            [1.0, 1.0],
        ];
        let samples = sample_polygon(&square, true, 9);
        assert_eq!(samples.places.len(), 9);
        assert_eq!(samples.places[0], samples.places[8]);
        for (place, normal) in samples.places.iter().zip(&samples.normals) {
            assert_eq!(place[0].abs().max(place[1].abs()), 1.0);
            assert!(place[0] * normal[0] + place[1] * normal[1] > 0.0);
            assert!((length(*normal) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn an_open_polygon_keeps_its_ends() {
        let line = [[-2.0, 1.0], [2.0, 1.0]];
        let samples = sample_polygon(&line, false, 5);
        assert_eq!((samples.places[0], samples.places[4]), (line[0], line[1]));
        assert_eq!(samples.nearest, Some(2));
        assert_eq!(samples.normals, [[0.0, -1.0]; 5]);
    }
}
