//! A model made ready to be drawn: smooth where it is smooth, whatever the sense of its faces.

use patterndb_geometry::Point;
use patterndb_geometry::tree::Triangle;
use patterndb_geometry::vector::{dot, length, max, min, subtract};

/// Triangles around vertices, with what normals are made of.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a> {
    /// The vertices of each triangle.
    pub triangles: &'a [[i32; 3]],
    /// Where the triangles around each vertex begin, and where those of the last end.
    pub offsets: &'a [i64],
    /// The triangles around the vertices.
    pub around: &'a [i32],
    /// The unit normal of each triangle.
    pub unit: &'a [Point],
    /// The area of each triangle.
    pub area: &'a [f64],
}

/// Cosines of the angles between two faces up to which they are shaded as one smooth surface, and from
/// which on there is a crease between them.
#[derive(Clone, Copy, Debug)]
pub struct Crease {
    /// Smooth up to this angle.
    pub smooth: f64,
    /// A crease from this angle on.
    pub creased: f64,
}

fn to_unit_range(x: f64) -> f64 {
    min(max(x, 0.0), 1.0)
}

/// Return the unit normals at the corners of triangles, smoothed.
///
/// At each corner the mean, by area, of the triangles around that lie nearly flat with its own;
/// those that look the other way count as if they were turned.
pub fn blend_normals(faces: &Faces, crease: Crease) -> Vec<[Point; 3]> {
    // What is read of a triangle lies in a row.
    let weighted: Vec<(Point, f64)> = faces
        .unit
        .iter()
        .copied()
        .zip(faces.area.iter().copied())
        .collect();
    let blend = |own: &Point, vertex: i32| -> Point {
        let vertex = vertex as usize;
        let around = faces.offsets[vertex] as usize..faces.offsets[vertex + 1] as usize;
        let mut sum = [0.0; 3];
        for &u in &faces.around[around] {
            let (other, area) = &weighted[u as usize];
            let d = dot(own, other);
            let share =
                to_unit_range((d.abs() - crease.creased) / (crease.smooth - crease.creased));
            let weight = if d >= 0.0 { *area } else { -area } * share;
            for c in 0..3 {
                sum[c] += weight * other[c];
            }
        }
        let size = length(&sum);
        if size > 0.0 {
            [sum[0] / size, sum[1] / size, sum[2] / size]
        } else {
            [0.0; 3]
        }
    };
    let each = faces.triangles.iter().zip(faces.unit);
    each.map(|([a, b, c], own)| [blend(own, *a), blend(own, *b), blend(own, *c)])
        .collect()
}

/// From where a model is seen.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Orthonormal rows: to the right, up, and towards the viewer.
    pub axes: [Point; 3],
    /// What is seen in the middle.
    pub focus: Point,
    /// Points of the picture for a unit of length.
    pub scale: f64,
}

impl View {
    /// Return a direction as it is seen.
    #[inline(always)]
    fn turn(&self, direction: &Point) -> Point {
        let [x, y, z] = &self.axes;
        // Adding 0 makes 0 of -0.
        [
            0.0 + dot(x, direction),
            0.0 + dot(y, direction),
            0.0 + dot(z, direction),
        ]
    }

    #[inline(always)]
    fn see(&self, point: &Point) -> Point {
        let [x, y, z] = self.turn(&subtract(point, &self.focus));
        [self.scale * x, self.scale * y, self.scale * z]
    }
}

/// How a model is lit: from two sides.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// Where most of the light comes from, seen by the viewer.
    pub key: Point,
    /// Where the other light comes from.
    pub fill: Point,
    /// How bright is what no light reaches.
    pub ambient: f64,
    /// How much the first light adds.
    pub of_key: f64,
    /// How much the other light adds.
    pub of_fill: f64,
    /// How much darker a surface is that is seen edge on.
    pub edge: f64,
}

impl Light {
    /// Return how bright a surface with a normal is, or with that turned where `side` is -1.
    #[inline(always)]
    fn shade(&self, [x, y, z]: Point, side: f64) -> f64 {
        let normal = &[side * x, side * y, side * z];
        let one = to_unit_range(dot(normal, &self.key));
        let other = to_unit_range(dot(normal, &self.fill));
        let value = self.ambient + self.of_key * one + self.of_fill * other;
        let rim = 1.0 - min(normal[2].abs(), 1.0);
        value * (1.0 - self.edge * rim * rim * rim)
    }
}

/// Return triangles as they are seen, and how bright each of their corners is.
///
/// A normal that points away from the side that is seen counts as if it were turned.
pub fn shade(
    corners: &[Triangle],
    normals: &[[Point; 3]],
    view: &View,
    light: &Light,
) -> (Vec<Triangle>, Vec<[f32; 3]>) {
    let mut all_seen = Vec::with_capacity(corners.len());
    let mut all_bright = Vec::with_capacity(corners.len());
    for (corners, normals) in corners.iter().zip(normals) {
        // Loops: closures for each of three corners would be called, not compiled in place.
        let mut seen = [[0.0; 3]; 3];
        for (seen, corner) in seen.iter_mut().zip(corners) {
            *seen = view.see(corner);
        }
        let (a, b) = (subtract(&seen[1], &seen[0]), subtract(&seen[2], &seen[0]));
        let side = if a[0] * b[1] - a[1] * b[0] < 0.0 {
            -1.0
        } else {
            1.0
        };
        let mut bright = [0.0; 3];
        for (bright, normal) in bright.iter_mut().zip(normals) {
            *bright = light.shade(view.turn(normal), side) as f32;
        }
        all_seen.push(seen);
        all_bright.push(bright);
    }
    (all_seen, all_bright)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: Point = [0.0, 0.0, 1.0];

    /// Two triangles on an edge, the second with a normal given.
    fn blend(other: Point) -> Vec<[Point; 3]> {
        let faces = Faces {
            triangles: &[[0, 1, 2], [2, 1, 3]],
            offsets: &[0, 1, 3, 5, 6],
            around: &[0, 0, 1, 0, 1, 1],
            unit: &[UP, other],
            area: &[1.0, 1.0],
        };
        let crease = Crease {
            smooth: 0.9,
            creased: 0.7,
        };
        blend_normals(&faces, crease)
    }

    #[test]
    fn a_right_angle_is_a_crease_and_the_other_side_is_smooth() {
        let side = [1.0, 0.0, 0.0];
        assert_eq!(blend(side), [[UP; 3], [side; 3]]);
        let down = UP.map(|x| -x);
        assert_eq!(blend(down)[0], [UP; 3]);
    }

    #[test]
    fn both_sides_are_as_bright() {
        let view = View {
            axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], UP],
            focus: [0.0; 3],
            scale: 2.0,
        };
        let light = Light {
            key: UP,
            fill: UP,
            ambient: 0.5,
            of_key: 0.25,
            of_fill: 0.125,
            edge: 0.3,
        };
        let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let (seen, bright) = shade(&[triangle], &[[UP; 3]], &view, &light);
        assert_eq!(seen[0][2], [0.0, 2.0, 0.0]);
        assert_eq!(bright, [[0.875; 3]]);
        let [a, b, c] = triangle;
        let down = UP.map(|x| -x);
        let (_, behind) = shade(&[[a, c, b]], &[[down; 3]], &view, &light);
        assert_eq!(behind, bright);
    }
}
