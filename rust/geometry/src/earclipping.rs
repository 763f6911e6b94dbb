//! Triangulate faces of many corners in the plane: ears are clipped, a round of them at a time.
//!
//! An ear is a corner whose triangle holds no other part of the face; every simple polygon has one
//! (Meisters 1975, "Polygons have ears"). Whether a corner is an ear is asked of a tree of the
//! corners that are not convex, for one of these lies within any triangle that anything enters. A
//! corner that another stands in the way of waits until that one is clipped, and of two neighbours
//! only one is clipped in a round: so the time grows little faster than the number of corners, and
//! no corner gathers more triangles than the shape asks for.
//!
//! Corners are moved onto a grid, where every turn is exact. Two that lie at one place are fine: a
//! face with a hole is written as one outline that runs to the hole and back along the same edge.

use crate::tree::{Bounds, Boxes, build};
use crate::vector::{Point, cross, dot, length, max, min, subtract};

/// Coordinates on the grid run from 0 to this. A turn is a difference of two products of two
/// differences: below 2^61, so it fits in 64 bits.
const GRID: f64 = (1 << 30) as f64;

/// A turn computed in floating point is wrong by no more than this on the grid: products are below
/// 2^60, and a float has 53 bits.
const TURN_ERROR: f64 = 1024.0;

/// A place on the grid.
type Place = [i64; 2];

/// The corners of a triangle.
type Corners = [i32; 3];

/// Return the n - 2 triangles of one face, in its sense.
///
/// The rest of an outline without ears, one that crosses itself, is halved again and again.
pub fn clip_ears(points: &[Point]) -> Vec<Corners> {
    let n = points.len();
    let mut outline = Outline::new(flatten(points));
    let (mut current, reflex): (Vec<usize>, Vec<usize>) = (0..n).partition(|&v| {
        let (p, q) = outline.ends_around(v);
        may_be_clipped(outline.places([p, v, q]))
    });
    let obstacles = Obstacles::new(&outline.at, reflex);
    let mut waiting = Waiting::new(n);
    let mut triangles = Vec::with_capacity(n.saturating_sub(2));
    // For each corner the round in which its neighbours last changed, and the one that it is listed
    // for.
    let mut touched = vec![0; n];
    let mut listed = vec![0; n];
    let mut round = 0;
    while !current.is_empty() && triangles.len() + 3 < n {
        round += 1;
        let mut coming = Vec::new();
        let mut list = |v: usize| {
            if listed[v] != round {
                listed[v] = round;
                coming.push(v);
            }
        };
        for v in current {
            if !outline.alive[v] || touched[v] == round || triangles.len() + 3 == n {
                continue;
            }
            let (p, q) = outline.ends_around(v);
            if !may_be_clipped(outline.places([p, v, q])) {
                continue;
            }
            if let Some(obstacle) = obstacles.find(&outline, [p, v, q]) {
                waiting.add(v, obstacle);
                continue;
            }
            triangles.push([p, v, q].map(|corner| corner as i32));
            outline.clip(v);
            for w in [p, q] {
                touched[w] = round;
                waiting.remove(w);
                list(w);
            }
            waiting.release(v, &mut list);
        }
        current = coming;
    }
    halve(&outline.rest(), &mut triangles);
    triangles
}

/// The corners that are not clipped yet, in a ring.
struct Outline {
    at: Vec<Place>,
    after: Vec<usize>,
    before: Vec<usize>,
    alive: Vec<bool>,
}

impl Outline {
    fn new(at: Vec<Place>) -> Outline {
        let n = at.len();
        Outline {
            at,
            after: (0..n).map(|v| (v + 1) % n).collect(),
            before: (0..n).map(|v| (v + n - 1) % n).collect(),
            alive: vec![true; n],
        }
    }

    fn ends_around(&self, v: usize) -> (usize, usize) {
        (self.before[v], self.after[v])
    }

    fn places(&self, corners: [usize; 3]) -> [Place; 3] {
        corners.map(|corner| self.at[corner])
    }

    fn clip(&mut self, v: usize) {
        let (p, q) = self.ends_around(v);
        self.alive[v] = false;
        self.after[p] = q;
        self.before[q] = p;
    }

