//! What a candidate cycle looks like: its flatness, and the surface that it seems to span.
//!
//! The surface is the triangulation of least area of a coarse sampling. It shows where the surface
//! lies next to each of the cycle's curves, and whether another curve of the network runs into it.

use patterndb_geometry::leastarea::{Price, triangulate_cheapest};
use patterndb_geometry::vector::{Point, cross, dot, length, max, min, subtract};

use crate::axes::diagonalise;

/// Samples of a cycle beyond which only every second, third, ... sample of its curves counts: the
/// triangulation's time grows with the cube.
const MOST_SAMPLES: usize = 96;

/// A triangle costs no less area than this part of its edges' squared lengths: along a side of several
/// straight curves a flat one would cost nothing, and show nothing of the surface next to it.
const THIN: f64 = 1e-6;

/// A cycle that turns at a node by more than 30 degrees, of which this is the cosine, has a corner
/// there. Above the 20 degrees of a drawn corner: strokes drawn freehand seldom meet smoothly.
const TURN_COSINE: f64 = 0.8660254037844387;

/// A direction that is off an edge by less than this, as a sine, runs along it.
const ALONG: f64 = 1e-9;

/// A curve that leaves a node less than 30 degrees from a side of the cycle, of which this is the
/// cosine, runs next to that side rather than into the surface, the less so the nearer.
const BESIDE_COSINE: f64 = 0.8660254037844387;

/// The curves of a network, sampled, in both senses: half-curve 2 c is curve c from its first node,
/// 2 c + 1 back.
#[derive(Clone, Copy, Debug)]
pub struct SampledCurves<'a> {
    /// The samples of one curve after another.
    pub samples: &'a [Point],
    /// Where those of every curve begin, and their number.
    pub offsets: &'a [i64],
    /// The node from which every half-curve leaves.
    pub start: &'a [i64],
    /// The first in `leaving` of every node, and their number.
    pub first: &'a [i64],
    /// The half-curves by the nodes that they leave.
    pub leaving: &'a [i64],
    /// Unit vectors along which half-curves leave their nodes.
    pub tangents: &'a [Point],
}

impl SampledCurves<'_> {
    fn tangent(&self, half: i64) -> &Point {
        &self.tangents[half as usize]
    }

    /// Return the half-curves that leave a node.
    fn leaving(&self, node: i64) -> &[i64] {
        let node = node as usize;
        &self.leaving[self.first[node] as usize..self.first[node + 1] as usize]
    }
}

/// The measures of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CycleMeasures {
    /// Arc length.
    pub length: f64,
    /// sqrt(lambda3 / lambda1), lambda the eigenvalues of the points' covariance.
    pub flatness: f64,
    /// The area of the triangulation.
    pub area: f64,
    /// In radians, angles between neighbouring triangles, by the length of their edge over the
    /// cycle's length.
    pub bending: f64,
    /// The number of nodes at which the cycle has a corner.
    pub corners: f64,
    /// How many nodes have a curve that runs into the surface: 1 for each with one within the
    /// surface, falling to 0 at 45 degrees off it and at a side of the cycle.
    pub cuts: f64,
    /// How far curves leave to both sides of the surface, at the node where they do so least: 1 where
    /// all are at right angles to it, 0 at 30 degrees.
    pub section: f64,
    /// The mean, over its nodes, of how straight the cycle goes on there (the squared cosine of its
    /// turning), times how straight two others go on across it (likewise, times the least sine to the
    /// cycle).
    pub crossed: f64,
}

