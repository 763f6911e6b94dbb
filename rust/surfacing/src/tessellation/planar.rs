//! Polygons on an integer grid: exact turns, whether one crosses itself, its ears, and points inside.
//!
//! Coordinates run from 0 to 2^30 (GRID of `patterndb_sketch.surfacing.tessellation.planar`). A turn
//! is a difference of two products of two differences: below 2^61, so it fits in 64 bits. So every
//! predicate here except that of the circle is exact, and no polygon, however noisy, nearly touching
//! or full of vertices in a row on one line, leads to an inverted triangle.

use patterndb_geometry::vector::{max, min};

/// Relative error of the sum in [`is_within_circle`], beneath which its sign means nothing
/// (Shewchuk 1997, "Adaptive precision floating-point arithmetic", its first filter). The unit there
/// is 2^-53, half of EPSILON.
const CIRCLE_ERROR: f64 = (10.0 + 48.0 * f64::EPSILON) * (f64::EPSILON / 2.0);

/// Lattice points this near to the boundary, in spacings, are left out: the rows of a lattice are
/// 0.87 apart, and the smoothing moves the outermost row to about that.
const CLEARANCE: f64 = 0.6;

/// Rounds of smoothing. The shapes hardly change after the fourth.
const ROUNDS: usize = 4;

/// A place on the grid.
pub type Place = [i64; 2];

/// Half-edges of triangles: half-edge 3 t + e leaves corner e of triangle t.
#[derive(Debug)]
pub struct Triangles<'a> {
    /// The vertex that every half-edge leaves.
    pub tail: &'a mut [i64],
    /// The half-edge on the other side of every half-edge, -1 on the boundary.
    pub twin: &'a mut [i64],
}

/// Return the half-edge after one in its triangle, counter-clockwise.
#[inline(always)]
pub fn following(h: usize) -> usize {
    if h % 3 < 2 { h + 1 } else { h - 2 }
}

/// Return the half-edge before one in its triangle.
#[inline(always)]
pub fn preceding(h: usize) -> usize {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// Return twice the signed area of the triangle of three places: above 0 counter-clockwise.
#[inline(always)]
pub fn turn([a, b, c]: [&Place; 3]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Return twice the signed area of a closed polygon.
pub fn doubled_area(polygon: &[Place]) -> f64 {
    let [first, rest @ ..] = polygon else {
        return 0.0;
    };
    let turns = rest
        .windows(2)
        .map(|ends| turn([first, &ends[0], &ends[1]]));
    turns.fold(0.0, |total, turn| total + turn as f64)
}

/// Return whether a closed polygon runs counter-clockwise without touching itself.
///
/// Vertices in a row on one line are fine; two at one place and edges that fold back are not.
pub fn is_simple(polygon: &[Place]) -> bool {
    if doubled_area(polygon) <= 0.0 {
        return false;
    }
    let m = polygon.len();
    let edges: Vec<Segment> = (0..m)
        .map(|i| Segment {
            from: polygon[i],
            to: polygon[(i + 1) % m],
        })
        .collect();
    edges.iter().enumerate().all(|(i, edge)| {
        // The last edge is next to the first.
        let end = if i == 0 { m - 1 } else { m };
        !edge.folds_back(&edges[(i + 1) % m])
            && !edges[..end]
                .iter()
                .skip(i + 2)
                .any(|other| edge.meets(other))
    })
}

/// A straight edge.
struct Segment {
    from: Place,
    to: Place,
}

impl Segment {
    /// Return whether the edge has no length, or the next one runs back along it.
    fn folds_back(&self, next: &Segment) -> bool {
        let along = |c: usize| (self.to[c] - self.from[c]) * (next.to[c] - next.from[c]);
        self.from == self.to
            || (turn([&self.from, &self.to, &next.to]) == 0 && along(0) + along(1) < 0)
    }

    /// Return whether two edges have a point in common.
    fn meets(&self, other: &Segment) -> bool {
        let (Segment { from: a, to: b }, Segment { from: c, to: d }) = (self, other);
        if (0..2).any(|k| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k])) {
            return false;
        }
        let (to_c, to_d) = (turn([a, b, c]), turn([a, b, d]));
        let (to_a, to_b) = (turn([c, d, a]), turn([c, d, b]));
        // By signs: a product of two turns would not fit.
        let part = |one: i64, other: i64| one.signum() * other.signum() < 0;
        (part(to_c, to_d) && part(to_a, to_b))
            || (to_c == 0 && self.spans(c))
            || (to_d == 0 && self.spans(d))
            || (to_a == 0 && other.spans(a))
            || (to_b == 0 && other.spans(b))
    }

    /// Return whether a place in line with the edge lies on it, its ends included.
    fn spans(&self, place: &Place) -> bool {
        let Segment { from, to } = self;
        (0..2).all(|k| (from[k].min(to[k])..=from[k].max(to[k])).contains(&place[k]))
    }
}