    /// Return the corners that are left, from the first on.
    fn rest(&self) -> Vec<usize> {
        let first = self.alive.iter().position(|&alive| alive);
        let next = |&v: &usize| Some(self.after[v]).filter(|&next| Some(next) != first);
        std::iter::successors(first, next).collect()
    }
}

/// The corners that may stand in the way of an ear, and boxes around them.
struct Obstacles {
    reflex: Vec<usize>,
    boxes: Boxes,
}

impl Obstacles {
    fn new(at: &[Place], reflex: Vec<usize>) -> Obstacles {
        let corners: Vec<_> = reflex
            .iter()
            .map(|&v| [[at[v][0] as f64, at[v][1] as f64, 0.0]; 3])
            .collect();
        let boxes = build(&corners);
        Obstacles { reflex, boxes }
    }

    /// Return a corner that stands in the way of clipping a triangle of the outline.
    fn find(&self, outline: &Outline, corners: [usize; 3]) -> Option<usize> {
        let triangle = outline.places(corners);
        let [a, b, c] = triangle;
        if turn(a, b, c) <= 0 {
            return None;
        }
        let flat = triangle.map(|place| place.map(|x| x as f64));
        let mut stack = Vec::new();
        let near = self
            .boxes
            .tree(&[])
            .select(&mut stack, |bounds| !is_apart(bounds, &flat));
        near.map(|k| self.reflex[k as usize])
            .find(|&r| outline.alive[r] && is_in_the_way(triangle, outline.at[r]))
    }
}

/// The corners that wait until another is clipped.
struct Waiting {
    /// For each corner the one that it waits for.
    obstacle: Vec<Option<usize>>,
    /// For each corner those that began to wait for it; some have left since.
    came: Vec<Vec<usize>>,
}

impl Waiting {
    fn new(n: usize) -> Waiting {
        Waiting {
            obstacle: vec![None; n],
            came: vec![Vec::new(); n],
        }
    }

    fn add(&mut self, v: usize, obstacle: usize) {
        self.obstacle[v] = Some(obstacle);
        self.came[obstacle].push(v);
    }

    fn remove(&mut self, v: usize) {
        self.obstacle[v] = None;
    }

    /// Release those that wait for a corner, the last that came first.
    fn release(&mut self, obstacle: usize, mut each: impl FnMut(usize)) {
        for v in std::mem::take(&mut self.came[obstacle]).into_iter().rev() {
            if self.obstacle[v] == Some(obstacle) {
                self.obstacle[v] = None;
                each(v);
            }
        }
    }
}

/// Return the corners of a face in its plane, on the grid, counter-clockwise; all at one place where
/// the face has no area.
fn flatten(points: &[Point]) -> Vec<Place> {
    let n = points.len();
    let nowhere = vec![[0, 0]; n];
    let middle = [0, 1, 2].map(|c| points.iter().fold(0.0, |sum, p| sum + p[c]) / n as f64);
    let spokes: Vec<Point> = points.iter().map(|p| subtract(p, &middle)).collect();
    let mut normal = [0.0; 3];
    for k in 0..n {
        let area = cross(&spokes[k], &spokes[(k + 1) % n]);
        for c in 0..3 {
            normal[c] += area[c];
        }
    }
    let size = length(&normal);
    // Not comparable where coordinates are too large.
    if size.is_nan() || size <= 0.0 {
        return nowhere;
    }
    let normal = normal.map(|x| x / size);
    let size = normal.map(f64::abs);
    let flattest = (1..3).fold(0, |least, c| if size[c] < size[least] { c } else { least });
    let mut across = [0.0; 3];
    across[flattest] = 1.0;
    let u = cross(&across, &normal);
    let scale = length(&u);
    let u = u.map(|x| x / scale);
    let v = cross(&normal, &u);
    let flat: Vec<[f64; 2]> = spokes.iter().map(|a| [dot(a, &u), dot(a, &v)]).collect();
    let extreme = |choose: fn(f64, f64) -> f64| {
        let each = flat.iter().copied();
        each.reduce(|a, b| [choose(a[0], b[0]), choose(a[1], b[1])])
    };
    let (Some(low), Some(high)) = (extreme(min), extreme(max)) else {
        return nowhere;
    };
    let extent = max(high[0] - low[0], high[1] - low[1]);
    if extent.is_nan() || extent <= 0.0 {
        return nowhere;
    }
    let on_grid = |x: f64, low: f64| ((x - low) / extent * GRID).round_ties_even() as i64;
    flat.iter()
        .map(|p| [on_grid(p[0], low[0]), on_grid(p[1], low[1])])
        .collect()
}

