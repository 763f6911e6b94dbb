//! Holes of meshes: their loops, the candidates for a fill, and how these are ranked and placed.

use patterndb_geometry::Point;

pub mod candidates;
pub mod corners;
pub mod features;
pub mod loops;
pub mod neighbourhood;
pub mod patterns;
pub mod projection;
pub mod ranking;
pub mod regular;

/// The number of quads that touch a regular vertex inside a mesh.
const REGULAR: i32 = 4;

/// Return the inner product of two vectors, summed from 0: a sum of zeros is positive, whose angle
/// is another than that of a negative one.
fn sum_products(a: &Point, b: &Point) -> f64 {
    0.0 + a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Return a key that edges of the same ends have, in either order. It is exact as long as there are
/// fewer than 94 million vertices.
fn edge_key(a: i64, b: i64, n_vertices: usize) -> f64 {
    a.min(b) as f64 * n_vertices as f64 + a.max(b) as f64
}