/// Return whether `d` surely lies within the circle through three others, given counter-clockwise.
fn is_within_circle(corners: [&Place; 3], d: &Place) -> bool {
    let [(ax, ay), (bx, by), (cx, cy)] =
        corners.map(|corner| ((corner[0] - d[0]) as f64, (corner[1] - d[1]) as f64));
    let (bc, cb) = (bx * cy, cx * by);
    let (ca, ac) = (cx * ay, ax * cy);
    let (ab, ba) = (ax * by, bx * ay);
    let (a2, b2, c2) = (ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy);
    let total = a2 * (bc - cb) + b2 * (ca - ac) + c2 * (ab - ba);
    let size = (bc.abs() + cb.abs()) * a2 + (ca.abs() + ac.abs()) * b2 + (ab.abs() + ba.abs()) * c2;
    total > CIRCLE_ERROR * size
}

/// Triangulate a simple counter-clockwise polygon of m corners into the first m - 2 triangles.
///
/// Every simple polygon has an ear (Meisters 1975, "Polygons have ears"), and so has one with
/// vertices in a row on one line: a leaf of any of its triangulations. Clipping one leaves such a
/// polygon, because no vertex lies on the cut.
pub fn clip_ears(polygon: &[Place], triangles: &mut Triangles) {
    let m = polygon.len();
    let mut after: Vec<usize> = (0..m).map(|i| (i + 1) % m).collect();
    let mut before: Vec<usize> = (0..m).map(|i| (i + m - 1) % m).collect();
    // The half-edge of a triangle beyond the edge from a vertex to the next.
    let mut beyond: Vec<Option<usize>> = vec![None; m];
    let mut v = 0;
    for t in 0..m - 2 {
        while !is_ear(polygon, &after, [before[v], v, after[v]]) {
            v = after[v];
        }
        let (p, q) = (before[v], after[v]);
        let h = 3 * t;
        for (e, corner) in [p, v, q].into_iter().enumerate() {
            triangles.tail[h + e] = corner as i64;
        }
        triangles.pair(h, beyond[p]);
        triangles.pair(h + 1, beyond[v]);
        triangles.pair(h + 2, None);
        after[p] = q;
        before[q] = p;
        beyond[p] = Some(h + 2);
        // Not the next one: ears in a row would make a fan of thin triangles.
        v = after[q];
    }
    let last = 3 * (m - 2) - 1;
    triangles.pair(last, beyond[triangles.tail[last] as usize]);
}

/// Return whether the triangle of a vertex and its neighbours is inside, with no other vertex on it.
fn is_ear(polygon: &[Place], after: &[usize], [p, v, q]: [usize; 3]) -> bool {
    let (a, b, c) = (&polygon[p], &polygon[v], &polygon[q]);
    if turn([a, b, c]) <= 0 {
        return false;
    }
    let low = [0, 1].map(|k| a[k].min(b[k]).min(c[k]));
    let high = [0, 1].map(|k| a[k].max(b[k]).max(c[k]));
    let mut other = after[q];
    while other != p {
        let place = &polygon[other];
        if (0..2).all(|k| low[k] <= place[k] && place[k] <= high[k])
            && turn([a, b, place]) >= 0
            && turn([b, c, place]) >= 0
            && turn([c, a, place]) >= 0
        {
            return false;
        }
        other = after[other];
    }
    true
}

