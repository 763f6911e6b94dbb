//! All points of all chains, and the place on them that is nearest to a point.

use patterndb_geometry::Point;
use patterndb_geometry::vector::{dot, max, min, subtract};

/// The points of chains, one chain after the other.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// The points.
    pub points: &'a [Point],
    /// The surface's normals there.
    pub normals: &'a [Point],
    /// The first sample of each chain, and the number of samples.
    pub starts: &'a [i32],
    /// Whether each chain is closed, without a node.
    pub loose: &'a [bool],
}

/// The samples of one chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainSpan {
    /// The first sample.
    pub first: usize,
    /// The one behind the last.
    pub end: usize,
    /// Whether the chain is closed.
    pub loose: bool,
}

impl ChainSpan {
    /// Return the segments, by the samples that they join; that which closes a chain is the last.
    #[inline]
    pub fn segments(self) -> impl Iterator<Item = (usize, usize)> {
        let ChainSpan { first, end, loose } = self;
        let n_segments = if loose {
            end - first
        } else {
            (end - first).saturating_sub(1)
        };
        (first..first + n_segments).map(move |k| (k, if k + 1 == end { first } else { k + 1 }))
    }
}

impl<'a> Samples<'a> {
    /// Return the samples of each chain.
    pub fn chains(&self) -> impl Iterator<Item = ChainSpan> + 'a {
        let bounds = self.starts.windows(2);
        bounds.zip(self.loose).map(|(bounds, &loose)| ChainSpan {
            first: bounds[0] as usize,
            end: bounds[1] as usize,
            loose,
        })
    }
}

/// A place on a segment, and how far it is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPlace {
    /// The segment's first sample; -1 for none.
    pub sample: i64,
    /// The part of the segment up to the place.
    pub share: f64,
    /// Its distance, infinite for none.
    pub distance: f64,
}

/// Return the nearest place on chains where the surface's normal agrees with one.
pub fn find_nearest(of: &Samples<'_>, at: &Point, up: &Point) -> NearestPlace {
    let mut best = f64::INFINITY;
    let mut sample = -1;
    let mut share = 0.0;
    let mut look = |first: usize, ends: [&Point; 2], normals: [&Point; 2]| {
        if let Some((part, distance)) = measure_segment(ends, normals, at, up)
            && distance < best
        {
            best = distance;
            sample = first as i64;
            share = part;
        }
    };
    for ChainSpan { first, end, loose } in of.chains() {
        let (points, normals) = (&of.points[first..end], &of.normals[first..end]);
        let segments = points.windows(2).zip(normals.windows(2));
        for (k, (ends, normals)) in segments.enumerate() {
            look(first + k, [&ends[0], &ends[1]], [&normals[0], &normals[1]]);
        }
        if loose && end > first {
            let ends = [end - 1, first];
            look(
                end - 1,
                ends.map(|k| &of.points[k]),
                ends.map(|k| &of.normals[k]),
            );
        }
    }
    NearestPlace {
        sample,
        share,
        distance: best.sqrt(),
    }
}

/// Return the part of a segment up to the place on it that is nearest to a point, and the squared
/// distance; None where the surface's normals do not agree.
#[inline(always)]
fn measure_segment(
    [from, to]: [&Point; 2],
    normals: [&Point; 2],
    at: &Point,
    up: &Point,
) -> Option<(f64, f64)> {
    let normal = [0, 1, 2].map(|c| normals[0][c] + normals[1][c]);
    if dot(&normal, up) <= 0.0 {
        return None;
    }
    let step = subtract(to, from);
    // Adding 0 makes 0 of -0.
    let along = 0.0 + dot(&step, &subtract(at, from));
    let size = dot(&step, &step);
    let share = if size > 0.0 {
        min(max(along / size, 0.0), 1.0)
    } else {
        0.0
    };
    let away = [0, 1, 2].map(|c| from[c] + share * step[c] - at[c]);
    Some((share, dot(&away, &away)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_chains_have_a_closing_segment() {
        let points = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [9.0, 9.0, 0.0],
            [8.0, 9.0, 0.0],
            [8.0, 8.0, 0.0],
        ];
        let of = Samples {
            points: &points,
            normals: &[[0.0, 0.0, 1.0]; 5],
            starts: &[0, 2, 5],
            loose: &[false, true],
        };
        let segments: Vec<_> = of.chains().flat_map(ChainSpan::segments).collect();
        assert_eq!(segments, [(0, 1), (2, 3), (3, 4), (4, 2)]);
        let up = [0.0, 0.0, 1.0];
        let found = find_nearest(&of, &[0.25, -2.0, 0.0], &up);
        assert_eq!((found.sample, found.share, found.distance), (0, 0.25, 2.0));
        let found = find_nearest(&of, &[9.0, 8.0, 0.0], &up);
        assert_eq!((found.sample, found.share), (4, 0.5));
        let found = find_nearest(&of, &[9.0, 8.0, 0.0], &[0.0, 0.0, -1.0]);
        assert_eq!((found.sample, found.distance), (-1, f64::INFINITY));
    }
}