/// Measure the cycle of the half-curves `steps`; add to `inward`, 0 on entry, where at each step the
/// surface lies, across the curve, as unit vectors.
pub fn measure_cycle(steps: &[i64], curves: &SampledCurves, inward: &mut [Point]) -> CycleMeasures {
    let mut measures = CycleMeasures::default();
    let (mut points, corner) = gather_samples(steps, curves);
    let middle;
    (middle, measures.length) = find_middle(&points);
    for point in &mut points {
        *point = subtract(point, &middle);
    }
    if measures.length == 0.0 {
        return measures;
    }
    measures.flatness = measure_flatness(&points, measures.length);
    if points.len() < 3 {
        return measures;
    }
    let surface = Surface::new(points);
    measures.area = 0.5 * surface.normals.iter().map(length).fold(0.0, |a, b| a + b);
    measures.bending = surface.measure_bending() / measures.length;
    surface.add_inward(&corner, inward);
    measures.section = 1.0;
    for (s, &out) in steps.iter().enumerate() {
        let before = s.checked_sub(1).unwrap_or(steps.len() - 1);
        let passage = Passage {
            curves,
            out,
            back: steps[before] ^ 1,
        };
        if dot(curves.tangent(out), curves.tangent(passage.back)) > -TURN_COSINE {
            measures.corners += 1.0;
        }
        let (mut worst, mut above, mut below) = (0.0, 0.0, 0.0);
        let normal = surface.normal_at(corner[s]);
        for &other in passage.leaving().iter().filter(|&&h| passage.is_other(h)) {
            let tangent = curves.tangent(other);
            let along = max(
                dot(tangent, curves.tangent(out)),
                dot(tangent, curves.tangent(passage.back)),
            );
            let aside = min(1.0, (1.0 - along) / (1.0 - BESIDE_COSINE));
            worst = max(worst, aside * surface.measure_cut(corner[s], tangent));
            let sine = dot(tangent, &normal);
            above = max(above, sine);
            below = max(below, -sine);
        }
        measures.cuts += worst;
        measures.crossed += passage.measure_crossing() / steps.len() as f64;
        let sides = max(0.0, 2.0 * min(above, below) - 1.0);
        measures.section = min(measures.section, sides);
    }
    measures
}

/// A node that a cycle passes.
struct Passage<'a> {
    curves: &'a SampledCurves<'a>,
    /// The half-curve along which the cycle leaves the node.
    out: i64,
    /// The half-curve that leaves the node along which the cycle comes.
    back: i64,
}

impl Passage<'_> {
    fn leaving(&self) -> &[i64] {
        self.curves.leaving(self.curves.start[self.out as usize])
    }

    /// Return whether a half-curve is of none of the cycle's curves here.
    fn is_other(&self, half: i64) -> bool {
        half >> 1 != self.out >> 1 && half >> 1 != self.back >> 1
    }

    /// Return the squared cosine of the angle by which two half-curves that leave the node are off a
    /// straight line, 0 beyond a right angle.
    fn measure_straightness(&self, a: i64, b: i64) -> f64 {
        let cosine = max(0.0, -dot(self.curves.tangent(a), self.curves.tangent(b)));
        cosine * cosine
    }

    /// Return how straight the cycle goes on, times how straight two others cross it.
    fn measure_crossing(&self) -> f64 {
        let straight = self.measure_straightness(self.out, self.back);
        let leaving = self.leaving();
        let mut most = 0.0;
        for (i, &a) in leaving.iter().enumerate() {
            for &b in &leaving[..i] {
                if !self.is_other(a) || !self.is_other(b) {
                    continue;
                }
                let across = self.measure_straightness(a, b);
                let mut along = 0.0;
                for other in [a, b] {
                    for own in [self.out, self.back] {
                        let cosine = dot(self.curves.tangent(other), self.curves.tangent(own));
                        along = max(along, cosine.abs());
                    }
                }
                most = max(most, across * max(0.0, 1.0 - along * along).sqrt());
            }
        }
        straight * most
    }
}

/// Return the samples around a cycle, and the place of every step's first in them.
fn gather_samples(steps: &[i64], curves: &SampledCurves) -> (Vec<Point>, Vec<usize>) {
    let of_half = |half: i64| {
        let curve = (half >> 1) as usize;
        &curves.samples[curves.offsets[curve] as usize..curves.offsets[curve + 1] as usize]
    };
    let total: usize = steps.iter().map(|&half| of_half(half).len() - 1).sum();
    let stride = 1 + (total - 1) / MOST_SAMPLES;
    let mut points = Vec::with_capacity(total);
    let mut corner = Vec::with_capacity(steps.len());
    for &half in steps {
        corner.push(points.len());
        let samples = of_half(half);
        let n = samples.len() - 1;
        let places = (0..n).step_by(stride);
        points.extend(places.map(|q| samples[if half & 1 == 0 { q } else { n - q }]));
    }
    (points, corner)
}

