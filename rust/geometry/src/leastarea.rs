//! Triangulate closed polylines in space with the least area: one recurrence for all of them.
//!
//! The best triangulation between vertices i and j is the best triangle on that edge and the best
//! triangulations beyond its two other edges (Barequet and Sharir 1995, "Filling gaps in the
//! boundary of a polyhedron", section 3). Time grows with the cube of the number of vertices.
//!
//! - [`triangulate_cheapest`] is the recurrence as it stands, for faces and other short polylines.
//! - [`tabulate_areas`] and [`choose_triangles`] are for long ones: the first runs in vector
//!   registers and keeps areas alone; the second goes back through them and can afford to weigh
//!   triangulations of equal area.
//! - [`tabulate_areas_around`] has the least areas of all stretches around a closed polyline: those
//!   on both sides of every chord.

use crate::vector::{Point, cross, dot, length, max, min, subtract};

/// Areas that differ by less than this part of the whole are equal: rounding is below it, and a
/// planar stretch, where all triangulations have one area, is not triangulated by rounding.
const TIE: f64 = 1e-12;

/// A triangle whose angle has a cosine this near to -1 is flat: never the better of equals.
const FLAT: f64 = 1e-9;

/// Sums that are computed at once: two or four registers of numbers, by the processor.
const LANES: usize = 8;

/// What a triangle costs besides its area.
#[derive(Clone, Copy, Debug, Default)]
pub struct Price {
    /// What its edges' squared lengths count.
    pub shorter: f64,
    /// It costs no less than this part of its edges' squared lengths.
    pub thin: f64,
}

impl Price {
    #[inline(always)]
    fn of(&self, a: &Point, b: &Point, c: &Point) -> f64 {
        let (u, v) = (subtract(b, a), subtract(c, a));
        let area = 0.5 * length(&cross(&u, &v));
        if self.shorter == 0.0 && self.thin == 0.0 {
            return area;
        }
        let w = subtract(&u, &v);
        let edges = dot(&u, &u) + v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + dot(&w, &w);
        max(area, self.thin * edges) + self.shorter * edges
    }
}

/// A square table of numbers.
struct Table {
    n: usize,
    items: Vec<f64>,
}

impl Table {
    fn new(n: usize) -> Table {
        let items = vec![0.0; n * n];
        Table { n, items }
    }

    /// Return rows i and j to write to, i < j.
    #[inline(always)]
    fn rows(&mut self, i: usize, j: usize) -> (&mut [f64], &mut [f64]) {
        let (upper, lower) = self.items.split_at_mut(j * self.n);
        (&mut upper[i * self.n..][..self.n], &mut lower[..self.n])
    }
}

/// Return the cheapest triangulation of a closed polyline, n - 2 triangles, and its cost.
///
/// Of equals the one with the lower vertex is taken.
pub fn triangulate_cheapest(points: &[Point], price: Price) -> (Vec<[usize; 3]>, f64) {
    let n = points.len();
    // Symmetric, so that both entries that the inner loop reads lie in rows.
    let mut cost = Table::new(n);
    let mut apex = vec![0; n * n];
    for i in (0..n.saturating_sub(2)).rev() {
        for j in i + 2..n {
            let (row, column) = cost.rows(i, j);
            let mut least = f64::INFINITY;
            let mut chosen = i + 1;
            for k in i + 1..j {
                let beyond = row[k] + column[k];
                if beyond >= least {
                    continue;
                }
                let total = beyond + price.of(&points[i], &points[k], &points[j]);
                if total < least {
                    least = total;
                    chosen = k;
                }
            }
            row[j] = least;
            column[i] = least;
            apex[i * n + j] = chosen;
        }
    }
    let mut triangles = Vec::with_capacity(n.saturating_sub(2));
    let mut edges = vec![(0, n.saturating_sub(1))];
    while let Some((i, j)) = edges.pop() {
        if j - i < 2 {
            continue;
        }
        let k = apex[i * n + j];
        triangles.push([i, k, j]);
        edges.extend([(i, k), (k, j)]);
    }
    (
        triangles,
        cost.items.get(n.wrapping_sub(1)).copied().unwrap_or(0.0),
    )
}

/// The vertices of a polyline, by coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Polyline<'a> {
    /// x of every vertex.
    pub x: &'a [f64],
    /// y of every vertex.
    pub y: &'a [f64],
    /// z of every vertex.
    pub z: &'a [f64],
}

