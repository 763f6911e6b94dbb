//! How a fill lies across its loop, and the equations that place it.

use std::f64::consts::{FRAC_PI_2, PI};

use patterndb_geometry::Point;
use patterndb_geometry::sorting::argsort;
use patterndb_geometry::vector::{cross, length, max, min, subtract};

use super::{edge_key, sum_products};
use crate::recognition::HalfEdgesByTail;

/// A quad is turned over where it lies folded back on the faces across two of its edges or more: the
/// cosine of the angle between normals is less than this. Artists' own quads meet across one edge at
/// any angle, around a thin rim; across two they hardly ever are more than 120 degrees apart.
const FOLDED: f64 = -0.5;

/// A fill and the faces around it. The loop's vertices come first, then the others of the faces
/// around, then the fill's own.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    /// The fill's quads.
    pub quads: &'a [[i64; 4]],
    /// The vertices of each face around, face after face.
    pub corners: &'a [i64],
    /// Where those of each begin, and how many there are in all.
    pub offsets: &'a [i64],
}

impl<'a> Mesh<'a> {
    /// Iterate over the faces around, then over the quads.
    fn faces(&self) -> impl Iterator<Item = &'a [i64]> + use<'a> {
        let (corners, offsets) = (self.corners, self.offsets);
        let around = offsets.windows(2);
        let around = around.map(|bounds| &corners[bounds[0] as usize..bounds[1] as usize]);
        around.chain(self.quads.iter().map(<[i64; 4]>::as_slice))
    }

    /// Iterate over the faces' corners: each vertex, the next and the one before in its face.
    fn all_corners(&self) -> impl Iterator<Item = [i64; 3]> + use<'a> {
        let of_face = |face: &'a [i64]| {
            let next = face.iter().cycle().skip(1);
            let before = face.last().into_iter().chain(face);
            let around = face.iter().zip(next).zip(before);
            around.map(|((&v, &next), &before)| [v, next, before])
        };
        self.faces().flat_map(of_face)
    }
}

/// The vertices at the other ends of edges, once for each face at the edge.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Neighbours {
    /// Where those of each vertex begin, and how many there are in all.
    pub start: Vec<i64>,
    /// The neighbours, vertex after vertex.
    pub beside: Vec<i64>,
}

/// List the neighbours of every vertex: for each face, the next vertex and the one before.
pub fn neighbours(mesh: &Mesh, n_points: usize) -> Neighbours {
    let mut start = vec![0; n_points + 1];
    let vertices = mesh.corners.iter().chain(mesh.quads.as_flattened());
    for &v in vertices {
        start[v as usize + 1] += 2;
    }
    for v in 0..n_points {
        start[v + 1] += start[v];
    }
    let mut free = start.clone();
    let mut beside = vec![0; start[n_points] as usize];
    mesh.all_corners().for_each(|[v, next, before]| {
        let free = &mut free[v as usize];
        let at = *free as usize;
        beside[at..at + 2].copy_from_slice(&[next, before]);
        *free += 2;
    });
    Neighbours { start, beside }
}

/// The umbrella Laplacian of inner vertices, then of loop vertices: a matrix by rows, columns and
/// weights of its entries, and the right-hand side of each row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Laplacian {
    /// The rows of the entries.
    pub row: Vec<i64>,
    /// Their columns, inner vertices.
    pub column: Vec<i64>,
    /// Their weights.
    pub weight: Vec<f64>,
    /// What each row amounts to.
    pub right: Vec<Point>,
}

impl Laplacian {
    fn add(&mut self, row: usize, column: usize, weight: f64) {
        self.row.push(row as i64);
        self.column.push(column as i64);
        self.weight.push(weight);
    }
}

/// Return the Laplacian of a mesh whose vertices from `n_outer` on are inner ones, to be placed, and
/// whose first `n_loop` vertices are the loop's.
///
/// `start` and `beside` are those of [`Neighbours`].
pub fn laplacian_rows(
    points: &[Point],
    start: &[i64],
    beside: &[i64],
    n_outer: usize,
    n_loop: usize,
) -> Laplacian {
    let n_inner = start.len() - 1 - n_outer;
    let mut made = Laplacian {
        right: vec![[0.0; 3]; n_inner + n_loop],
        ..Laplacian::default()
    };
    for (row, v) in (n_outer..n_outer + n_inner).chain(0..n_loop).enumerate() {
        let neighbours = &beside[start[v] as usize..start[v + 1] as usize];
        if neighbours.is_empty() {
            continue;
        }
        let degree = neighbours.len() as f64;
        for &j in neighbours {
            let j = j as usize;
            if j >= n_outer {
                made.add(row, j - n_outer, 1.0 / degree);
            } else {
                let right = made.right[row].iter_mut();
                right
                    .zip(points[j])
                    .for_each(|(right, at)| *right -= at / degree);
            }
        }
        if v >= n_outer {
            made.add(row, v - n_outer, -1.0);
        } else {
            let right = made.right[row].iter_mut();
            right.zip(points[v]).for_each(|(right, at)| *right += at);
        }
    }
    made
}

