//! What lines hit of triangles, down their tree.
//!
//! Two ways, by the hits that are wanted. [`first_along`] returns the hits of one side of a clean
//! surface, both ways along a normal. [`first_hits`] and [`all_hits`] return those of both sides, and
//! lose none between two triangles, for surfaces of any quality. They differ in what they do at the
//! rims of triangles, and their numbers are part of results.

use crate::proximity::{Weights, to_box};
use crate::tree::{Bounds, Search, Tree, Triangle};
use crate::vector::{Point, cross, dot, length, max, min, subtract};

/// Barycentric coordinates this far below 0 still count as a hit: a line through an edge hits one of
/// its two triangles.
const SLACK: f64 = 1e-9;

/// A line whose direction has a component below this runs across that axis.
const ACROSS: f64 = 1e-300;

/// Boxes are this much wider for lines, as a share of the farthest coordinate from where the line
/// begins: a hit at the rim of a triangle is not lost to rounding.
const ROUNDING: f64 = 1e-13;

/// Of the parameters of a line inside a box this part of the last is added: boxes of triangles
/// across the axes are flat, and rounding must not make them empty.
const FLAT: f64 = 1e-12;

/// The triangle of a hit, -1 without one, and the weights of its corners there.
type Hit = (i32, [f64; 3]);

/// No hit.
const MISSED: Hit = (-1, [0.0; 3]);

/// A line, or a ray that begins where the line does.
#[derive(Clone, Copy)]
struct Line<'a> {
    start: &'a Point,
    direction: &'a Point,
}

impl<'a> Line<'a> {
    fn each(starts: &'a [Point], directions: &'a [Point]) -> impl Iterator<Item = Line<'a>> {
        let pairs = starts.iter().zip(directions);
        pairs.map(|(start, direction)| Line { start, direction })
    }

    /// Return the part of the parameters `from..to` for which the line is in a box; None if it
    /// misses the box along an axis that the line runs across.
    #[inline(always)]
    fn clip(&self, [lower, upper]: &Bounds, mut from: f64, mut to: f64) -> Option<(f64, f64)> {
        for c in 0..3 {
            let (x, d) = (self.start[c], self.direction[c]);
            if d.abs() < ACROSS {
                if x < lower[c] || x > upper[c] {
                    return None;
                }
            } else {
                let (one, other) = ((lower[c] - x) / d, (upper[c] - x) / d);
                from = max(from, min(one, other));
                to = min(to, max(one, other));
            }
        }
        Some((from, to))
    }

    /// As [`Line::clip`], without bounds; the box is wider by `pad` on all sides.
    #[inline(always)]
    fn clip_padded(&self, [lower, upper]: &Bounds, pad: f64) -> Option<(f64, f64)> {
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        for c in 0..3 {
            let below = lower[c] - self.start[c] - pad;
            let above = upper[c] - self.start[c] + pad;
            let d = self.direction[c];
            if d.abs() < ACROSS {
                if below > 0.0 || above < 0.0 {
                    return None;
                }
            } else {
                from = max(from, min(below / d, above / d));
                to = min(to, max(below / d, above / d));
            }
        }
        Some((from, to))
    }

    /// Return how much wider boxes are for the line, by the box around everything.
    fn pad(&self, bounds: &Bounds) -> f64 {
        let mut far = 0.0;
        for c in 0..3 {
            for corner in bounds {
                far = max(far, (corner[c] - self.start[c]).abs());
            }
        }
        ROUNDING * far
    }
}

/// The plane of a triangle, as a line meets it.
struct Plane {
    /// From the first corner to the second and to the third.
    edges: [Point; 2],
    /// From the line's start to the first corner.
    corner: Point,
    /// Twice the triangle's area long.
    normal: Point,
    size: f64,
    /// The normal's part along the line.
    facing: f64,
}

impl Plane {
    #[inline(always)]
    fn new(triangle: &Triangle, line: &Line) -> Plane {
        let [a, b, c] = triangle;
        let edges = [subtract(b, a), subtract(c, a)];
        let normal = cross(&edges[0], &edges[1]);
        Plane {
            edges,
            corner: subtract(a, line.start),
            normal,
            size: length(&normal),
            facing: dot(&normal, line.direction),
        }
    }

    /// Return the line's parameter in the plane, by Cramer's rule for corner + v u + w v = start +
    /// s direction.
    #[inline(always)]
    fn parameter(&self) -> f64 {
        dot(&self.corner, &self.normal) / self.facing
    }

    /// Return the weights of the place at a parameter; None outside the triangle.
    #[inline(always)]
    fn weights(&self, line: &Line, s: f64) -> Option<Weights> {
        let [u, v] = &self.edges;
        let p = [0, 1, 2].map(|c| s * line.direction[c] - self.corner[c]);
        let scale = self.size * self.size;
        let third = dot(&cross(u, &p), &self.normal) / scale;
        let second = dot(&cross(&p, v), &self.normal) / scale;
        let outside = second < -SLACK || third < -SLACK || second + third > 1.0 + SLACK;
        (!outside).then_some(Weights {
            v: second,
            w: third,
        })
    }
}