impl<'a> Polyline<'a> {
    /// Split the coordinates of n vertices, all x before all y before all z.
    pub fn new(coordinates: &'a [f64]) -> Polyline<'a> {
        let (x, rest) = coordinates.split_at(coordinates.len() / 3);
        let (y, z) = rest.split_at(x.len());
        Polyline { x, y, z }
    }

    fn len(&self) -> usize {
        self.x.len()
    }

    #[inline(always)]
    fn vertex(&self, i: usize) -> Point {
        [self.x[i], self.y[i], self.z[i]]
    }

    /// Return the vertices of a range.
    #[inline(always)]
    fn part(&self, range: std::ops::Range<usize>) -> Polyline<'a> {
        Polyline {
            x: &self.x[range.clone()],
            y: &self.y[range.clone()],
            z: &self.z[range],
        }
    }
}

/// Return the cosine of the angle at the second of three points; 2 if the triangle is flat there.
fn cosine(a: &Point, b: &Point, c: &Point) -> f64 {
    let (u, v) = (subtract(a, b), subtract(c, b));
    let (first, second) = (dot(&u, &u), dot(&v, &v));
    if first == 0.0 || second == 0.0 {
        return 2.0;
    }
    let cosine = dot(&u, &v) / (first * second).sqrt();
    if cosine < FLAT - 1.0 { 2.0 } else { cosine }
}

/// Return the least sum, over some vertices, of a row's and a column's entry and the doubled area of
/// the triangle with an edge.
///
/// The least of each lane is found by itself, so that the loop runs in vector registers; which of
/// equal sums is taken makes no difference.
#[inline(always)]
fn least_sum(row: &[f64], column: &[f64], vertices: Polyline, [from, to]: [Point; 2]) -> f64 {
    let edge = subtract(&to, &from);
    let sum = |r: f64, c: f64, x: f64, y: f64, z: f64| {
        r + c + length(&cross(&subtract(&[x, y, z], &from), &edge))
    };
    let (rows, row) = row.as_chunks::<LANES>();
    let (columns, column) = column.as_chunks::<LANES>();
    let Polyline { x, y, z } = vertices;
    let [(xs, x), (ys, y), (zs, z)] = [x, y, z].map(|along| along.as_chunks::<LANES>());
    let mut best = [f64::INFINITY; LANES];
    for ((((r, c), x), y), z) in rows.iter().zip(columns).zip(xs).zip(ys).zip(zs) {
        for l in 0..LANES {
            best[l] = min(best[l], sum(r[l], c[l], x[l], y[l], z[l]));
        }
    }
    for ((((&r, &c), &x), &y), &z) in row.iter().zip(column).zip(x).zip(y).zip(z) {
        best[0] = min(best[0], sum(r, c, x, y, z));
    }
    best.into_iter().fold(f64::INFINITY, min)
}

/// Tabulate twice the least area between vertices i and j of a polyline of n vertices: a symmetric
/// table of n rows.
///
/// Infinite for pairs that are `barred`, a table of n rows or, if none is, one that is shorter than
/// 3.
#[inline(always)]
pub fn tabulate_areas(at: &Polyline, barred: &[bool]) -> Vec<f64> {
    let n = at.len();
    let mut least = Table::new(n);
    for i in (0..n.saturating_sub(2)).rev() {
        for j in i + 2..n {
            let between = i + 1..j;
            let edge = [at.vertex(i), at.vertex(j)];
            let (row, column) = least.rows(i, j);
            let sides = (&row[between.clone()], &column[between.clone()]);
            let mut best = least_sum(sides.0, sides.1, at.part(between), edge);
            if barred.get(i * n + j) == Some(&true) && j - i < n - 1 {
                best = f64::INFINITY;
            }
            row[j] = best;
            column[i] = best;
        }
    }
    least.items
}