/// The number of measures; `MEASURES` in query/holes/shape.py names them in the same order.
pub const N_MEASURES: usize = 23;

/// What surrounds a fill.
#[derive(Clone, Copy, Debug)]
pub struct Around<'a> {
    /// Unit normals of the faces outside at the loop's vertices.
    pub normals: &'a [Point],
    /// Unit normals of the faces across the loop's edges, 0 where there is none.
    pub beyond: &'a [Point],
    /// The number of the loop's vertices, which come first.
    pub n_loop: usize,
    /// The number of vertices that are not the fill's own.
    pub n_outer: usize,
    /// The length of edges around.
    pub scale: f64,
    /// The area of faces around.
    pub area: f64,
}

/// Mean and spread of numbers by their sum and the sum of their squares.
#[derive(Default)]
struct Moments {
    sum: f64,
    squares: f64,
    count: usize,
}

impl Moments {
    fn add(&mut self, number: f64) {
        self.sum += number;
        self.squares += number * number;
        self.count += 1;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count as f64
    }

    fn spread(&self) -> f64 {
        let mean = self.mean();
        max(self.squares / self.count as f64 - mean * mean, 0.0).sqrt()
    }
}

/// The mean of numbers, 0 where there are none.
#[derive(Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, number: f64) {
        self.sum += number;
        self.count += 1;
    }

    fn value(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }
}

/// A fill that lies in space.
struct Placed<'a> {
    mesh: Mesh<'a>,
    points: &'a [Point],
    around: Around<'a>,
    valence: Vec<i32>,
    /// Unit normals of the quads, 0 where they have no area.
    normal: Vec<Point>,
    /// Sums of the normals at the vertices.
    vertex_normal: Vec<Point>,
}

impl<'a> Placed<'a> {
    fn new(points: &'a [Point], mesh: Mesh<'a>, around: Around<'a>) -> Placed<'a> {
        let mut placed = Placed {
            mesh,
            points,
            around,
            valence: vec![0; points.len()],
            normal: Vec::with_capacity(mesh.quads.len()),
            vertex_normal: vec![[0.0; 3]; points.len()],
        };
        for quad in mesh.quads {
            let crossed = placed.cross_diagonals(quad);
            let size = length(&crossed);
            let normal = if size > 0.0 {
                crossed.map(|axis| axis / size)
            } else {
                [0.0; 3]
            };
            placed.normal.push(normal);
            for &v in quad {
                placed.valence[v as usize] += 1;
                add(&mut placed.vertex_normal[v as usize], &normal);
            }
        }
        let at_loop = placed.vertex_normal[..around.n_loop].iter_mut();
        for (sum, normal) in at_loop.zip(around.normals) {
            add(sum, &normal.map(|axis| 2.0 * axis));
        }
        placed
    }

    fn point(&self, v: i64) -> &'a Point {
        &self.points[v as usize]
    }

    /// Return the vector between two vertices.
    fn between(&self, from: i64, to: i64) -> Point {
        subtract(self.point(to), self.point(from))
    }

    /// Return the cross product of a quad's diagonals.
    fn cross_diagonals(&self, quad: &[i64; 4]) -> Point {
        cross(
            &self.between(quad[0], quad[2]),
            &self.between(quad[1], quad[3]),
        )
    }

    fn is_on_loop(&self, v: i64) -> bool {
        v < self.around.n_loop as i64
    }

    fn is_inner(&self, v: i64) -> bool {
        v >= self.around.n_outer as i64
    }

    /// Return the loop vertices after and before one.
    fn loop_neighbours(&self, v: i64) -> [i64; 2] {
        let n = self.around.n_loop as i64;
        [(v + 1) % n, (v + n - 1) % n]
    }

    /// Return whether an edge is one of the loop's, and runs as it does.
    fn is_loop_edge(&self, v: i64, w: i64) -> bool {
        self.is_on_loop(v) && w == self.loop_neighbours(v)[0]
    }

