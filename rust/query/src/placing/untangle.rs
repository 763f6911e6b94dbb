//! Untangling: moves vertices within their tangent planes until no quad is flipped.
//!
//! Every corner of every quad is a triangle whose energy blows up as its area falls to zero: see
//! [`patterndb_geometry::barrier`]. Differs from its source (Garanzha et al. 2021): the triangles lie
//! on a surface and are measured against its normals, and where sharpening no longer opens triangles
//! it ends.

use patterndb_geometry::Point;
use patterndb_geometry::barrier::{Energy, Measure, Minimiser, SmoothArea, smooth_area};
use patterndb_geometry::vector::{cross, dot, max, min, subtract};

use super::laplace::Frame;

/// Rounds of sharpening, and L-BFGS steps in each.
const ROUNDS: usize = 14;
const STEPS: usize = 60;

/// From round to round the blow-up is smoothed over this part of the area before, at least.
const SHARPENED: f64 = 0.3;

/// Where two rounds leave more than a part of the flipped corners, there are too few vertices around to
/// open them. Of this many corners, or fewer, it says nothing.
const MANY: f64 = 40.0;

/// Steps that L-BFGS remembers.
const MEMORY: usize = 8;

/// The smoothing of what has no flipped corner.
const SHARP: f64 = 1e-5;

/// Return names of the pieces that quads are in: those with a free vertex in common are in one. Every
/// quad has a free vertex.
pub fn find_pieces(quads: &[[i32; 4]], free: &[bool]) -> Vec<i32> {
    let mut root: Vec<i32> = (0..free.len() as i32).collect();
    let free_of = |quad: &[i32; 4]| quad.iter().copied().find(|&at| free[at as usize]);
    for quad in quads {
        let mut first = None;
        for &vertex in quad.iter().filter(|&&at| free[at as usize]) {
            let mut at = vertex;
            while root[at as usize] != at {
                root[at as usize] = root[root[at as usize] as usize];
                at = root[at as usize];
            }
            let low = first.map_or(at, |first| at.min(first));
            if let Some(first) = first {
                root[at.max(first) as usize] = low;
            }
            first = Some(low);
        }
    }
    let find = |quad: &[i32; 4]| {
        let mut at = free_of(quad).expect("a quad has a free vertex");
        while root[at as usize] != at {
            at = root[at as usize];
        }
        at
    };
    quads.iter().map(find).collect()
}

/// Quads to be untangled, on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Tangle<'a> {
    /// The quads' vertices.
    pub quads: &'a [[i32; 4]],
    /// Which of their corners are wanted to have an area.
    pub wanted: &'a [[bool; 4]],
    /// The surface's unit normal at each quad.
    pub up: &'a [Point],
}

impl<'a> Tangle<'a> {
    /// Return the quads with a wanted corner.
    fn quads(&self) -> Vec<Quad<'a>> {
        let each = self.quads.iter().zip(self.wanted).zip(self.up);
        let quads = each.map(|((quad, &wanted), up)| Quad {
            vertices: quad.map(|v| v as usize),
            wanted,
            up,
        });
        quads.filter(|quad| quad.wanted.contains(&true)).collect()
    }
}

struct Quad<'a> {
    vertices: [usize; 4],
    wanted: [bool; 4],
    /// The surface's normal.
    up: &'a Point,
}

/// A corner of a quad: a triangle.
struct Corner<'a> {
    /// The vertex at the corner, and those after and before it in the quad.
    vertices: [usize; 3],
    /// From the corner's vertex to that after it.
    u: Point,
    /// From the corner's vertex to that before it.
    v: Point,
    up: &'a Point,
}

impl<'a> Quad<'a> {
    /// Return the edges, each from a corner's vertex to that after it, in sizes.
    #[inline(always)]
    fn edges(&self, size: f64, points: &[Point]) -> [Point; 4] {
        let [a, b, c, d] = self.vertices;
        let mut edges = [[0.0; 3]; 4];
        for (edge, (from, to)) in edges.iter_mut().zip([(a, b), (b, c), (c, d), (d, a)]) {
            let [x, y, z] = subtract(&points[to], &points[from]);
            *edge = [x / size, y / size, z / size];
        }
        edges
    }

    /// Return the wanted corners, given the edges.
    #[inline(always)]
    fn corners(&self, edges: &[Point; 4]) -> impl Iterator<Item = Corner<'a>> {
        let wanted = (0..4).filter(|&e| self.wanted[e]);
        wanted.map(move |e| {
            let (after, before) = ((e + 1) % 4, (e + 3) % 4);
            let [x, y, z] = edges[before];
            Corner {
                vertices: [
                    self.vertices[e],
                    self.vertices[after],
                    self.vertices[before],
                ],
                u: edges[e],
                // Taken from 0, 0 does not become -0.
                v: [0.0 - x, 0.0 - y, 0.0 - z],
                up: self.up,
            }
        })
    }
}