/// Choose the triangles of a polyline by the symmetric table of its least areas; return them and their
/// area.
///
/// Of equals (TIE) it takes the triangle with the widest angle opposite its edge, then the lowest
/// vertex.
pub fn choose_triangles(at: &Polyline, least: &[f64]) -> (Vec<[i64; 3]>, f64) {
    let n = at.len();
    let points: Vec<Point> = (0..n).map(|k| at.vertex(k)).collect();
    let mut triangles = Vec::with_capacity(n.saturating_sub(2));
    let slack = TIE * least[n - 1];
    let mut edges = vec![(0, n - 1)];
    let mut total = 0.0;
    // For each vertex between the edge's the area of its triangle, doubled, and the whole area.
    let mut areas = Vec::with_capacity(n);
    while let Some((i, j)) = edges.pop() {
        let (from, to) = (&points[i], &points[j]);
        let edge = subtract(to, from);
        let rows = [i, j].map(|v| &least[v * n..][i + 1..j]);
        areas.clear();
        let between = points[i + 1..j].iter().zip(rows[0]).zip(rows[1]);
        areas.extend(between.map(|((point, one), other)| {
            let doubled = length(&cross(&subtract(point, from), &edge));
            (doubled, one + other + doubled)
        }));
        let lowest = areas
            .iter()
            .fold(f64::INFINITY, |lowest, area| min(lowest, area.1));
        let equals = (i + 1..j)
            .zip(&areas)
            .filter(|(_, area)| area.1 <= lowest + slack);
        let widest = equals
            .map(|(k, area)| (k, area.0, cosine(from, &points[k], to)))
            .reduce(|best, next| if next.2 < best.2 { next } else { best });
        let (chosen, doubled, _) = widest.expect("areas are numbers");
        triangles.push([i, chosen, j].map(|v| v as i64));
        total += doubled / 2.0;
        edges.extend(
            [(i, chosen), (chosen, j)]
                .into_iter()
                .filter(|(a, b)| b - a > 1),
        );
    }
    (triangles, total)
}

/// Tabulate twice the least area of s + 1 vertices from i on of a loop of n: a table with a row for
/// each i.
#[inline(always)]
pub fn tabulate_areas_around(at: &Polyline) -> Vec<f64> {
    let n = at.len();
    let twice = [at.x, at.y, at.z].map(|along| [along, along].concat());
    let twice = Polyline {
        x: &twice[0],
        y: &twice[1],
        z: &twice[2],
    };
    let mut least = vec![0.0; n * n];
    // The same by the vertex where a stretch ends, the longest first: what the inner loop reads lies
    // in a row.
    let mut ending = vec![0.0; n * n];
    for s in 2..n {
        for i in 0..n {
            let edge = [twice.vertex(i), twice.vertex(i + s)];
            let row = &mut least[i * n..][..n];
            let column = &mut ending[(i + s) % n * n..][..n];
            let between = twice.part(i + 1..i + s);
            let best = least_sum(&row[1..s], &column[n - s..n - 1], between, edge);
            row[s] = best;
            column[n - 1 - s] = best;
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed wave over a circle.
    fn wave(n: usize) -> Vec<Point> {
        let point = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / n as f64;
            [angle.cos(), angle.sin(), (3.0 * angle).cos()]
        };
        (0..n).map(point).collect()
    }

    fn columns(points: &[Point]) -> Vec<f64> {
        (0..3)
            .flat_map(|c| points.iter().map(move |p| p[c]))
            .collect()
    }

    #[test]
    fn a_square_has_its_area() {
        let square = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
        let (triangles, cost) = triangulate_cheapest(&square, Price::default());
        assert_eq!(triangles, [[0, 1, 3], [1, 2, 3]]);
        assert_eq!(cost, 4.0);
    }

    #[test]
    fn all_ways_have_the_same_least_area() {
        for n in [3, 4, 11, 30] {
            let points = wave(n);
            let (_, cost) = triangulate_cheapest(&points, Price::default());
            let columns = columns(&points);
            let at = Polyline::new(&columns);
            let least = tabulate_areas(&at, &[false]);
            let (triangles, area) = choose_triangles(&at, &least);
            let around = tabulate_areas_around(&at);
            assert_eq!(triangles.len(), n - 2);
            for found in [least[n - 1] / 2.0, area, around[n - 1] / 2.0] {
                assert!((found - cost).abs() < 1e-12 * cost);
            }
        }
    }

    #[test]
    fn a_barred_pair_is_no_edge_of_a_triangle() {
        let n = 9;
        let columns = columns(&wave(n));
        let at = Polyline::new(&columns);
        let mut barred = vec![true; n * n];
        (1..n).for_each(|k| barred[k] = false);
        let least = tabulate_areas(&at, &barred);
        let (triangles, _) = choose_triangles(&at, &least);
        assert!(triangles.into_iter().all(|corners| corners[0] == 0));
    }
}
