//! Shaded triangles of a picture: a depth buffer without OpenGL.

use patterndb_geometry::tree::Triangle;
use patterndb_geometry::vector::{max, min};

/// Red, green and blue, from 0 to 1.
pub type Colour = [f32; 3];

/// A pixel belongs to a triangle down to this weight of a corner: one on an edge belongs to both
/// triangles there, so that no gap is left.
const SLACK: f64 = -1e-9;

/// A picture and how near is what it shows, row by row.
#[derive(Debug)]
pub struct Canvas<'a> {
    /// Pixels in a row.
    pub width: usize,
    /// How near each pixel is, -inf where nothing is yet.
    pub depth: &'a mut [f32],
    /// The pixels' colours.
    pub image: &'a mut [Colour],
}

/// Return the pixels from the one at or before a place to the one at or after another, those within a
/// picture.
fn pixels(from: f64, to: f64, count: usize) -> std::ops::Range<usize> {
    // Conversion takes what is before the picture to its first pixel.
    let first = (from - 0.5) as usize;
    let last = min((to - 0.5).ceil(), count as f64 - 1.0);
    let stop = (last + 1.0) as usize;
    first.min(stop)..stop
}

/// Paint triangles over the picture; the nearer wins.
///
/// Corners are x to the right, y down, both in pixels, and depth, greater is nearer. The colours of
/// the corners are blended between. A pixel is seen at its middle.
pub fn fill_triangles(corners: &[Triangle], colours: &[[Colour; 3]], canvas: Canvas) {
    let Canvas {
        width,
        depth,
        image,
    } = canvas;
    if width == 0 {
        return;
    }
    let height = depth.len() / width;
    for (&[[ax, ay, az], [bx, by, bz], [cx, cy, cz]], [a, b, c]) in corners.iter().zip(colours) {
        let area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        if area == 0.0 {
            continue;
        }
        let columns = pixels(min(min(ax, bx), cx), max(max(ax, bx), cx), width);
        let rows = pixels(min(min(ay, by), cy), max(max(ay, by), cy), height);
        for i in rows {
            let y = i as f64 + 0.5;
            let row = i * width + columns.start..i * width + columns.end;
            let row = depth[row.clone()].iter_mut().zip(&mut image[row]);
            for (j, (depth, colour)) in (columns.start as u32..).zip(row) {
                let x = f64::from(j) + 0.5;
                let u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area;
                if u < SLACK {
                    continue;
                }
                let v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area;
                let w = 1.0 - u - v;
                if v < SLACK || w < SLACK {
                    continue;
                }
                let z = u * az + v * bz + w * cz;
                if z <= f64::from(*depth) {
                    continue;
                }
                *depth = z as f32;
                for (k, colour) in colour.iter_mut().enumerate() {
                    let blend = u * f64::from(a[k]) + v * f64::from(b[k]) + w * f64::from(c[k]);
                    *colour = blend as f32;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_triangle_is_seen() {
        let triangle = |z: f64| [[0.0, 0.0, z], [4.0, 0.0, z], [0.0, 4.0, z]];
        let (mut depth, mut image) = ([f32::NEG_INFINITY; 16], [[0.0; 3]; 16]);
        let canvas = Canvas {
            width: 4,
            depth: &mut depth,
            image: &mut image,
        };
        let colours = [0.5, 1.0, 0.25].map(|x| [[x; 3]; 3]);
        let corners = [1.0, 2.0, 0.0].map(triangle);
        fill_triangles(&corners, &colours, canvas);
        assert_eq!(image[0], [1.0; 3]);
        assert_eq!(depth[0], 2.0);
        // On the edge, and beyond it.
        assert_eq!(image[3], [1.0; 3]);
        assert_eq!(depth[7], f32::NEG_INFINITY);
    }

    #[test]
    fn what_is_outside_is_not_painted() {
        let before = [[-9.0, -9.0, 0.0], [-5.0, -9.0, 0.0], [-9.0, -5.0, 0.0]];
        let behind = before.map(|corner| corner.map(|x| -x));
        let (mut depth, mut image) = ([f32::NEG_INFINITY; 4], [[0.0; 3]; 4]);
        let canvas = Canvas {
            width: 2,
            depth: &mut depth,
            image: &mut image,
        };
        fill_triangles(&[before, behind], &[[[1.0; 3]; 3]; 2], canvas);
        assert_eq!(image, [[0.0; 3]; 4]);
    }
}
