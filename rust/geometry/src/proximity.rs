//! Nearest points of triangles, and the triangles near a box, down their tree.

use crate::tree::{Bounds, Search, Tree, Triangle};
use crate::vector::{Point, cross, dot, max, min, subtract};

/// Squared sine of a triangle's smallest angle, about, below which its regions cannot be kept
/// apart: they are differences of products that nearly cancel.
const NEEDLE: f64 = 1e-4;

/// A place on a triangle, by the weights of its last two corners.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weights {
    /// Weight of the second corner.
    pub v: f64,
    /// Weight of the third corner.
    pub w: f64,
}

impl Weights {
    /// Return the weights of all three corners.
    #[inline(always)]
    pub fn all(self) -> [f64; 3] {
        [1.0 - self.v - self.w, self.v, self.w]
    }
}

/// Return the squared distance of a point to a box.
#[inline(always)]
pub fn to_box([low, high]: &Bounds, point: &Point) -> f64 {
    let mut total = 0.0;
    for c in 0..3 {
        let x = point[c];
        let d = max(max(low[c] - x, 0.0), x - high[c]);
        total += d * d;
    }
    total
}

/// The search for the nearest of the triangles that are `allowed`.
struct Nearest<'a, F> {
    corners: &'a [Triangle],
    point: &'a Point,
    allowed: F,
    best: f64,
    triangle: i32,
    weights: [f64; 3],
}

impl<F: Fn(&Triangle) -> bool> Search for Nearest<'_, F> {
    #[inline(always)]
    fn measure(&self, bounds: &Bounds) -> f64 {
        to_box(bounds, self.point)
    }

    #[inline(always)]
    fn is_beyond(&self, _: &Bounds, far: f64) -> bool {
        far >= self.best
    }

    #[inline(always)]
    fn visit(&mut self, triangle: i32) {
        let corners = &self.corners[triangle as usize];
        if !(self.allowed)(corners) {
            return;
        }
        let (distance, weights) = in_triangle(corners, self.point);
        if distance < self.best {
            self.best = distance;
            self.triangle = triangle;
            self.weights = weights.all();
        }
    }
}

/// Return the triangle nearest to each point, and the weights of its corners there.
pub fn nearest(tree: &Tree, points: &[Point]) -> (Vec<i32>, Vec<[f64; 3]>) {
    let mut stack = Vec::new();
    let find = |point| {
        let mut search = Nearest {
            corners: tree.corners,
            point,
            allowed: |_: &Triangle| true,
            best: f64::INFINITY,
            triangle: 0,
            weights: [0.0; 3],
        };
        tree.search(&mut stack, &mut search);
        (search.triangle, search.weights)
    };
    points.iter().map(find).unzip()
}

/// Return the nearest triangle that faces as each point's normal does, -1 without one, and the
/// weights of its corners there.
///
/// A triangle across the normal does not face as it does.
pub fn nearest_facing(
    tree: &Tree,
    points: &[Point],
    normals: &[Point],
) -> (Vec<i32>, Vec<[f64; 3]>) {
    let mut stack = Vec::new();
    let find = |(point, normal)| {
        let mut search = Nearest {
            corners: tree.corners,
            point,
            allowed: |triangle: &Triangle| faces(triangle, normal),
            best: f64::INFINITY,
            triangle: -1,
            weights: [0.0; 3],
        };
        tree.search(&mut stack, &mut search);
        (search.triangle, search.weights)
    };
    points.iter().zip(normals).map(find).unzip()
}

/// Return whether a triangle's normal has a part along another.
fn faces(triangle: &Triangle, normal: &Point) -> bool {
    let u = subtract(&triangle[1], &triangle[0]);
    let v = subtract(&triangle[2], &triangle[0]);
    dot(&cross(&u, &v), normal) > 0.0
}

