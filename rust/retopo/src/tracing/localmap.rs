//! Local parameterisation: (u, v) spread over a surface from a stroke or a point.
//!
//! A discrete exponential map. Source: Schmidt 2013, "Stroke Parameterization", as Takayama et al.
//! 2013 and their released program use it.

use patterndb_geometry::Point;
use patterndb_geometry::vector::{cross, dot, length, max, min, subtract};

use super::heap::Heap;
use patterndb_geometry::adjacency::{Surface, Triangle};

/// A neighbour's proposal weighs its distance to this power. Source: the released program of
/// Takayama et al. 2013.
const NEARNESS: f64 = -0.25;

/// Normals whose dot product is nearly -1 have no least rotation from one to the other.
const OPPOSITE: f64 = 1e-9;

/// Barycentric weights this far below 0 still count: a point on an edge has one of its two
/// triangles.
const SLACK: f64 = 1e-9;

/// A place in the map: u and v.
pub type Uv = [f64; 2];

/// A vertex, or a seed: its place, the normal of the surface there, and the u axis.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The place.
    pub place: &'a Point,
    /// The unit normal.
    pub normal: &'a Point,
    /// The u axis.
    pub axis: &'a Point,
}

/// What a vertex hands on to its neighbour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// The step in (u, v).
    pub step: Uv,
    /// The u axis at the neighbour.
    pub axis: Point,
}

/// Return what a vertex hands on to a neighbour at a place with a normal.
///
/// None if the neighbour is straight above it, or they face opposite ways.
#[inline]
pub fn propose(from: Frame<'_>, place: &Point, normal: &Point) -> Option<Proposal> {
    let (n, u) = (from.normal, from.axis);
    let away = subtract(place, from.place);
    let distance = length(&away);
    let up = dot(&away, n);
    let along = [0, 1, 2].map(|c| away[c] - up * n[c]);
    let flat = length(&along);
    let facing = dot(n, normal);
    if flat <= OPPOSITE * distance || 1.0 + facing <= OPPOSITE {
        return None;
    }
    let step = [*u, cross(n, u)].map(|axis| dot(&along, &axis) * distance / flat);
    let turn = dot(u, normal) / (1.0 + facing);
    let axis = [0, 1, 2].map(|c| u[c] - turn * (n[c] + normal[c]));
    Some(Proposal { step, axis })
}

/// Put a u axis into the tangent plane, at length 1; false if there is none.
fn settle(axis: &mut Point, normal: &Point) -> bool {
    // Adding 0 makes 0 of -0.
    let up = 0.0 + dot(axis, normal);
    for c in 0..3 {
        axis[c] -= up * normal[c];
    }
    let size = dot(axis, axis);
    if size <= OPPOSITE * OPPOSITE {
        return false;
    }
    *axis = axis.map(|x| x / size.sqrt());
    true
}

/// The neighbours of vertices along edges.
#[derive(Clone, Copy, Debug)]
pub struct Stars<'a> {
    /// The first place of each vertex in the list of neighbours, and the list's length.
    pub start: &'a [i32],
    /// The neighbours, vertex by vertex.
    pub neighbours: &'a [i32],
}

impl<'a> Stars<'a> {
    /// Return the neighbours of a vertex.
    fn of(&self, vertex: usize) -> &'a [i32] {
        &self.neighbours[self.start[vertex] as usize..self.start[vertex + 1] as usize]
    }
}

/// Distinct vertices that a map is spread from.
#[derive(Clone, Copy, Debug)]
pub struct Seeds<'a> {
    /// The vertices.
    pub vertices: &'a [i32],
    /// Their (u, v).
    pub uv: &'a [Uv],
    /// Their u axes.
    pub axes: &'a [Point],
    /// Their distances.
    pub distance: &'a [f64],
}

/// How far a map goes: beyond the distance, or the box, nothing is handed on.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Distance along edges from the seeds.
    pub distance: f64,
    /// The least u and v.
    pub low: Uv,
    /// The largest u and v.
    pub high: Uv,
}

impl Extent {
    /// Return whether a place is out of the box.
    fn is_beyond(&self, uv: &Uv) -> bool {
        (0..2).any(|c| uv[c] < self.low[c] || uv[c] > self.high[c])
    }
}

/// Vertices with (u, v), in order of their distance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spread {
    /// The vertices.
    pub vertices: Vec<i32>,
    /// Their (u, v).
    pub uv: Vec<Uv>,
    /// Their distances along edges.
    pub distance: Vec<f64>,
}

/// The front of a map as it spreads.
struct Front<'a> {
    vertices: &'a [Point],
    normals: &'a [Point],
    stars: Stars<'a>,
    frozen: Vec<bool>,
    uv: Vec<Uv>,
    axes: Vec<Point>,
}