impl Corner<'_> {
    /// Return twice the area, below 0 if it is flipped.
    #[inline(always)]
    fn area(&self) -> f64 {
        dot(self.up, &cross(&self.u, &self.v))
    }
}

/// Measure the energy of all wanted corners; write its gradient by the vertices' points into `force`.
fn measure(
    quads: &[Quad],
    size: f64,
    epsilon: f64,
    points: &[Point],
    force: &mut [Point],
) -> Measure {
    force.fill([0.0; 3]);
    let mut energy = 0.0;
    let mut smallest = f64::INFINITY;
    for quad in quads {
        let edges = quad.edges(size, points);
        for corner in quad.corners(&edges) {
            let area = corner.area();
            let Corner { u, v, up, .. } = &corner;
            smallest = min(smallest, area);
            let SmoothArea { smooth, root } = smooth_area(area, epsilon);
            let norm = 0.5 * (dot(u, u) + v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            energy += norm / smooth;
            let by_norm = 1.0 / (smooth * size);
            let by_area = -norm / (smooth * root * size);
            let (area_by_u, area_by_v) = (cross(v, up), cross(up, u));
            let [i, j, k] = corner.vertices;
            for c in 0..3 {
                let by_u = by_norm * u[c] + by_area * area_by_u[c];
                let by_v = by_norm * v[c] + by_area * area_by_v[c];
                force[j][c] += by_u;
                force[k][c] += by_v;
                force[i][c] -= by_u + by_v;
            }
        }
    }
    Measure { energy, smallest }
}

/// Return how many wanted corners have no positive area.
fn count_flipped(quads: &[Quad], points: &[Point]) -> usize {
    let count = |quad: &Quad| {
        let edges = quad.edges(1.0, points);
        let corners = quad.corners(&edges);
        corners.filter(|corner| corner.area() <= 0.0).count()
    };
    quads.iter().map(count).sum()
}

/// Vertices that may move within their planes.
#[derive(Clone, Copy, Debug)]
pub struct Movable<'a> {
    /// The vertices.
    pub free: &'a [i32],
    /// The tangents of all vertices.
    pub frames: &'a [Frame],
}

impl Movable<'_> {
    fn each(&self) -> impl Iterator<Item = (usize, &Frame)> {
        let free = self.free.iter().map(|&i| i as usize);
        free.map(|i| (i, &self.frames[i]))
    }

    /// Write the parts of forces within the planes.
    fn write_parts(self, force: &[Point], gradient: &mut [f64]) {
        let (rows, _) = gradient.as_chunks_mut();
        for (row, (i, frame)) in rows.iter_mut().zip(self.each()) {
            *row = [0, 1].map(|f| 0.0 + dot(&frame[f], &force[i]));
        }
    }

    /// Move the vertices to coordinates in their planes, from where these begin.
    fn move_points(self, origin: &[Point], at: &[f64], points: &mut [Point]) {
        let (rows, _) = at.as_chunks();
        for ((origin, &[x, y]), (i, frame)) in origin.iter().zip(rows).zip(self.each()) {
            points[i] = [0, 1, 2].map(|c| origin[c] + x * frame[0][c] + y * frame[1][c]);
        }
    }
}

/// The energy of a tangle whose vertices move in their planes.
struct TangleEnergy<'a> {
    quads: &'a [Quad<'a>],
    movable: &'a Movable<'a>,
    size: f64,
    epsilon: f64,
    /// Where the movable vertices begin.
    origin: Vec<Point>,
    /// The vertices' points, as they were measured last.
    points: &'a mut [Point],
    /// The vertices' forces there.
    force: Vec<Point>,
}

impl Energy<f64> for TangleEnergy<'_> {
    fn measure(&mut self, at: &[f64]) -> Measure {
        self.movable.move_points(&self.origin, at, self.points);
        let force = &mut self.force;
        measure(self.quads, self.size, self.epsilon, self.points, force)
    }

    fn write_gradient(&self, gradient: &mut [f64]) {
        self.movable.write_parts(&self.force, gradient);
    }
}

