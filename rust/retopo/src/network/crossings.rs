//! Where a curve crosses the chains of a network, or itself.
//!
//! Two segments cross if each has its ends on both sides of the other, seen along the other's
//! normal, and their gap is small.

use patterndb_geometry::Point;
use patterndb_geometry::tree::Bounds;
use patterndb_geometry::vector::{cross, dot, length, max, min, subtract};

use super::samples::Samples;

/// Segments whose places nearest to each other, seen along the normals, are further apart than this
/// part of their lengths do not cross: on a curved surface, where the two normals differ, nearly
/// parallel ones may seem to.
const BESIDE: f64 = 0.25;

/// A polyline with the surface's normals at its points.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    /// The points.
    pub points: &'a [Point],
    /// The normals.
    pub normals: &'a [Point],
}

impl<'a> Line<'a> {
    /// Return the segment from one point to another.
    fn segment(&self, from: usize, to: usize) -> Segment<'a> {
        Segment {
            ends: [&self.points[from], &self.points[to]],
            normals: [&self.normals[from], &self.normals[to]],
        }
    }
}

/// A crossing of a line: its place on it, the number of the chain and the place there, both places
/// in samples, and 1 if it is from the left to the right of the chain, else 0.
pub type Crossing = [f64; 4];

/// A segment with the surface's normals at its ends.
#[derive(Clone, Copy, Debug)]
struct Segment<'a> {
    ends: [&'a Point; 2],
    normals: [&'a Point; 2],
}

/// Where two segments cross.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Meeting {
    /// The part of the first segment up to the crossing.
    on_first: f64,
    /// The part of the second.
    on_second: f64,
    /// Whether the first crosses the second from left to right.
    rightward: bool,
}

impl Segment<'_> {
    /// Return the length.
    fn size(&self) -> f64 {
        apart(self.ends[0], self.ends[1])
    }

    /// Return the sum of the normals.
    fn normal(&self) -> Point {
        let [a, b] = self.normals;
        [0, 1, 2].map(|c| a[c] + b[c])
    }

    /// Return the place at a part of the segment.
    fn place(&self, share: f64) -> Point {
        let [a, b] = self.ends;
        [0, 1, 2].map(|c| a[c] + share * (b[c] - a[c]))
    }

    /// Return how far a point is left of the segment, seen against a normal; scaled.
    fn side_of(&self, normal: &Point, point: &Point) -> f64 {
        let along = subtract(self.ends[1], self.ends[0]);
        let away = subtract(point, self.ends[0]);
        dot(normal, &cross(&along, &away))
    }

    /// Return whether two segments are further apart than a distance along one of the axes.
    fn is_apart(&self, other: &Segment<'_>, far: f64) -> bool {
        let ([a, b], [p, q]) = (self.ends, other.ends);
        (0..3).any(|c| {
            max(a[c], b[c]) + far < min(p[c], q[c]) || min(a[c], b[c]) - far > max(p[c], q[c])
        })
    }

    /// Return where the segment crosses another.
    fn meet(&self, other: &Segment<'_>) -> Option<Meeting> {
        let (m, n) = (self.normal(), other.normal());
        if dot(&m, &n) <= 0.0 {
            return None;
        }
        let [a, b] = self.ends.map(|end| other.side_of(&n, end));
        if (a >= 0.0) == (b >= 0.0) {
            return None;
        }
        let [c, d] = other.ends.map(|end| self.side_of(&m, end));
        if (c >= 0.0) == (d >= 0.0) {
            return None;
        }
        let (s, u) = (a / (a - b), c / (c - d));
        let far = self.size() + other.size();
        let gap = subtract(&self.place(s), &other.place(u));
        let squared = dot(&gap, &gap);
        let up = [0, 1, 2].map(|k| m[k] + n[k]);
        let lifted = dot(&gap, &up);
        let across = lifted * lifted / dot(&up, &up);
        let beside = max(squared - across, 0.0).sqrt();
        (squared.sqrt() <= far && beside <= BESIDE * far).then_some(Meeting {
            on_first: s,
            on_second: u,
            rightward: a >= 0.0,
        })
    }
}

/// Return how far apart two points are.
fn apart(a: &Point, b: &Point) -> f64 {
    length(&subtract(b, a))
}

/// Return the box of one point or more.
fn bound(points: &[Point]) -> Bounds {
    let first = [points[0]; 2];
    points[1..].iter().fold(first, |[low, high], point| {
        [
            [0, 1, 2].map(|c| min(low[c], point[c])),
            [0, 1, 2].map(|c| max(high[c], point[c])),
        ]
    })
}

/// Return whether a segment is further than a distance from a box along one of the axes.
fn is_beyond([low, high]: &Bounds, [a, b]: [&Point; 2], reach: f64) -> bool {
    (0..3).any(|c| {
        let (least, most) = if a[c] > b[c] {
            (b[c], a[c])
        } else {
            (a[c], b[c])
        };
        least > high[c] + reach || most < low[c] - reach
    })
}