/// Move a place onto its triangle, which SLACK may have let it leave; return all weights.
#[inline(always)]
fn onto_triangle(found: Weights) -> [f64; 3] {
    let v = min(max(found.v, 0.0), 1.0);
    let w = min(max(found.w, 0.0), 1.0 - v);
    Weights { v, w }.all()
}

struct Along<'a> {
    corners: &'a [Triangle],
    line: Line<'a>,
    /// How far the hit may be, then how far the nearest one is.
    best: f64,
    hit: Hit,
}

impl Search for Along<'_> {
    #[inline(always)]
    fn measure(&self, bounds: &Bounds) -> f64 {
        to_box(bounds, self.line.start)
    }

    #[inline(always)]
    fn is_beyond(&self, bounds: &Bounds, far: f64) -> bool {
        if far > self.best * self.best {
            return true;
        }
        let within = self.line.clip(bounds, -self.best, self.best);
        !within.is_some_and(|(from, to)| from <= to + FLAT * (1.0 + to.abs()))
    }

    #[inline(always)]
    fn visit(&mut self, triangle: i32) {
        let plane = Plane::new(&self.corners[triangle as usize], &self.line);
        if plane.facing <= 1e-6 * plane.size {
            return;
        }
        let s = plane.parameter();
        if s.abs() >= self.best {
            return;
        }
        if let Some(weights) = plane.weights(&self.line, s) {
            self.best = s.abs();
            self.hit = (triangle, onto_triangle(weights));
        }
    }
}

/// Return, of the hits of each line, the one nearest to its start, both ways along.
///
/// `reach` is how far each may be. Triangles that face away from the direction are not seen.
pub fn first_along(
    tree: &Tree,
    starts: &[Point],
    directions: &[Point],
    reach: &[f64],
) -> (Vec<i32>, Vec<[f64; 3]>) {
    let mut stack = Vec::new();
    let find = |(line, &reach)| {
        let mut search = Along {
            corners: tree.corners,
            line,
            best: reach,
            hit: MISSED,
        };
        tree.search(&mut stack, &mut search);
        search.hit
    };
    Line::each(starts, directions).zip(reach).map(find).unzip()
}

/// A line made an axis, to look at triangles along it.
///
/// Source: Woop, Benthin and Wald 2013, "Watertight ray/triangle intersection": a triangle's edges
/// are looked at from the origin of the plane across the line. What one triangle sees of an edge is
/// exactly the negative of what its neighbour sees: no line slips between them.
struct Axis<'a> {
    line: Line<'a>,
    /// The axis of space nearest to the line.
    nearest: usize,
    /// Where the line begins, turned by [`Axis::turn`].
    start: Point,
    /// How far the line goes along the other axes while it goes 1 along the nearest.
    shear: [f64; 2],
}

impl<'a> Axis<'a> {
    fn new(line: Line<'a>) -> Axis<'a> {
        let size = |c: usize| line.direction[c].abs();
        let nearest = (1..3).fold(0, |z, c| if size(c) > size(z) { c } else { z });
        let mut axis = Axis {
            line,
            nearest,
            start: *line.start,
            shear: [0.0; 2],
        };
        let [x, y, z] = axis.turn(line.direction);
        axis.start = axis.turn(line.start);
        axis.shear = [x / z, y / z];
        axis
    }

    /// Return coordinates in another order, that of the nearest axis last.
    #[inline(always)]
    fn turn(&self, [x, y, z]: &Point) -> Point {
        match self.nearest {
            0 => [*y, *z, *x],
            1 => [*z, *x, *y],
            _ => [*x, *y, *z],
        }
    }

    /// Return a point as seen along the line, and how far along the nearest axis it is.
    #[inline(always)]
    fn look(&self, point: &Point) -> Point {
        let [x, y, far] = subtract(&self.turn(point), &self.start);
        [x - self.shear[0] * far, y - self.shear[1] * far, far]
    }

    /// Return where along the line, in lengths of its direction, it hits a triangle, and the weights
    /// of the hit.
    #[inline(always)]
    fn hit(&self, triangle: &Triangle) -> Option<(f64, [f64; 3])> {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = triangle.each_ref().map(|p| self.look(p));
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let total = u + v + w;
        if total == 0.0 {
            return None;
        }
        let weights = [u / total, v / total, w / total];
        let far = weights[0] * az + weights[1] * bz + weights[2] * cz;
        let s = far / self.line.direction[self.nearest];
        (!s.is_nan()).then_some((s, weights))
    }
}

struct First<'a> {
    corners: &'a [Triangle],
    axis: Axis<'a>,
    pad: f64,
    best: f64,
    hit: Hit,
}