    /// Return the logarithm of a length, in units of the scale.
    fn log_length(&self, length: f64) -> f64 {
        (max(length, self.tiny()) / self.around.scale).ln()
    }

    /// Return the least length that counts.
    fn tiny(&self) -> f64 {
        1e-6 * self.around.scale
    }
}

fn add(sum: &mut Point, vector: &Point) {
    for (sum, vector) in sum.iter_mut().zip(vector) {
        *sum += vector;
    }
}

/// What is measured at the corners of quads.
struct CornerMeasures {
    /// Logarithms of the lengths of edges that are not the loop's.
    edges: Moments,
    /// How these differ from those of the loop, where they meet it.
    loop_ratio: Mean,
    /// Squared angles less right ones.
    angles: f64,
    worst_angle: f64,
    /// The least cosine between a corner's normal and its vertex's.
    least_outward: f64,
    /// Squared angles at irregular vertices less equal ones.
    irregular: Mean,
    /// Angles at the loop less right ones.
    loop_angles: f64,
    worst_loop_angle: f64,
}

impl CornerMeasures {
    fn new() -> CornerMeasures {
        CornerMeasures {
            edges: Moments::default(),
            loop_ratio: Mean::default(),
            angles: 0.0,
            worst_angle: 0.0,
            least_outward: 1.0,
            irregular: Mean::default(),
            loop_angles: 0.0,
            worst_loop_angle: 0.0,
        }
    }

    /// Measure corner `e` of quad `f`; return its scaled Jacobian, and the length of the edge after
    /// it.
    fn add(&mut self, placed: &Placed, f: usize, e: usize) -> (f64, f64) {
        let quad = &placed.mesh.quads[f];
        let [v, w, u] = [e, (e + 1) % 4, (e + 3) % 4].map(|e| quad[e]);
        let (a, b) = (placed.between(v, w), placed.between(v, u));
        let (la, lb) = (length(&a), length(&b));
        let crossed = cross(&a, &b);
        let jacobian = sum_products(&crossed, &placed.normal[f]) / max(la * lb, 1e-300);
        let mut angle = length(&crossed).atan2(sum_products(&a, &b));
        if jacobian < 0.0 {
            angle = 2.0 * PI - angle;
        }
        let vertex_normal = &placed.vertex_normal[v as usize];
        let size = la * lb * length(vertex_normal);
        let outward = sum_products(&crossed, vertex_normal) / max(size, 1e-300);
        self.least_outward = min(self.least_outward, outward);
        self.add_angle(placed, v, angle);
        if !placed.is_loop_edge(v, w) {
            self.add_edge(placed, v, w, la);
        }
        (jacobian, la)
    }

    fn add_angle(&mut self, placed: &Placed, v: i64, angle: f64) {
        let off = angle - FRAC_PI_2;
        self.angles += off * off;
        self.worst_angle = max(self.worst_angle, off.abs());
        let valence = placed.valence[v as usize];
        if placed.is_inner(v) && valence != super::REGULAR {
            let off = angle - 2.0 * PI / f64::from(valence);
            self.irregular.add(off * off);
        }
        if placed.is_on_loop(v) {
            self.loop_angles += off.abs();
            self.worst_loop_angle = max(self.worst_loop_angle, off.abs());
        }
    }

    /// Measure an edge that is not the loop's; those inside are met twice, from both of their quads.
    fn add_edge(&mut self, placed: &Placed, v: i64, w: i64, size: f64) {
        let log = placed.log_length(size);
        self.edges.add(log);
        if placed.is_on_loop(v) && placed.is_inner(w) {
            let [x, y] = placed
                .loop_neighbours(v)
                .map(|w| length(&placed.between(w, v)));
            let of_loop = placed.log_length((x * y).sqrt());
            self.loop_ratio.add((log - of_loop).abs());
        }
    }
}

/// What is measured of quads as a whole.
struct QuadMeasures {
    /// The least scaled Jacobian of all corners, and the mean of the least of each quad.
    least_jacobian: f64,
    jacobians: f64,
    /// Logarithms of the ratio of a quad's sides.
    aspects: f64,
    worst_aspect: f64,
    /// Logarithms of the ratios of opposite edges.
    opposite: f64,
    /// Logarithms of areas.
    areas: Moments,
}

impl QuadMeasures {
    fn new() -> QuadMeasures {
        QuadMeasures {
            least_jacobian: 1.0,
            jacobians: 0.0,
            aspects: 0.0,
            worst_aspect: 0.0,
            opposite: 0.0,
            areas: Moments::default(),
        }
    }