/// Return the length of the longest step between neighbouring points, 0 without.
fn longest_step(points: &[Point]) -> f64 {
    let steps = points.windows(2).map(|pair| apart(&pair[0], &pair[1]));
    steps.fold(0.0, max)
}

/// Return the crossing of a line's segment and another, which begin at these places in samples.
fn record(meeting: Meeting, at: usize, chain: usize, place: usize) -> Crossing {
    [
        at as f64 + meeting.on_first,
        chain as f64,
        place as f64 + meeting.on_second,
        f64::from(u8::from(meeting.rightward)),
    ]
}

/// Return where a line crosses chains.
pub fn cross_chains(line: Line<'_>, of: &Samples<'_>) -> Vec<Crossing> {
    let mut found = Vec::new();
    if line.points.len() < 2 {
        return found;
    }
    let chains = Line {
        points: of.points,
        normals: of.normals,
    };
    let whole = bound(line.points);
    let longest = longest_step(line.points);
    let mut near: Vec<(usize, Segment<'_>)> = Vec::new();
    for (number, span) in of.chains().enumerate() {
        let chain = &of.points[span.first..span.end];
        let (Some(first), Some(last)) = (chain.first(), chain.last()) else {
            continue;
        };
        let bounds = bound(chain);
        let mut reach = max(longest, longest_step(chain)) + longest;
        if span.loose {
            reach = max(reach, longest + apart(last, first));
        }
        if is_beyond(&whole, [&bounds[0], &bounds[1]], reach) {
            continue;
        }
        let segments = (0..line.points.len() - 1).map(|e| (e, line.segment(e, e + 1)));
        near.clear();
        near.extend(segments.filter(|(_, segment)| !is_beyond(&bounds, segment.ends, reach)));
        if near.is_empty() {
            continue;
        }
        for (k, j) in span.segments() {
            let other = chains.segment(k, j);
            let far = longest + other.size();
            if is_beyond(&whole, other.ends, far) {
                continue;
            }
            for (e, segment) in &near {
                if segment.is_apart(&other, far) {
                    continue;
                }
                if let Some(meeting) = segment.meet(&other) {
                    found.push(record(meeting, *e, number, k - span.first));
                }
            }
        }
    }
    found
}

/// Return where a line crosses itself: the later place, 0, the earlier place, and 1 if the later
/// part goes to the earlier's right.
///
/// aside: the points of the line a little off, so that neither part lies on the other. closed: the
/// last point is the first once more.
pub fn cross_itself(line: Line<'_>, aside: &[Point], closed: bool) -> Vec<Crossing> {
    let later = Line {
        points: aside,
        normals: line.normals,
    };
    let sizes: Vec<f64> = line
        .points
        .windows(2)
        .map(|pair| apart(&pair[0], &pair[1]))
        .collect();
    let m = sizes.len();
    let mut found = Vec::new();
    for f in 0..m {
        let earlier = line.segment(f, f + 1);
        for e in f + 2..m {
            if closed && f == 0 && e == m - 1 {
                continue;
            }
            if line
                .segment(e, e + 1)
                .is_apart(&earlier, sizes[f] + sizes[e])
            {
                continue;
            }
            if let Some(meeting) = later.segment(e, e + 1).meet(&earlier) {
                found.push(record(meeting, e, 0, f));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: [Point; 5] = [[0.0, 0.0, 1.0]; 5];

    #[test]
    fn a_line_crosses_a_chain_and_a_ring() {
        let points = [
            [1.0, -1.0, 0.0],
            [1.0, 1.0, 0.0],
            [3.0, 1.0, 0.0],
            [5.0, 1.0, 0.0],
            [4.0, -1.0, 0.0],
        ];
        let of = Samples {
            points: &points,
            normals: &UP,
            starts: &[0, 2, 5],
            loose: &[false, true],
        };
        let line = Line {
            points: &[[0.0; 3], [2.0, 0.0, 0.0], [6.0, 0.0, 0.0]],
            normals: &UP[..3],
        };
        let found = cross_chains(line, &of);
        let expected = [
            [0.5, 0.0, 0.5, 1.0],
            [1.625, 1.0, 1.5, 0.0],
            [1.375, 1.0, 2.5, 1.0],
        ];
        assert_eq!(found, expected);
        let below = Line {
            normals: &[[0.0, 0.0, -1.0]; 3],
            ..line
        };
        assert!(cross_chains(below, &of).is_empty());
    }

    #[test]
    fn a_line_crosses_itself_once() {
        let points = [
            [0.0; 3],
            [2.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, -1.0, 0.0],
        ];
        let line = Line {
            points: &points,
            normals: &UP,
        };
        let found = cross_itself(line, &points, false);
        assert_eq!(found, [[3.5, 0.0, 0.5, 1.0]]);
    }
}
