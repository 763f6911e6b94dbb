//! One piece of a patch as a mesh: heights above its plane.

use patterndb_geometry::vector::{max, min};

use crate::tessellation::planar::{Place, following, preceding, turn};

/// The residual is brought below this part of its scale: rounding, nearly.
const PRECISION: f64 = 1e-13;

/// Steps per inner vertex. In exact arithmetic one each would do; rounding costs a few more.
const STEPS_EACH: usize = 4;

/// A planar mesh: its vertices and the half-edges of its triangles, of which 3 t + e leaves corner e
/// of triangle t.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    /// The vertices.
    pub at: &'a [Place],
    /// The vertex that every half-edge leaves.
    pub tail: &'a [i64],
    /// The half-edge on the other side of every half-edge, -1 on the boundary.
    pub twin: &'a [i64],
}

/// An edge between two triangles.
struct InnerEdge {
    ends: [usize; 2],
    /// The sum of the cotangents of the angles opposite to it.
    weight: f64,
}

/// Return the heights above the plane that solve Laplace's equation on the constrained Delaunay
/// triangulation of a polygon. `boundary` has those of the first vertices, which are kept. By
/// conjugate gradients.
///
/// The weights are the cotangents of the angles in the plane. On a constrained Delaunay
/// triangulation none is negative, so that every height is a mean of its neighbours' heights: none is
/// above the highest or below the lowest of the boundary. With them, a vertex in its place in the
/// plane is at rest too; therefore only the heights are solved for, the surface is a graph over the
/// plane, and no piece crosses itself. (Uniform weights would pull vertices across the boundary at
/// concave corners.)
///
/// Source: Pinkall and Polthier 1993, "Computing discrete minimal surfaces and their conjugates":
/// the membrane's energy on the planar mesh, which for small heights is the area.
pub fn solve_heights(mesh: Mesh, boundary: &[f64]) -> Vec<f64> {
    let (m, v) = (boundary.len(), mesh.at.len());
    let mean = sum(boundary.iter().copied()) / m as f64;
    let mut heights = boundary.to_vec();
    heights.resize(v, mean);
    if v == m {
        return heights;
    }
    let edges = mesh.inner_edges();
    let mut diagonal = vec![0.0; v];
    for InnerEdge { ends, weight } in &edges {
        for &end in ends {
            diagonal[end] += weight;
        }
    }
    let diagonal = &diagonal[m..];
    let mut product = vec![0.0; v];
    apply_laplacian(&edges, &heights, &mut product);
    let mut residual: Vec<f64> = product[m..].iter().map(|product| -product).collect();
    let mut toward = vec![0.0; v];
    for ((toward, residual), diagonal) in toward[m..].iter_mut().zip(&residual).zip(diagonal) {
        *toward = residual / diagonal;
    }
    let mut squared = dot(&residual, &toward[m..]);
    let highest = boundary.iter().copied().fold(f64::NEG_INFINITY, max);
    let lowest = boundary.iter().copied().fold(f64::INFINITY, min);
    let extent = highest - lowest;
    let scale = sum(diagonal.iter().map(|diagonal| diagonal * extent * extent));
    let most = STEPS_EACH * (v - m) + 10;
    let mut steps = 0;
    while squared > PRECISION * PRECISION * scale && steps < most {
        steps += 1;
        apply_laplacian(&edges, &toward, &mut product);
        let (product, toward) = (&product[m..], &mut toward[m..]);
        let curve = dot(product, toward);
        if curve <= 0.0 {
            break;
        }
        let alpha = squared / curve;
        for (height, toward) in heights[m..].iter_mut().zip(&*toward) {
            *height += alpha * toward;
        }
        let mut after = 0.0;
        for ((residual, product), diagonal) in residual.iter_mut().zip(product).zip(diagonal) {
            *residual -= alpha * product;
            after += *residual * *residual / diagonal;
        }
        let beta = after / squared;
        squared = after;
        for ((toward, residual), diagonal) in toward.iter_mut().zip(&residual).zip(diagonal) {
            *toward = residual / diagonal + beta * *toward;
        }
    }
    heights
}