impl Front<'_> {
    /// Give a vertex the means of what its frozen neighbours hand on; false if there is nothing.
    fn blend(&mut self, q: usize) -> bool {
        let (place, normal) = (&self.vertices[q], &self.normals[q]);
        let mut total = 0.0;
        let mut uv = [0.0; 2];
        let mut axis = [0.0; 3];
        for &p in self.stars.of(q) {
            let p = p as usize;
            if !self.frozen[p] {
                continue;
            }
            let from = Frame {
                place: &self.vertices[p],
                normal: &self.normals[p],
                axis: &self.axes[p],
            };
            let Some(proposal) = propose(from, place, normal) else {
                continue;
            };
            let away = subtract(place, from.place);
            let weight = dot(&away, &away).powf(0.5 * NEARNESS);
            total += weight;
            uv = [0, 1].map(|c| uv[c] + weight * (self.uv[p][c] + proposal.step[c]));
            axis = [0, 1, 2].map(|c| axis[c] + weight * proposal.axis[c]);
        }
        self.axes[q] = axis;
        if total == 0.0 {
            return false;
        }
        self.uv[q] = uv.map(|x| x / total);
        true
    }
}

/// Spread (u, v) from seeds over vertices with unit normals.
pub fn spread_front(
    vertices: &[Point],
    normals: &[Point],
    stars: Stars<'_>,
    seeds: Seeds<'_>,
    extent: &Extent,
) -> Spread {
    let n = vertices.len();
    let mut far = vec![f64::INFINITY; n];
    let mut seeded = vec![false; n];
    let mut front = Front {
        vertices,
        normals,
        stars,
        frozen: vec![false; n],
        uv: vec![[0.0; 2]; n],
        axes: vec![[0.0; 3]; n],
    };
    let mut found = Vec::new();
    let mut heap = Heap::new();
    for (s, &seed) in seeds.vertices.iter().enumerate() {
        let q = seed as usize;
        far[q] = seeds.distance[s];
        seeded[q] = true;
        front.uv[q] = seeds.uv[s];
        front.axes[q] = seeds.axes[s];
        heap.push(far[q], seed);
    }
    while let Some((key, item)) = heap.pop() {
        if key > extent.distance {
            break;
        }
        let q = item as usize;
        if front.frozen[q] || key > far[q] {
            continue;
        }
        if !seeded[q] && !front.blend(q) {
            far[q] = f64::INFINITY;
            continue;
        }
        if extent.is_beyond(&front.uv[q]) || !settle(&mut front.axes[q], &normals[q]) {
            continue;
        }
        front.frozen[q] = true;
        found.push(item);
        for &p in stars.of(q) {
            let to = p as usize;
            if front.frozen[to] {
                continue;
            }
            let reached = key + length(&subtract(&vertices[q], &vertices[to]));
            if reached < far[to] && reached <= extent.distance {
                far[to] = reached;
                heap.push(reached, p);
            }
        }
    }
    Spread {
        uv: found.iter().map(|&q| front.uv[q as usize]).collect(),
        distance: found.iter().map(|&q| far[q as usize]).collect(),
        vertices: found,
    }
}

/// Return the triangles all of whose corners were found, and these corners as places in `found`.
///
/// Left out is a triangle with an edge more than `torn` times as long in (u, v) as it is: it lies
/// where two fronts met.
pub fn find_mapped(
    surface: Surface<'_>,
    found: &[i32],
    uv: &[Uv],
    torn: f64,
) -> (Vec<i32>, Vec<Triangle>) {
    let mut name = vec![-1; surface.vertices.len()];
    for (i, &vertex) in found.iter().enumerate() {
        name[vertex as usize] = i as i32;
    }
    let is_whole = |triangle: &Triangle, names: &Triangle| {
        (0..3).all(|e| {
            let next = (e + 1) % 3;
            let [a, b] = [e, next].map(|k| &surface.vertices[triangle[k] as usize]);
            let edge = subtract(b, a);
            let [p, q] = [e, next].map(|k| &uv[names[k] as usize]);
            let (du, dv) = (q[0] - p[0], q[1] - p[1]);
            du * du + dv * dv <= torn * torn * dot(&edge, &edge)
        })
    };
    surface
        .triangles
        .iter()
        .enumerate()
        .filter_map(|(f, triangle)| {
            let names = triangle.map(|v| name[v as usize]);
            let mapped = names.iter().all(|&i| i >= 0) && is_whole(triangle, &names);
            mapped.then_some((f as i32, names))
        })
        .unzip()
}

/// A grid over triangles of places (u, v).
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    /// Its low corner, the size of its cells, and their numbers.
    pub frame: &'a [Uv; 3],
    /// The first place of each cell in the list of triangles, and the list's length.
    pub start: &'a [i32],
    /// The triangles, cell by cell.
    pub triangles: &'a [i32],
}