impl Triangles<'_> {
    #[inline(always)]
    fn tail(&self, h: usize) -> usize {
        self.tail[h] as usize
    }

    /// Return the half-edge on the other side; None on the boundary.
    #[inline(always)]
    fn twin(&self, h: usize) -> Option<usize> {
        usize::try_from(self.twin[h]).ok()
    }

    /// Make two half-edges twins, or put one on the boundary.
    #[inline(always)]
    fn pair(&mut self, h: usize, twin: Option<usize>) {
        self.twin[h] = twin.map_or(-1, |g| g as i64);
        if let Some(g) = twin {
            self.twin[g] = h as i64;
        }
    }

    /// Turn the inner edge of two half-edges within the quad of their two triangles.
    fn flip_edge(&mut self, h: usize, g: usize) {
        let (hp, gp) = (preceding(h), preceding(g));
        let (c, d) = (self.tail[hp], self.tail[gp]);
        let (beyond_h, beyond_g) = (self.twin(gp), self.twin(hp));
        self.tail[h] = d;
        self.tail[g] = c;
        self.pair(h, beyond_h);
        self.pair(g, beyond_g);
        self.pair(hp, Some(gp));
    }

    /// Flip inner edges until each is locally Delaunay.
    ///
    /// An edge is flipped only where the test is certain. Then its quad is convex, and the flip
    /// lowers the surface over the paraboloid: it ends.
    pub fn make_delaunay(&mut self, at: &[Place]) {
        let mut waiting = vec![true; self.tail.len()];
        let mut stack: Vec<usize> = (0..self.tail.len()).collect();
        while let Some(h) = stack.pop() {
            waiting[h] = false;
            let Some(g) = self.twin(h) else { continue };
            let corners = [h, following(h), preceding(h)].map(|h| &at[self.tail(h)]);
            if !is_within_circle(corners, &at[self.tail(preceding(g))]) {
                continue;
            }
            self.flip_edge(h, g);
            for k in [h, following(h), g, following(g)] {
                if !waiting[k] {
                    waiting[k] = true;
                    stack.push(k);
                }
            }
        }
    }

    /// Return which of the first `n` triangles holds a place, walking there from one of them; None
    /// if none does.
    fn find_triangle(&self, at: &[Place], n: usize, place: &Place, first: usize) -> Option<usize> {
        let triangles = &self.tail.as_chunks().0[..n];
        let turns = |corners: &[i64; 3]| {
            let [a, b, c] = corners.map(|corner| &at[corner as usize]);
            [[a, b], [b, c], [c, a]].map(|[from, to]| turn([from, to, place]))
        };
        let mut t = first;
        for _ in 0..n {
            let Some(e) = turns(&triangles[t]).iter().position(|&turn| turn < 0) else {
                return Some(t);
            };
            let Some(beyond) = self.twin(3 * t + e) else {
                break;
            };
            t = beyond / 3;
        }
        // The straight way there leaves a concave polygon.
        let holds = |corners: &[i64; 3]| turns(corners).iter().all(|&turn| turn >= 0);
        triangles.iter().position(holds)
    }

    /// Join point `p`, in triangle `t` and on no boundary edge, to a Delaunay triangulation of `n`
    /// triangles. Two more are made. `stack` is scratch.
    fn insert_point(&mut self, at: &[Place], n: usize, p: usize, t: usize, stack: &mut Vec<usize>) {
        let (h, u, v) = (3 * t, 3 * n, 3 * n + 3);
        let [a, b, c] = [0, 1, 2].map(|e| self.tail[h + e]);
        let (of_u, of_v) = (self.twin(h + 1), self.twin(h + 2));
        let corner = p as i64;
        self.tail[h + 2] = corner;
        self.tail[u..u + 3].copy_from_slice(&[b, c, corner]);
        self.tail[v..v + 3].copy_from_slice(&[c, a, corner]);
        self.pair(u, of_u);
        self.pair(v, of_v);
        self.pair(h + 1, Some(u + 2));
        self.pair(u + 1, Some(v + 2));
        self.pair(v + 1, Some(h + 2));
        stack.clear();
        stack.extend([h, u, v]);
        while let Some(k) = stack.pop() {
            let Some(g) = self.twin(k) else { continue };
            let corners = [&at[self.tail(k)], &at[self.tail(following(k))], &at[p]];
            // A point on an edge leaves a triangle without area there: that edge has to go.
            if turn(corners) > 0 && !is_within_circle(corners, &at[self.tail(preceding(g))]) {
                continue;
            }
            self.flip_edge(k, g);
            stack.extend([k, following(g)]);
        }
    }

    /// Insert the points from `m` on, one by one, in the triangulation of a polygon of the first
    /// `m`. Return how many points are joined in the end: fewer than all where one is in no triangle.
    pub fn join(&mut self, at: &[Place], m: usize) -> usize {
        let mut stack = Vec::new();
        let mut t = 0;
        for p in m..at.len() {
            let n = m - 2 + 2 * (p - m);
            match self.find_triangle(at, n, &at[p], t) {
                Some(found) => t = found,
                None => return p,
            }
            self.insert_point(at, n, p, t, &mut stack);
        }
        at.len()
    }

    /// Return the half-edges that leave the vertex of one, which is not on the boundary.
    fn leaving(&self, first: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(first), move |&h| {
            self.twin(preceding(h)).filter(|&next| next != first)
        })
    }

    /// Move the points from `m` on towards even triangles, and flip to Delaunay again.
    ///
    /// Each goes to the mean of its triangles' middles by their areas (Chen 2004, "Mesh smoothing
    /// schemes based on optimal Delaunay triangulations"), unless that would turn one of them over.
    pub fn smooth(&mut self, at: &mut [Place], m: usize) {
        let mut leaving = vec![0; at.len()];
        for _ in 0..ROUNDS {
            for (h, &vertex) in self.tail.iter().enumerate() {
                leaving[vertex as usize] = h;
            }
            for p in m..at.len() {
                let first = leaving[p];
                let moved = self.find_middle(at, first);
                let is_sound = self.leaving(first).all(|h| {
                    let [a, b] = [following(h), preceding(h)].map(|h| &at[self.tail(h)]);
                    turn([&moved, a, b]) > 0
                });
                if is_sound {
                    at[p] = moved;
                }
            }
            self.make_delaunay(at);
        }
    }

    /// Return the mean of the middles of the triangles around the vertex of a half-edge, by areas.
    fn find_middle(&self, at: &[Place], first: usize) -> Place {
        let place = &at[self.tail(first)];
        let (mut total, mut x, mut y) = (0.0, 0.0, 0.0);
        for h in self.leaving(first) {
            let [a, b] = [following(h), preceding(h)].map(|h| &at[self.tail(h)]);
            let area = turn([place, a, b]) as f64;
            total += area;
            x += area * (a[0] + b[0] - 2 * place[0]) as f64 / 3.0;
            y += area * (a[1] + b[1] - 2 * place[1]) as f64 / 3.0;
        }
        [
            place[0] + (x / total).round_ties_even() as i64,
            place[1] + (y / total).round_ties_even() as i64,
        ]
    }
}