/// Return the edges of a closed polyline, each as its two ends, beginning with the one to point 0.
fn edges(points: &[Point]) -> impl Iterator<Item = (&Point, &Point)> {
    points.iter().cycle().skip(points.len() - 1).zip(points)
}

/// Return the centre of mass of a closed polyline, and its length.
fn find_middle(points: &[Point]) -> (Point, f64) {
    let (mut middle, mut whole) = ([0.0; 3], 0.0);
    for (before, point) in edges(points) {
        let size = length(&subtract(point, before));
        for (sum, (a, b)) in middle.iter_mut().zip(point.iter().zip(before)) {
            *sum += 0.5 * size * (a + b);
        }
        whole += size;
    }
    if whole > 0.0 {
        (middle.map(|x| x / whole), whole)
    } else {
        (points[0], whole)
    }
}

/// Return sqrt(lambda3 / lambda1) of a closed polyline of some length about the origin, all of its
/// points.
fn measure_flatness(points: &[Point], whole: f64) -> f64 {
    let mut moments = [[0.0; 3]; 3];
    for (u, v) in edges(points) {
        let size = length(&subtract(v, u)) / (6.0 * whole);
        for (x, row) in moments.iter_mut().enumerate() {
            for (y, sum) in row.iter_mut().enumerate() {
                let both = u[x] * v[y] + v[x] * u[y];
                *sum += size * (2.0 * u[x] * u[y] + 2.0 * v[x] * v[y] + both);
            }
        }
    }
    let ([least, _, most], _) = diagonalise(moments);
    // So small that squares of lengths are 0, it is in one place.
    if most > 0.0 {
        (max(least, 0.0) / most).sqrt()
    } else {
        0.0
    }
}

/// The surface that a closed polyline seems to span.
struct Surface {
    points: Vec<Point>,
    triangles: Vec<[usize; 3]>,
    /// The normals of the triangles, of twice their area.
    normals: Vec<Point>,
}

impl Surface {
    fn new(points: Vec<Point>) -> Surface {
        let price = Price {
            shorter: 0.0,
            thin: THIN,
        };
        let (triangles, _) = triangulate_cheapest(&points, price);
        let normal = |&[i, k, j]: &[usize; 3]| {
            let [i, k, j] = [points[i], points[k], points[j]];
            cross(&subtract(&k, &i), &subtract(&j, &i))
        };
        Surface {
            normals: triangles.iter().map(normal).collect(),
            points,
            triangles,
        }
    }

    /// Return the vector from one vertex to another.
    fn edge(&self, from: usize, to: usize) -> Point {
        subtract(&self.points[to], &self.points[from])
    }

    /// Return the angles between neighbouring triangles times the length of the edge between them,
    /// summed.
    fn measure_bending(&self) -> f64 {
        let n = self.points.len();
        let mut owner = vec![None; n * n];
        let mut total = 0.0;
        for (triangle, normal) in self.triangles.iter().zip(&self.normals) {
            for [a, b, _] in turns(triangle) {
                let (a, b) = (a.min(b), a.max(b));
                if let Some(other) = owner[a * n + b].replace(normal) {
                    // Never -0.0: a triangle without area is bent by nothing.
                    let along = dot(normal, other) + 0.0;
                    let angle = length(&cross(normal, other)).atan2(along);
                    total += angle * length(&self.edge(b, a));
                }
            }
        }
        total
    }

    /// Add for every step the mean direction, across its edges, to their triangles' apices.
    fn add_inward(&self, corner: &[usize], inward: &mut [Point]) {
        let n = self.points.len();
        for triangle in &self.triangles {
            for [mut i, mut j, apex] in turns(triangle) {
                if (j + 1) % n == i {
                    (i, j) = (j, i);
                }
                if (i + 1) % n != j {
                    continue;
                }
                let edge = self.edge(i, j);
                let size = length(&edge);
                if size * size == 0.0 {
                    // Of a curve that goes out and back two samples may be in one place.
                    continue;
                }
                let across = self.edge(i, apex);
                let share = dot(&across, &edge) / (size * size);
                let across = [0, 1, 2].map(|d| across[d] - share * edge[d]);
                let width = length(&across);
                if width > 0.0 {
                    let step = corner.partition_point(|&first| first <= i) - 1;
                    for (sum, x) in inward[step].iter_mut().zip(across) {
                        *sum += x * (size / width);
                    }
                }
            }
        }
        for direction in inward {
            let size = length(direction);
            if size > 0.0 {
                *direction = direction.map(|x| x / size);
            }
        }
    }