fn sum(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |total, value| total + value)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    sum(a.iter().zip(b).map(|(a, b)| a * b))
}

/// Write the Laplacian of values at the vertices.
fn apply_laplacian(edges: &[InnerEdge], values: &[f64], product: &mut [f64]) {
    product.fill(0.0);
    for &InnerEdge {
        ends: [a, b],
        weight,
    } in edges
    {
        let flow = weight * (values[a] - values[b]);
        product[a] += flow;
        product[b] -= flow;
    }
}

impl Mesh<'_> {
    fn inner_edges(&self) -> Vec<InnerEdge> {
        let mut edges = Vec::with_capacity(self.tail.len() / 2);
        for (h, &twin) in self.twin.iter().enumerate() {
            if twin > h as i64 {
                let weight = self.cotangent(h) + self.cotangent(twin as usize);
                edges.push(InnerEdge {
                    ends: [h, following(h)].map(|h| self.tail[h] as usize),
                    // Below 0 by rounding only.
                    weight: max(weight, 0.0),
                });
            }
        }
        edges
    }

    /// Return the cotangent of the angle opposite to a half-edge in its triangle.
    fn cotangent(&self, h: usize) -> f64 {
        let corners = [h, following(h), preceding(h)].map(|h| &self.at[self.tail[h] as usize]);
        let [a, b, c] = corners;
        let along = sum((0..2).map(|d| (a[d] - c[d]) as f64 * (b[d] - c[d]) as f64));
        along / turn(corners) as f64
    }
}

/// Return how many times as large as in the plane a mesh is at these heights: the root of areas.
///
/// `step` is the length of a step of the grid.
pub fn measure_stretch(at: &[Place], tail: &[i64], heights: &[f64], step: f64) -> f64 {
    let (mut flat, mut real) = (0.0, 0.0);
    for corners in tail.as_chunks().0 {
        let corners: [usize; 3] = corners.map(|corner| corner as usize);
        let places = corners.map(|corner| &at[corner]);
        let [a, b, c] = places;
        let area = turn(places) as f64 * step * step;
        let side = |to: &Place| [0, 1].map(|k| (to[k] - a[k]) as f64 * step);
        let ([ux, uy], [vx, vy]) = (side(b), side(c));
        let [low, uz, vz] = corners.map(|corner| heights[corner]);
        let (uz, vz) = (uz - low, vz - low);
        let (x, y) = (uy * vz - uz * vy, uz * vx - ux * vz);
        flat += area;
        real += (area * area + x * x + y * y).sqrt();
    }
    // So small that its area is 0 in numbers, its stretch is unknown.
    if flat > 0.0 {
        (real / flat).sqrt()
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 8 around a vertex at (2, 4): four triangles.
    const AT: [Place; 5] = [[0, 0], [8, 0], [8, 8], [0, 8], [2, 4]];
    const TAIL: [i64; 12] = [0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4];
    const TWIN: [i64; 12] = [-1, 5, 10, -1, 8, 1, -1, 11, 4, -1, 2, 7];

    #[test]
    fn a_plane_stays_plane() {
        let mesh = Mesh {
            at: &AT,
            tail: &TAIL,
            twin: &TWIN,
        };
        let height = |place: &Place| 3.0 + 0.5 * place[0] as f64 - 0.25 * place[1] as f64;
        let boundary: Vec<f64> = AT[..4].iter().map(height).collect();
        let heights = solve_heights(mesh, &boundary);
        assert_eq!(heights[..4], boundary);
        assert!((heights[4] - height(&AT[4])).abs() < 1e-9);
    }

    #[test]
    fn a_slope_stretches_by_the_root_of_its_area() {
        let heights = AT.map(|place| 0.75 * 0.5 * place[0] as f64);
        let stretch = measure_stretch(&AT, &TAIL, &heights, 0.5);
        assert!((stretch - 1.25_f64.sqrt()).abs() < 1e-12);
        assert_eq!(measure_stretch(&AT, &TAIL, &[0.0; 5], 0.5), 1.0);
        assert_eq!(measure_stretch(&AT, &TAIL, &heights, 0.0), 1.0);
    }
}