/// Return points of a hexagonal lattice inside a simple polygon, clear of its boundary.
///
/// Rows are along the first axis, one of them through the middle of the polygon's box.
pub fn lay_lattice(polygon: &[Place], spacing: f64) -> Vec<Place> {
    let m = polygon.len();
    let extent = |k: usize| {
        let values = polygon.iter().map(|place| place[k]);
        let low = values.clone().min().unwrap_or_default();
        (low, values.max().unwrap_or_default())
    };
    let middle = |(low, high): (i64, i64)| (low + high) as f64 / 2.0;
    let (middle_x, middle_y) = (middle(extent(0)), middle(extent(1)));
    let rise = spacing * 3.0_f64.sqrt() / 2.0;
    let half = ((extent(1).1 as f64 - middle_y) / rise) as i64;
    let clear = CLEARANCE * spacing;
    let edges: Vec<Side> = (0..m)
        .map(|i| Side::new(&polygon[i], &polygon[(i + 1) % m]))
        .collect();
    let mut found = Vec::new();
    let mut crossings = Vec::new();
    let mut near = Vec::new();
    for row in -half..=half {
        let y = middle_y + row as f64 * rise;
        crossings.clear();
        near.clear();
        for edge in &edges {
            let (from, to) = (edge.from[1], edge.to[1]);
            if min(from, to) < y + clear && max(from, to) > y - clear {
                near.push(edge);
            }
            // Half-open, so that a vertex in the row counts once.
            if (from <= y) != (to <= y) {
                crossings.push(edge.from[0] + (y - from) / (to - from) * edge.along[0]);
            }
        }
        crossings.sort_unstable_by(f64::total_cmp);
        let shift = middle_x + if row % 2 == 0 { 0.0 } else { 0.5 * spacing };
        for span in crossings.chunks_exact(2) {
            let first = ((span[0] - shift) / spacing).ceil() as i64;
            let last = ((span[1] - shift) / spacing).floor() as i64;
            for step in first..=last {
                let place = [shift + step as f64 * spacing, y];
                if near.iter().all(|edge| edge.is_clear(place, clear)) {
                    found.push(place.map(|x| x.round_ties_even() as i64));
                }
            }
        }
    }
    found
}