/// Return the squared distance of a point to a triangle, and where on it that is.
///
/// Source: Ericson 2005, "Real-Time Collision Detection", section 5.1.5, by the regions of the
/// triangle's plane. Differs from the book: in needles, and triangles without area, all edges are
/// looked at.
pub fn in_triangle(triangle: &Triangle, point: &Point) -> (f64, Weights) {
    let [a, b, c] = triangle;
    let (ab, ac, ap) = (subtract(b, a), subtract(c, a), subtract(point, a));
    let (bp, cp) = (subtract(&ap, &ab), subtract(&ap, &ac));
    let (d1, d2) = (dot(&ab, &ap), dot(&ac, &ap));
    let (d3, d4) = (dot(&ab, &bp), dot(&ac, &bp));
    let (d5, d6) = (dot(&ab, &cp), dot(&ac, &cp));
    let (mut v, mut w) = (0.0, 0.0);
    if d1 <= 0.0 && d2 <= 0.0 {
        // At the first corner.
    } else if d3 >= 0.0 && d4 <= d3 {
        v = 1.0;
    } else if d6 >= 0.0 && d5 <= d6 {
        w = 1.0;
    } else {
        let (vc, vb, va) = (d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4);
        let (uu, vv, uv) = (dot(&ab, &ab), dot(&ac, &ac), dot(&ab, &ac));
        if uu * vv - uv * uv <= NEEDLE * (uu + vv) * (uu + vv) {
            return in_needle(triangle, point);
        }
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            v = d1 / (d1 - d3);
        } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            w = d2 / (d2 - d6);
        } else if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            v = 1.0 - w;
        } else {
            let scale = va + vb + vc;
            if scale > 0.0 {
                v = vb / scale;
                w = vc / scale;
            }
        }
    }
    let off = [0, 1, 2].map(|c| ap[c] - v * ab[c] - w * ac[c]);
    (dot(&off, &off), Weights { v, w })
}

/// As [`in_triangle`]: the nearest of the feet on the edges and the one in the plane.
fn in_needle(triangle: &Triangle, point: &Point) -> (f64, Weights) {
    let mut best = f64::INFINITY;
    let mut found = Weights::default();
    for e in 0..3 {
        let (a, b) = (&triangle[e], &triangle[(e + 1) % 3]);
        let edge = subtract(b, a);
        // Adding 0 makes 0 of -0.
        let along = 0.0 + dot(&edge, &subtract(point, a));
        let size = dot(&edge, &edge);
        let s = if size > 0.0 {
            min(max(along / size, 0.0), 1.0)
        } else {
            0.0
        };
        let off = [0, 1, 2].map(|c| (1.0 - s) * a[c] + s * b[c] - point[c]);
        let distance = dot(&off, &off);
        if distance < best {
            best = distance;
            let (v, w) = [(s, 0.0), (1.0 - s, s), (0.0, 1.0 - s)][e];
            found = Weights { v, w };
        }
    }
    let u = subtract(&triangle[1], &triangle[0]);
    let t = subtract(&triangle[2], &triangle[0]);
    let p = subtract(point, &triangle[0]);
    let n = cross(&u, &t);
    let size = dot(&n, &n);
    if size > 0.0 {
        let v = dot(&cross(&p, &t), &n) / size;
        let w = dot(&cross(&u, &p), &n) / size;
        if v > 0.0 && w > 0.0 && v + w < 1.0 {
            let off = [0, 1, 2].map(|c| p[c] - v * u[c] - w * t[c]);
            let distance = dot(&off, &off);
            if distance < best {
                best = distance;
                found = Weights { v, w };
            }
        }
    }
    (best, found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::build;
    use crate::tree::tests::lattice;

    #[test]
    fn the_tree_finds_what_a_look_at_all_triangles_finds() {
        let corners = lattice(7);
        let made = build(&corners);
        let points: Vec<Point> = (0..200)
            .map(|i| [0.031 * i as f64, 6.0 - 0.027 * i as f64, 0.25 * i as f64])
            .collect();
        let (triangles, weights) = nearest(&made.tree(&corners), &points);
        for ((point, &f), w) in points.iter().zip(&triangles).zip(&weights) {
            let (found, _) = in_triangle(&corners[f as usize], point);
            let least = corners.iter().map(|t| in_triangle(t, point).0);
            assert_eq!(found, least.fold(f64::INFINITY, f64::min));
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn nothing_faces_down() {
        let corners = lattice(3);
        let made = build(&corners);
        let (triangles, _) = nearest_facing(&made.tree(&corners), &[[1.0; 3]], &[[0.0, 0.0, -1.0]]);
        assert_eq!(triangles, [-1]);
    }

    #[test]
    fn a_needle_has_its_nearest_edge() {
        let needle = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let (distance, weights) = in_triangle(&needle, &[1.5, 1.0, 0.0]);
        assert_eq!(distance, 1.0);
        assert_eq!(2.0 * weights.w + weights.v, 1.5);
    }
}