/// Minimise the energy over the movable vertices, in place; return the smallest area left.
///
/// Once a round begins without a flipped corner it is the last, and keeps it so. Where two rounds
/// leave more than the part `left_over` of the flipped corners it ends, too.
pub fn minimise_energy(
    tangle: &Tangle,
    movable: &Movable,
    size: f64,
    points: &mut [Point],
    left_over: f64,
) -> f64 {
    let quads = tangle.quads();
    let n = 2 * movable.free.len();
    let mut at = vec![0.0; n];
    let mut minimiser = Minimiser::new(n, MEMORY, size);
    let mut energy = TangleEnergy {
        quads: &quads,
        movable,
        size,
        epsilon: 1.0,
        origin: movable.each().map(|(i, _)| points[i]).collect(),
        force: vec![[0.0; 3]; points.len()],
        points,
    };
    let mut smallest = energy.measure(&at).smallest;
    let mut blunt = 1.0;
    let mut left = Vec::with_capacity(ROUNDS);
    for done in 0..ROUNDS {
        let is_sound = smallest > 1e-6;
        // What has collapsed to no area at all must be opened before the blow-up is sharp.
        energy.epsilon = if is_sound {
            SHARP
        } else {
            max(blunt, (1e-9 + 0.04 * smallest * smallest).sqrt())
        };
        blunt *= SHARPENED;
        let reached = minimiser.descend(&mut energy, &mut at, STEPS, is_sound);
        smallest = reached.smallest;
        movable.move_points(&energy.origin, &at, energy.points);
        left.push(count_flipped(&quads, energy.points) as f64);
        if is_sound || (done > 1 && left[done] > max(MANY, left_over * left[done - 2])) {
            break;
        }
    }
    energy.epsilon = SHARP;
    energy.measure(&at).smallest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nine vertices of four quads, the boundary a square of side 2, the middle one elsewhere.
    const QUADS: [[i32; 4]; 4] = [[0, 1, 8, 7], [1, 2, 3, 8], [8, 3, 4, 5], [7, 8, 5, 6]];
    const UP: [Point; 4] = [[0.0, 0.0, 1.0]; 4];

    fn outline(middle: Point) -> Vec<Point> {
        let around = [0, 1, 2, 2, 2, 1, 0, 0].map(f64::from);
        let points = (0..8).map(|i| [around[i], around[(i + 6) % 8], 0.0]);
        points.chain([middle]).collect()
    }

    #[test]
    fn a_vertex_outside_returns_inside() {
        let tangle = Tangle {
            quads: &QUADS,
            wanted: &[[true; 4]; 4],
            up: &UP,
        };
        let mut points = outline([3.5, 2.5, 0.0]);
        assert!(count_flipped(&tangle.quads(), &points) > 0);
        let frames = [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 9];
        let movable = Movable {
            free: &[8],
            frames: &frames,
        };
        let smallest = minimise_energy(&tangle, &movable, 1.0, &mut points, 0.75);
        assert!(smallest > 0.9);
        assert_eq!(count_flipped(&tangle.quads(), &points), 0);
        assert!((points[8][0] - 1.0).abs() < 1e-3 && (points[8][1] - 1.0).abs() < 1e-3);
    }

    /// Numbers between -1 and 1 without any order.
    fn scatter(k: usize) -> f64 {
        (12.9898 * (k + 1) as f64).sin() * 43.758 % 1.0
    }

    fn scatter_points(first: usize, n: usize) -> Vec<Point> {
        let point = |i: usize| std::array::from_fn(|c| scatter(first + 3 * i + c));
        (0..n).map(point).collect()
    }

    #[test]
    fn the_gradient_is_that_of_differences() {
        let (points, up) = (scatter_points(0, 9), scatter_points(40, 4));
        let tangle = Tangle {
            quads: &QUADS,
            wanted: &[[true; 4]; 4],
            up: &up,
        };
        let quads = tangle.quads();
        let mut force = vec![[0.0; 3]; 9];
        measure(&quads, 0.7, 0.3, &points, &mut force);
        for vertex in 0..9 {
            for c in 0..3 {
                let energy = |step: f64| {
                    let mut moved = points.clone();
                    moved[vertex][c] += step;
                    measure(&quads, 0.7, 0.3, &moved, &mut vec![[0.0; 3]; 9]).energy
                };
                let slope = (energy(1e-6) - energy(-1e-6)) / 2e-6;
                let error = (force[vertex][c] - slope).abs();
                assert!(error <= 1e-5 * slope.abs().max(1.0), "{error} at {vertex}");
            }
        }
    }

    #[test]
    fn flipped_corners_are_those_of_no_positive_area() {
        let (points, up) = (scatter_points(90, 9), scatter_points(130, 4));
        let wanted = [[true, false, true, true], [true; 4], [false; 4], [true; 4]];
        let tangle = Tangle {
            quads: &QUADS,
            wanted: &wanted,
            up: &up,
        };
        let mut expected = 0;
        for (f, quad) in QUADS.iter().enumerate() {
            let at = quad.map(|v| points[v as usize]);
            for e in (0..4).filter(|&e| wanted[f][e]) {
                let leaving = subtract(&at[(e + 1) % 4], &at[e]);
                let entering = subtract(&at[(e + 3) % 4], &at[e]);
                expected += usize::from(dot(&cross(&leaving, &entering), &up[f]) <= 0.0);
            }
        }
        assert!(0 < expected && expected < 11);
        assert_eq!(count_flipped(&tangle.quads(), &points), expected);
    }

    #[test]
    fn quads_without_a_common_free_vertex_are_apart() {
        let quads = [[0, 1, 2, 3], [2, 1, 4, 5], [5, 4, 6, 7]];
        let mut free = [false; 8];
        for v in [0, 2, 7] {
            free[v] = true;
        }
        assert_eq!(find_pieces(&quads, &free), [0, 0, 7]);
    }
}