/// An edge of a polygon in floating point, in which its coordinates are exact.
struct Side {
    from: [f64; 2],
    to: [f64; 2],
    along: [f64; 2],
}

impl Side {
    fn new(from: &Place, to: &Place) -> Side {
        let (from, to) = (from.map(|x| x as f64), to.map(|x| x as f64));
        Side {
            from,
            to,
            along: [to[0] - from[0], to[1] - from[1]],
        }
    }

    /// Return whether a place is at least this far from the edge.
    fn is_clear(&self, [x, y]: [f64; 2], clear: f64) -> bool {
        let ([from_x, from_y], [along_x, along_y]) = (self.from, self.along);
        let (x, y) = (x - from_x, y - from_y);
        let share = (x * along_x + y * along_y) / (along_x * along_x + along_y * along_y);
        let share = min(max(share, 0.0), 1.0);
        let (x, y) = (x - share * along_x, y - share * along_y);
        x * x + y * y >= clear * clear
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 2^20 with n points on each side, and a notch in the upper one.
    fn notched(n: i64) -> Vec<Place> {
        let side = 1 << 20;
        let step = side / n;
        let mut polygon = Vec::new();
        polygon.extend((0..n).map(|k| [k * step, 0]));
        polygon.extend((0..n).map(|k| [side, k * step]));
        polygon.extend((0..n).map(|k| {
            let depth = if k == n / 2 { side / 2 } else { 0 };
            [side - k * step, side - depth]
        }));
        polygon.extend((0..n).map(|k| [0, side - k * step]));
        polygon
    }

    fn check(at: &[Place], triangles: &Triangles, area: f64) {
        let mut total = 0.0;
        for t in 0..triangles.tail.len() / 3 {
            let turn = turn([0, 1, 2].map(|e| &at[triangles.tail(3 * t + e)]));
            assert!(turn > 0);
            total += turn as f64;
        }
        assert_eq!(total, area);
        for h in 0..triangles.tail.len() {
            if let Some(g) = triangles.twin(h) {
                assert_eq!(triangles.twin(g), Some(h));
                assert_eq!(triangles.tail(g), triangles.tail(following(h)));
            }
        }
    }

    #[test]
    fn a_polygon_is_filled_with_sound_triangles() {
        let polygon = notched(8);
        assert!(is_simple(&polygon));
        let inner = lay_lattice(&polygon, f64::from(1 << 17));
        assert!(inner.len() > 10);
        let m = polygon.len();
        let room = 3 * (m - 2 + 2 * inner.len());
        let (mut tail, mut twin) = (vec![0; room], vec![0; room]);
        let first = 3 * (m - 2);
        let mut triangles = Triangles {
            tail: &mut tail[..first],
            twin: &mut twin[..first],
        };
        clip_ears(&polygon, &mut triangles);
        let area = doubled_area(&polygon);
        check(&polygon, &triangles, area);
        triangles.make_delaunay(&polygon);
        check(&polygon, &triangles, area);
        let mut at = [polygon, inner].concat();
        let mut triangles = Triangles {
            tail: &mut tail,
            twin: &mut twin,
        };
        assert_eq!(triangles.join(&at, m), at.len());
        check(&at, &triangles, area);
        triangles.smooth(&mut at, m);
        check(&at, &triangles, area);
    }

    #[test]
    fn polygons_that_touch_themselves_are_not_simple() {
        let square = [[0, 0], [4, 0], [4, 4], [0, 4]];
        assert!(is_simple(&square));
        let mut clockwise = square;
        clockwise.reverse();
        assert!(!is_simple(&clockwise));
        // In a row on one line; back along the same line; through the opposite side.
        assert!(is_simple(&[[0, 0], [2, 0], [4, 0], [4, 4], [0, 4]]));
        assert!(!is_simple(&[[0, 0], [4, 0], [2, 0], [4, 4], [0, 4]]));
        assert!(!is_simple(&[[0, 0], [4, 0], [4, 4], [2, 0], [0, 4]]));
        assert!(!is_simple(&[[0, 0], [0, 0], [4, 0], [4, 4]]));
    }
}