impl<'a> Grid<'a> {
    /// Return the triangles of the cell that a place is in; of the nearest for one that is a little
    /// outside, as slack takes edges in.
    fn near(&self, place: &Uv) -> &'a [i32] {
        let [low, size, _] = self.frame;
        let counts = cell_counts(self.frame);
        let is_near = |c: usize| {
            let reach = (place[c] - low[c]) / size[c];
            place[c].is_finite() && -1.0 < reach && reach < (counts[c] + 1) as f64
        };
        if !(is_near(0) && is_near(1)) {
            return &[];
        }
        let [i, j] = [0, 1].map(|c| find_cell(place[c], low[c], size[c], counts[c]));
        let cell = (i * counts[1] + j) as usize;
        &self.triangles[self.start[cell] as usize..self.start[cell + 1] as usize]
    }
}

/// An owned [`Grid`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FiledTriangles {
    /// See [`Grid::frame`].
    pub frame: [Uv; 3],
    /// See [`Grid::start`].
    pub start: Vec<i32>,
    /// See [`Grid::triangles`].
    pub triangles: Vec<i32>,
}

/// Return the cell of a row in which a place is; the first or the last for one that is beyond.
#[inline(always)]
fn find_cell(x: f64, low: f64, size: f64, n: i64) -> i64 {
    (((x - low) / size) as i64).max(0).min(n - 1)
}

/// Return the numbers of a grid's cells along u and v.
fn cell_counts(frame: &[Uv; 3]) -> [i64; 2] {
    frame[2].map(|n| n as i64)
}

/// File triangles of places (u, v) by the cells of a grid.
pub fn file_triangles(uv: &[Uv], corners: &[Triangle]) -> FiledTriangles {
    let frame = frame_triangles(uv, corners);
    let counts @ [columns, rows] = cell_counts(&frame);
    let n_cells = (columns * rows) as usize;
    let boxes: Vec<[[i64; 2]; 2]> = corners
        .iter()
        .map(|triangle| {
            let places = triangle.map(|v| &uv[v as usize]);
            [0, 1].map(|c| {
                let [one, two, three] = places.map(|place| place[c]);
                let bounds = [min(min(one, two), three), max(max(one, two), three)];
                bounds.map(|x| find_cell(x, frame[0][c], frame[1][c], counts[c]))
            })
        })
        .collect();
    let cells = |&[[left, right], [low, high]]: &[[i64; 2]; 2]| {
        (left..=right).flat_map(move |i| (low..=high).map(move |j| (i * rows + j) as usize))
    };
    let mut start = vec![0; n_cells + 1];
    for cell in boxes.iter().flat_map(cells) {
        start[cell + 1] += 1;
    }
    for i in 0..n_cells {
        start[i + 1] += start[i];
    }
    let mut at = start.clone();
    let mut triangles = vec![0; start[n_cells] as usize];
    for (f, span) in boxes.iter().enumerate() {
        for cell in cells(span) {
            triangles[at[cell] as usize] = f as i32;
            at[cell] += 1;
        }
    }
    FiledTriangles {
        frame,
        start,
        triangles,
    }
}

/// Return the frame of a grid with about as many cells as triangles.
fn frame_triangles(uv: &[Uv], corners: &[Triangle]) -> [Uv; 3] {
    let mut frame = [[0.0; 2], [1.0; 2], [1.0; 2]];
    if corners.is_empty() {
        return frame;
    }
    let side = ((corners.len() as f64).sqrt() as i64).max(1) as f64;
    for c in 0..2 {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &corner in corners.as_flattened() {
            low = min(low, uv[corner as usize][c]);
            high = max(high, uv[corner as usize][c]);
        }
        frame[0][c] = low;
        if high > low {
            frame[1][c] = (high - low) / side;
            frame[2][c] = side;
        }
    }
    frame
}

/// Return the triangle that contains each (u, v) wanted, -1 without, and the weights of its corners.
///
/// Of several the one of the least distance, interpolated there. distance: of each place in `uv`.
pub fn find_containing(
    uv: &[Uv],
    corners: &[Triangle],
    distance: &[f64],
    grid: Grid<'_>,
    wanted: &[Uv],
) -> (Vec<i32>, Vec<[f64; 3]>) {
    let mut found = vec![-1; wanted.len()];
    let mut weights = vec![[0.0; 3]; wanted.len()];
    for ((place, found), weights) in wanted.iter().zip(&mut found).zip(&mut weights) {
        let mut best = f64::INFINITY;
        for &triangle in grid.near(place) {
            let corners = corners[triangle as usize].map(|v| v as usize);
            let Some(shares) = weigh(corners.map(|v| &uv[v]), place) else {
                continue;
            };
            let [a, b, c] = [0, 1, 2].map(|k| shares[k] * distance[corners[k]]);
            let far = a + b + c;
            if far < best {
                best = far;
                *found = triangle;
                *weights = shares;
            }
        }
    }
    (found, weights)
}