impl Search for First<'_> {
    /// How far along the ray the box is; infinite where the ray misses it.
    #[inline(always)]
    fn measure(&self, bounds: &Bounds) -> f64 {
        match self.axis.line.clip_padded(bounds, self.pad) {
            Some((from, to)) if from <= to && to >= 0.0 => from,
            _ => f64::INFINITY,
        }
    }

    #[inline(always)]
    fn is_beyond(&self, _: &Bounds, far: f64) -> bool {
        far > self.best || far == f64::INFINITY
    }

    #[inline(always)]
    fn visit(&mut self, triangle: i32) {
        let Some((s, weights)) = self.axis.hit(&self.corners[triangle as usize]) else {
            return;
        };
        // Of triangles hit at once, at an edge, the first by number.
        if s >= 0.0 && (s < self.best || (s == self.best && triangle < self.hit.0)) {
            self.best = s;
            self.hit = (triangle, weights);
        }
    }
}

/// The first hits of rays, an entry for each ray.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FirstHits {
    /// Triangle, -1 without a hit.
    pub triangle: Vec<i32>,
    /// Weights of the triangle's corners.
    pub weights: Vec<[f64; 3]>,
    /// How far along the ray, infinite without a hit.
    pub along: Vec<f64>,
}

/// Return the first hit of every ray.
pub fn first_hits(tree: &Tree, starts: &[Point], directions: &[Point]) -> FirstHits {
    let mut stack = Vec::new();
    let mut found = FirstHits::default();
    for ray in Line::each(starts, directions) {
        let mut search = First {
            corners: tree.corners,
            axis: Axis::new(ray),
            pad: ray.pad(&tree.boxes[0]),
            best: f64::INFINITY,
            hit: MISSED,
        };
        tree.search(&mut stack, &mut search);
        found.triangle.push(search.hit.0);
        found.weights.push(search.hit.1);
        found.along.push(search.best);
    }
    found
}

/// The hits of lines, an entry for each hit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hits {
    /// Number of the line, ascending.
    pub line: Vec<i32>,
    /// Triangle.
    pub triangle: Vec<i32>,
    /// Weights of the triangle's corners.
    pub weights: Vec<[f64; 3]>,
    /// How far along the line, in lengths of its direction.
    pub along: Vec<f64>,
}

/// Return all hits of lines, of both sides; those of one line are in no order.
pub fn all_hits(tree: &Tree, starts: &[Point], directions: &[Point]) -> Hits {
    let mut stack = Vec::new();
    let mut found = Hits::default();
    for (i, line) in Line::each(starts, directions).enumerate() {
        let axis = Axis::new(line);
        let pad = line.pad(&tree.boxes[0]);
        let is_met = |bounds: &Bounds| {
            line.clip_padded(bounds, pad)
                .is_some_and(|(from, to)| from <= to)
        };
        for triangle in tree.select(&mut stack, is_met) {
            if let Some((s, weights)) = axis.hit(&tree.corners[triangle as usize]) {
                found.line.push(i as i32);
                found.triangle.push(triangle);
                found.weights.push(weights);
                found.along.push(s);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::build;
    use crate::tree::tests::lattice;

    const UP: Point = [0.0, 0.0, 1.0];

    /// The middle of the lattice's triangle 13 of 25, at height 13, from 2 above it.
    const ABOVE: Point = [3.2, 2.2, 15.0];

    #[test]
    fn a_line_down_hits_the_triangle_below() {
        let corners = lattice(5);
        let made = build(&corners);
        let tree = made.tree(&corners);
        let (triangle, weights) = first_along(&tree, &[ABOVE], &[UP], &[2.5]);
        assert_eq!(triangle, [13]);
        assert!((weights[0][1] - 0.4).abs() < 1e-12);
        assert_eq!(first_along(&tree, &[ABOVE], &[UP], &[1.5]).0, [-1]);
        let hits = first_hits(&tree, &[ABOVE, ABOVE], &[[0.0, 0.0, -2.0], UP]);
        assert_eq!(hits.triangle, [13, -1]);
        assert_eq!(hits.along, [1.0, f64::INFINITY]);
        let hits = all_hits(&tree, &[ABOVE], &[UP]);
        assert_eq!((hits.line, hits.triangle), (vec![0], vec![13]));
        assert_eq!(hits.along, [-2.0]);
    }

    #[test]
    fn no_line_slips_between_two_triangles() {
        let square = [
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.0, 1.0, 0.3]],
            [[0.0, 0.0, 0.0], [1.0, 1.0, 0.3], [0.0, 1.0, 0.2]],
        ];
        let made = build(&square);
        for k in 1..1000 {
            let x = k as f64 / 1000.0;
            let start = [x + 0.1, x + 0.2, 5.0];
            let direction = [-0.1, -0.2, 0.3 * x - 5.0];
            let hits = first_hits(&made.tree(&square), &[start], &[direction]);
            assert!(hits.triangle[0] >= 0);
        }
    }
}