    /// Return how far a direction at a vertex runs into the triangles there: cos(2 elevation), or 0.
    fn measure_cut(&self, vertex: usize, tangent: &Point) -> f64 {
        let mut cut = 0.0;
        for triangle in &self.triangles {
            for [corner, next, last] in turns(triangle) {
                if corner != vertex {
                    continue;
                }
                let (a, b) = (self.edge(vertex, next), self.edge(vertex, last));
                let normal = cross(&a, &b);
                let size = length(&normal);
                if size <= 1e-12 * (dot(&a, &a) * dot(&b, &b)).sqrt() {
                    continue;
                }
                // Along an edge between two triangles it is in both, up to rounding.
                let off_a = dot(&cross(&a, tangent), &normal);
                let off_b = dot(&cross(tangent, &b), &normal);
                if off_a < -ALONG * size * length(&a) || off_b < -ALONG * size * length(&b) {
                    continue;
                }
                let sine = dot(tangent, &normal) / size;
                cut = max(cut, 1.0 - 2.0 * sine * sine);
            }
        }
        cut
    }

    /// Return the unit normal of the triangles at a vertex together, 0 if there is none.
    fn normal_at(&self, vertex: usize) -> Point {
        let mut sum = [0.0; 3];
        for (triangle, normal) in self.triangles.iter().zip(&self.normals) {
            if triangle.contains(&vertex) {
                sum = [0, 1, 2].map(|d| sum[d] + normal[d]);
            }
        }
        let size = length(&sum);
        if size > 0.0 {
            sum.map(|x| x / size)
        } else {
            sum
        }
    }
}

/// Return a triangle's vertices in the three orders of its sense.
fn turns(&[a, b, c]: &[usize; 3]) -> [[usize; 3]; 3] {
    [[a, b, c], [b, c, a], [c, a, b]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The four sides of the unit square, and a curve from its first corner.
    const CORNERS: [Point; 4] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];

    fn measure_square(fifth: Point) -> (CycleMeasures, Vec<Point>) {
        let mut samples = Vec::new();
        for i in 0..4 {
            samples.extend([CORNERS[i], CORNERS[(i + 1) % 4]]);
        }
        samples.extend([CORNERS[0], fifth]);
        let tangents: Vec<Point> = samples
            .chunks(2)
            .flat_map(|ends| [subtract(&ends[1], &ends[0]), subtract(&ends[0], &ends[1])])
            .collect();
        let curves = SampledCurves {
            samples: &samples,
            offsets: &[0, 2, 4, 6, 8, 10],
            start: &[0, 1, 1, 2, 2, 3, 3, 0, 0, 4],
            first: &[0, 3, 5, 7, 9, 10],
            leaving: &[0, 7, 8, 1, 2, 3, 4, 5, 6, 9],
            tangents: &tangents,
        };
        let mut inward = vec![[0.0; 3]; 4];
        let measures = measure_cycle(&[0, 2, 4, 6], &curves, &mut inward);
        (measures, inward)
    }

    #[test]
    fn a_square_is_flat_and_has_four_corners() {
        let (measures, inward) = measure_square([0.0, 0.0, 1.0]);
        let expected = CycleMeasures {
            length: 4.0,
            area: 1.0,
            corners: 4.0,
            ..CycleMeasures::default()
        };
        assert_eq!(measures, expected);
        let directions = [
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [1.0, 0.0, 0.0],
        ];
        assert_eq!(inward, directions);
    }

    #[test]
    fn a_curve_within_the_square_cuts_it() {
        let half = 0.5_f64.sqrt();
        let (measures, _) = measure_square([half, half, 0.0]);
        assert!((measures.cuts - 1.0).abs() < 1e-12);
        let (measures, _) = measure_square([-half, -half, 0.0]);
        assert_eq!(measures.cuts, 0.0);
    }
}