    /// Measure a quad with these lengths of edges and this least scaled Jacobian.
    fn add(&mut self, placed: &Placed, quad: &[i64; 4], side: &[f64; 4], worst: f64) {
        let tiny = placed.tiny();
        let ratio = |a: f64, b: f64| (max(a, tiny) / max(b, tiny)).ln().abs();
        let aspect = ratio(side[0] + side[2], side[1] + side[3]);
        self.worst_aspect = max(self.worst_aspect, aspect);
        self.aspects += aspect;
        for e in 0..2 {
            self.opposite += ratio(side[e], side[e + 2]);
        }
        let area = length(&placed.cross_diagonals(quad)) / 2.0;
        let whole = placed.around.area;
        self.areas.add((max(area, 1e-6 * whole) / whole).ln());
        self.least_jacobian = min(self.least_jacobian, worst);
        self.jacobians += worst;
    }
}

/// Measure how a fill lies; return the measures, of which that of bending, the 17th, is left 0, and
/// the number of quads that are turned over.
pub fn measure_fill(points: &[Point], mesh: Mesh, around: Around) -> ([f64; N_MEASURES], usize) {
    let placed = Placed::new(points, mesh, around);
    let mut corners = CornerMeasures::new();
    let mut quads = QuadMeasures::new();
    for (f, quad) in mesh.quads.iter().enumerate() {
        let mut worst = 1.0;
        let side = [0, 1, 2, 3].map(|e| {
            let (jacobian, side) = corners.add(&placed, f, e);
            worst = min(worst, jacobian);
            side
        });
        quads.add(&placed, quad, &side, worst);
    }
    let (folds, flipped) = find_folds(&placed);
    let (jump, at_loop) = measure_jump(&placed);
    let bends = strand_bends(&placed);
    let n_quads = mesh.quads.len() as f64;
    let n_loop = around.n_loop as f64;
    let has_edges = corners.edges.count > 0;
    let measures = [
        if has_edges { corners.edges.mean() } else { 0.0 },
        if has_edges {
            corners.edges.spread()
        } else {
            0.0
        },
        corners.loop_ratio.value(),
        quads.least_jacobian,
        quads.jacobians / n_quads,
        flipped as f64 / n_quads,
        corners.angles / n_quads,
        quads.opposite / n_quads,
        quads.areas.spread(),
        quads.areas.mean().abs(),
        bends.at_loop.value(),
        bends.inner.value(),
        corners.irregular.value(),
        jump / n_loop,
        corners.loop_angles / n_loop,
        corners.worst_loop_angle,
        0.0,
        quads.worst_aspect,
        quads.aspects / n_quads,
        corners.worst_angle,
        f64::from(u8::from(flipped > 0)),
        corners.least_outward,
        max(folds, at_loop),
    ];
    (measures, flipped)
}

/// Return 1 less the cosine of the greatest angle between the normals of quads with a common edge;
/// and the number of quads that are turned over.
fn find_folds(placed: &Placed) -> (f64, usize) {
    let quads = placed.mesh.quads;
    let mut keys = Vec::with_capacity(4 * quads.len());
    let mut folded = vec![0; quads.len()];
    for (f, quad) in quads.iter().enumerate() {
        for e in 0..4 {
            let (v, w) = (quad[e], quad[(e + 1) % 4]);
            keys.push(edge_key(v, w, placed.points.len()));
            if placed.is_loop_edge(v, w) {
                let cosine = sum_products(&placed.normal[f], &placed.around.beyond[v as usize]);
                folded[f] += i32::from(cosine < FOLDED);
            }
        }
    }
    let mut worst = 0.0;
    for pair in argsort(&keys).windows(2) {
        if keys[pair[0]] == keys[pair[1]] {
            let (a, b) = (pair[0] / 4, pair[1] / 4);
            let cosine = sum_products(&placed.normal[a], &placed.normal[b]);
            worst = max(worst, 1.0 - cosine);
            if cosine < FOLDED {
                folded[a] += 1;
                folded[b] += 1;
            }
        }
    }
    (worst, folded.iter().filter(|&&edges| edges > 1).count())
}

/// Return the sum and the greatest of 1 less the cosine between the normals of quads at the loop's
/// edges and those outside.
fn measure_jump(placed: &Placed) -> (f64, f64) {
    let normals = placed.around.normals;
    let (mut jump, mut worst) = (0.0, 0.0);
    for (quad, normal) in placed.mesh.quads.iter().zip(&placed.normal) {
        for e in 0..4 {
            let (v, w) = (quad[e], quad[(e + 1) % 4]);
            if !placed.is_loop_edge(v, w) {
                continue;
            }
            let mut outer = normals[v as usize];
            add(&mut outer, &normals[w as usize]);
            let size = length(&outer);
            if size > 0.0 {
                let bend = 1.0 - sum_products(&outer, normal) / size;
                jump += bend;
                worst = max(worst, bend);
            }
        }
    }
    (jump, worst)
}