/// Return twice the signed area of three places: above 0 counter-clockwise.
#[inline(always)]
fn turn(a: Place, b: Place, c: Place) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Return whether the middle of three corners is convex, at the place of a neighbour, or the end of
/// a spike without width.
fn may_be_clipped([p, v, q]: [Place; 3]) -> bool {
    match turn(p, v, q) {
        0 => (v[0] - p[0]) * (q[0] - v[0]) + (v[1] - p[1]) * (q[1] - v[1]) <= 0,
        turn => turn > 0,
    }
}

/// Return whether a place lies in a triangle, its edges included, and not at one of its corners.
fn is_in_the_way(triangle: [Place; 3], r: Place) -> bool {
    let [p, v, q] = triangle;
    !triangle.contains(&r) && turn(p, v, r) >= 0 && turn(v, q, r) >= 0 && turn(q, p, r) >= 0
}

/// Return whether a box is surely outside a triangle, given counter-clockwise.
fn is_apart(bounds: &Bounds, triangle: &[[f64; 2]; 3]) -> bool {
    let [a, b, c] = triangle;
    let [low, high] = bounds;
    (0..2).any(|k| high[k] < min(min(a[k], b[k]), c[k]) || low[k] > max(max(a[k], b[k]), c[k]))
        || [(a, b), (b, c), (c, a)]
            .into_iter()
            .any(|(from, to)| highest_turn(bounds, from, to) < -TURN_ERROR)
}

/// Return the greatest turn from an edge to a place in a box.
fn highest_turn([low, high]: &Bounds, from: &[f64; 2], to: &[f64; 2]) -> f64 {
    let x = if to[1] > from[1] { low[0] } else { high[0] };
    let y = if to[0] > from[0] { high[1] } else { low[1] };
    (to[0] - from[0]) * (y - from[1]) - (to[1] - from[1]) * (x - from[0])
}

/// Add the triangles of a ring of corners: its ends and its middle, and so on in both halves.
fn halve(ring: &[usize], triangles: &mut Vec<Corners>) {
    let mut ranges = vec![(0, ring.len().saturating_sub(1))];
    while let Some((i, j)) = ranges.pop() {
        if j - i < 2 {
            continue;
        }
        let k = (i + j) / 2;
        triangles.push([ring[i], ring[k], ring[j]].map(|corner| corner as i32));
        ranges.extend([(i, k), (k, j)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area of triangles in the plane, all of which must be counter-clockwise.
    fn doubled_area(points: &[Point], triangles: &[Corners]) -> f64 {
        let area = |corners: &Corners| {
            let [a, b, c] = corners.map(|v| points[v as usize]);
            let area = cross(&subtract(&b, &a), &subtract(&c, &a))[2];
            assert!(area >= 0.0);
            area
        };
        triangles.iter().map(area).sum()
    }

    #[test]
    fn a_star_is_covered_once() {
        let n = 60;
        let point = |k: usize| {
            let (radius, angle) = (
                if k.is_multiple_of(2) { 3.0 } else { 1.0 },
                std::f64::consts::TAU * k as f64 / n as f64,
            );
            [radius * angle.cos(), radius * angle.sin(), 0.0]
        };
        let points: Vec<Point> = (0..n).map(point).collect();
        let triangles = clip_ears(&points);
        assert_eq!(triangles.len(), n - 2);
        let outline = (0..n).map(|k| cross(&points[k], &points[(k + 1) % n])[2]);
        let wanted: f64 = outline.sum();
        assert!((doubled_area(&points, &triangles) - wanted).abs() < 1e-9);
    }

    #[test]
    fn a_face_without_area_is_halved() {
        let points = vec![[1.0; 3]; 9];
        let triangles = clip_ears(&points);
        assert_eq!(triangles.len(), 7);
    }
}
