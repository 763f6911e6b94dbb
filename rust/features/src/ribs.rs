//! Ribs: the outlines of a model in planes across a curve, whatever the model's state.
//!
//! [`slicing`] cuts edges out of triangles and joins them to segments, [`crossings`] finds how
//! segments cross and touch, [`repair`] takes off what hangs over and bridges gaps. What is still
//! tangled is drawn as a picture ([`raster`]) whose outer contour is followed along the segments
//! ([`walking`]). [`polygon`] makes the outline simple and samples it, and [`rib`] puts these
//! together.

pub mod crossings;
pub mod polygon;
pub mod raster;
pub mod repair;
pub mod rib;
pub mod slicing;
pub mod walking;

use std::ops::Range;

/// A place in a plane, or a vector: x, y.
pub type Place = [f64; 2];

/// A straight edge from one place to another.
pub type Edge = [Place; 2];

/// Polylines in a plane, of two or more points each.
#[derive(Clone, Debug, PartialEq)]
pub struct Segments {
    /// The points of all segments; a closed one ends with its first point.
    pub points: Vec<Place>,
    /// Segment s has the points `offsets[s]..offsets[s + 1]`.
    pub offsets: Vec<usize>,
    /// Whether each segment is closed.
    pub closed: Vec<bool>,
    /// Whether each segment's first and last point lie on the circle that slices end at.
    pub rims: Vec<[bool; 2]>,
}

impl Default for Segments {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            offsets: vec![0],
            closed: Vec::new(),
            rims: Vec::new(),
        }
    }
}

impl Segments {
    /// Return how many segments there are.
    pub fn len(&self) -> usize {
        self.closed.len()
    }

    /// Return whether there are no segments.
    pub fn is_empty(&self) -> bool {
        self.closed.is_empty()
    }

    /// Return the numbers of a segment's points.
    fn range(&self, segment: usize) -> Range<usize> {
        self.offsets[segment]..self.offsets[segment + 1]
    }

    /// Return the first points of a segment's edges.
    fn edges(&self, segment: usize) -> Range<usize> {
        let Range { start, end } = self.range(segment);
        start..end.saturating_sub(1)
    }

    /// Return the points of a segment.
    fn points_of(&self, segment: usize) -> &[Place] {
        &self.points[self.range(segment)]
    }

    /// Return the number of a segment's first (side 0) or last point.
    fn end(&self, segment: usize, side: usize) -> usize {
        if side == 0 {
            self.offsets[segment]
        } else {
            self.offsets[segment + 1] - 1
        }
    }

    /// Return whether a segment has an end on a side that is not on the circle.
    fn has_end(&self, segment: usize, side: usize) -> bool {
        !self.closed[segment] && !self.rims[segment][side]
    }

    /// Take the points since the last segment as the next one.
    fn finish_segment(&mut self, closed: bool, rims: [bool; 2]) {
        self.offsets.push(self.points.len());
        self.closed.push(closed);
        self.rims.push(rims);
    }

    /// Return the segments of some numbers alone.
    fn pick(&self, kept: &[usize]) -> Segments {
        let mut result = Segments::default();
        for &s in kept {
            result.points.extend_from_slice(self.points_of(s));
            result.finish_segment(self.closed[s], self.rims[s]);
        }
        result
    }
}

/// Return the edge from point k to the next.
#[inline(always)]
fn edge(points: &[Place], k: usize) -> Edge {
    [points[k], points[k + 1]]
}

/// Return `b - a`.
#[inline(always)]
fn vector([ax, ay]: Place, [bx, by]: Place) -> Place {
    [bx - ax, by - ay]
}

/// Return the length of a vector.
#[inline(always)]
fn length([x, y]: Place) -> f64 {
    x.hypot(y)
}

/// Return the distance between two places.
#[inline(always)]
fn distance(a: Place, b: Place) -> f64 {
    length(vector(a, b))
}

/// Return the place at a share of the way from a along a vector.
#[inline(always)]
fn advance([x, y]: Place, share: f64, [dx, dy]: Place) -> Place {
    [x + share * dx, y + share * dy]
}