/// Squared bends of strands at regular vertices, in radians: of those that cross the loop, at it; and
/// inside.
#[derive(Default)]
struct Bends {
    at_loop: Mean,
    inner: Mean,
}

fn strand_bends(placed: &Placed) -> Bends {
    let corners: Vec<[i64; 3]> = placed.mesh.all_corners().collect();
    let tail: Vec<i32> = corners.iter().map(|corner| corner[0] as i32).collect();
    let leaving = HalfEdgesByTail::new(&tail, placed.points.len());
    let mut bends = Bends::default();
    let vertices =
        (0..placed.points.len() as i64).filter(|&v| placed.is_on_loop(v) || placed.is_inner(v));
    for v in vertices {
        let Some(ring) = walk_ring(&corners, leaving.of(v as i32)) else {
            continue;
        };
        for (x, y) in [(ring[0], ring[2]), (ring[1], ring[3])] {
            let (a, b) = (placed.between(v, x), placed.between(v, y));
            let bend = PI - length(&cross(&a, &b)).atan2(sum_products(&a, &b));
            if placed.is_inner(v) {
                bends.inner.add(bend * bend);
                continue;
            }
            let [next, previous] = placed.loop_neighbours(v);
            if (x, y) != (next, previous) && (y, x) != (next, previous) {
                bends.at_loop.add(bend * bend);
            }
        }
    }
    bends
}

/// Return the four neighbours of a vertex in order, if four faces are all around it.
///
/// `leaving` lists its corners.
fn walk_ring(corners: &[[i64; 3]], leaving: &[i32]) -> Option<[i64; 4]> {
    let &[first, _, _, _] = leaving else {
        return None;
    };
    let mut h = first as usize;
    let mut ring = [0; 4];
    for neighbour in &mut ring {
        let [_, head, before] = corners[h];
        *neighbour = head;
        let following = leaving.iter().rfind(|&&g| corners[g as usize][1] == before);
        h = *following? as usize;
    }
    Some(ring)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop of eight edges around a grid of two by two quads in the plane.
    const GRID: Mesh = Mesh {
        quads: &[[0, 1, 8, 7], [1, 2, 3, 8], [7, 8, 5, 6], [8, 3, 4, 5]],
        corners: &[],
        offsets: &[0],
    };
    const POINTS: [Point; 9] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
        [2.0, 2.0, 0.0],
        [1.0, 2.0, 0.0],
        [0.0, 2.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    const UP: Point = [0.0, 0.0, 1.0];
    const AROUND: Around = Around {
        normals: &[UP; 8],
        beyond: &[UP; 8],
        n_loop: 8,
        n_outer: 8,
        scale: 1.0,
        area: 1.0,
    };

    #[test]
    fn a_flat_grid_of_squares_is_perfect() {
        let (measures, flipped) = measure_fill(&POINTS, GRID, AROUND);
        let mut perfect = [0.0; N_MEASURES];
        (perfect[3], perfect[4], perfect[21]) = (1.0, 1.0, 1.0);
        assert_eq!((measures, flipped), (perfect, 0));
    }

    #[test]
    fn quads_that_lie_on_their_backs_are_turned_over() {
        let mut points = POINTS;
        for point in &mut points {
            point[0] = -point[0];
        }
        let (measures, flipped) = measure_fill(&points, GRID, AROUND);
        assert_eq!(flipped, 4);
        assert_eq!(measures[22], 2.0);
    }

    #[test]
    fn the_laplacian_averages_neighbours() {
        let Neighbours { start, beside } = neighbours(&GRID, 9);
        assert_eq!(beside[start[8] as usize..], [7, 1, 1, 3, 5, 7, 3, 5]);
        let made = laplacian_rows(&POINTS, &start, &beside, 8, 8);
        // The neighbours of vertices 1, 3, 5 and 7 are known, except for the inner one, which each has twice.
        assert_eq!(made.row, [0, 2, 2, 4, 4, 6, 6, 8, 8]);
        assert_eq!((made.weight[0], made.weight[1]), (-1.0, 1.0 / 4.0));
        assert_eq!(made.right[0], [-1.0, -1.0, 0.0]);
        assert_eq!(made.right.len(), 9);
    }
}