/// Return the weights of a triangle's corners at a place; None if it is outside.
fn weigh([a, b, c]: [&Uv; 3], place: &Uv) -> Option<[f64; 3]> {
    let (ux, uy) = (b[0] - a[0], b[1] - a[1]);
    let (vx, vy) = (c[0] - a[0], c[1] - a[1]);
    let area = ux * vy - uy * vx;
    if area == 0.0 {
        return None;
    }
    let (px, py) = (place[0] - a[0], place[1] - a[1]);
    let one = (px * vy - py * vx) / area;
    let two = (ux * py - uy * px) / area;
    if one < -SLACK || two < -SLACK || one + two > 1.0 + SLACK {
        return None;
    }
    let one = min(max(one, 0.0), 1.0);
    let two = min(max(two, 0.0), 1.0 - one);
    Some([1.0 - one - two, one, two])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of n x n vertices in the plane z = 0, at steps of 1.
    fn square(n: i32) -> (Vec<Point>, Vec<Triangle>, Vec<i32>, Vec<i32>) {
        let place = |k: i32| [f64::from(k / n), f64::from(k % n), 0.0];
        let vertices: Vec<Point> = (0..n * n).map(place).collect();
        let mut triangles = Vec::new();
        for i in 0..n - 1 {
            for j in 0..n - 1 {
                let a = i * n + j;
                triangles.push([a, a + n, a + n + 1]);
                triangles.push([a, a + n + 1, a + 1]);
            }
        }
        let mut start = vec![0];
        let mut star = Vec::new();
        for v in 0..n * n {
            let mut near: Vec<i32> = triangles
                .iter()
                .filter(|triangle| triangle.contains(&v))
                .flatten()
                .copied()
                .filter(|&w| w != v)
                .collect();
            near.sort_unstable();
            near.dedup();
            star.extend(near);
            start.push(star.len() as i32);
        }
        (vertices, triangles, start, star)
    }

    #[test]
    fn a_map_of_a_plane_is_the_plane() {
        let (vertices, triangles, start, neighbours) = square(5);
        let stars = Stars {
            start: &start,
            neighbours: &neighbours,
        };
        let seeds = Seeds {
            vertices: &[12],
            uv: &[[0.0; 2]],
            axes: &[[1.0, 0.0, 0.0]],
            distance: &[0.0],
        };
        let extent = Extent {
            distance: 10.0,
            low: [-1.5; 2],
            high: [1.5; 2],
        };
        let up = vec![[0.0, 0.0, 1.0]; 25];
        let found = spread_front(&vertices, &up, stars, seeds, &extent);
        assert_eq!(found.vertices.len(), 9);
        for (&v, uv) in found.vertices.iter().zip(&found.uv) {
            let at = vertices[v as usize];
            assert!((uv[0] - (at[0] - 2.0)).abs() < 1e-12);
            assert!((uv[1] - (at[1] - 2.0)).abs() < 1e-12);
        }
        let surface = Surface {
            vertices: &vertices,
            triangles: &triangles,
        };
        let (mapped, corners) = find_mapped(surface, &found.vertices, &found.uv, 2.5);
        assert_eq!(mapped.len(), 8);
        let filed = file_triangles(&found.uv, &corners);
        let grid = Grid {
            frame: &filed.frame,
            start: &filed.start,
            triangles: &filed.triangles,
        };
        let wanted = [[0.3, -0.6], [1.7, 0.0], [f64::NAN, 0.0]];
        let (held, weights) = find_containing(&found.uv, &corners, &found.distance, grid, &wanted);
        assert_eq!(held[1..], [-1, -1]);
        let names = corners[held[0] as usize];
        let blended = [0, 1].map(|c| {
            let part = |k: usize| weights[0][k] * found.uv[names[k] as usize][c];
            part(0) + part(1) + part(2)
        });
        assert!((blended[0] - 0.3).abs() < 1e-12);
        assert!((blended[1] + 0.6).abs() < 1e-12);
    }

    #[test]
    fn a_neighbour_straight_above_gets_nothing() {
        let from = Frame {
            place: &[0.0; 3],
            normal: &[0.0, 0.0, 1.0],
            axis: &[1.0, 0.0, 0.0],
        };
        assert_eq!(propose(from, &[0.0, 0.0, 2.0], &[0.0, 0.0, 1.0]), None);
        assert_eq!(propose(from, &[1.0, 0.0, 0.0], &[0.0, 0.0, -1.0]), None);
    }
}
