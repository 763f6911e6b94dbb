//! Pictures made of pixels: shapes painted over each other, their edges smooth.
//!
//! A pixel takes of a shape's colour what part of it the shape covers, computed exactly from the edges:
//! each adds its signed area to the pixels that it crosses, and the sum from the left is the cover.

use patterndb_geometry::vector::{max, min};

use crate::solid::Colour;

/// A place: pixels to the right and down.
pub type Place = [f64; 2];

/// Shapes of several contours each.
#[derive(Clone, Copy, Debug)]
pub struct Shapes<'a> {
    /// The contours' points.
    pub points: &'a [Place],
    /// Where each contour's points begin, and where those of the last end.
    pub contours: &'a [i64],
    /// Where each shape's contours begin, and where those of the last end.
    pub shapes: &'a [i64],
    /// The shapes' colours.
    pub colours: &'a [Colour],
}

/// Some of the pixels of a picture.
#[derive(Clone, Copy)]
struct Window {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Window {
    /// Return the window around points, within a picture; None where it is empty.
    fn around(points: &[Place], width: usize, height: usize) -> Option<Window> {
        let side = |c: usize, size: usize| {
            let ends = (size as f64, 0.0);
            let (low, high) = points.iter().fold(ends, |(low, high), point| {
                (min(low, point[c]), max(high, point[c]))
            });
            let low = low as usize;
            let length = (min(high.ceil(), size as f64) as usize).checked_sub(low)?;
            (length > 0).then_some((low, length))
        };
        let ((left, width), (top, height)) = (side(0, width)?, side(1, height)?);
        Some(Window {
            left,
            top,
            width,
            height,
        })
    }
}

/// How much of each pixel of a window is covered: differences along each row, which has two places more
/// than the window.
struct Cover {
    width: usize,
    rows: Vec<f64>,
}

impl Cover {
    fn new(window: Window) -> Cover {
        let width = window.width + 2;
        Cover {
            width,
            rows: vec![0.0; width * window.height],
        }
    }

    /// Add the signed area to the right of an edge.
    ///
    /// What is left of the window counts at its left border; what is right of it does not show.
    fn add_edge(&mut self, [mut x0, mut y0]: Place, [mut x1, mut y1]: Place) {
        if y0 == y1 {
            return;
        }
        let mut sign = 1.0;
        if y0 > y1 {
            (x0, y0, x1, y1) = (x1, y1, x0, y0);
            sign = -1.0;
        }
        let slope = (x1 - x0) / (y1 - y0);
        let limit = (self.width - 2) as f64;
        let height = self.rows.len() / self.width;
        // A place above the window is taken to its first row.
        let first = (y0 as usize).min(height);
        let stop = (y1 as usize).saturating_add(1).clamp(first, height);
        let rows = &mut self.rows[first * self.width..stop * self.width];
        for (row, cover) in (first as u32..).zip(rows.chunks_exact_mut(self.width)) {
            let row = f64::from(row);
            let (begin, end) = (max(y0, row), min(y1, row + 1.0));
            if begin >= end {
                continue;
            }
            let place = |y: f64| min(max(x0 + (y - y0) * slope, 0.0), limit);
            let (a, b) = (place(begin), place(end));
            let (a, b) = if a > b { (b, a) } else { (a, b) };
            add_to_row(cover, sign * (end - begin), a, b);
        }
    }
}

/// Add the area of a part of an edge from a to b, both in a row of pixels.
fn add_to_row(cover: &mut [f64], area: f64, a: f64, b: f64) {
    let (first, last) = (a as usize, b as usize);
    let mut add = |column: usize, here: f64, middle: f64| {
        let beside = middle - column as f64;
        cover[column] += here * (1.0 - beside);
        cover[column + 1] += here * beside;
    };
    if first == last {
        add(first, area, (a + b) / 2.0);
        return;
    }
    // The part of the edge in each pixel that it crosses, as in a pixel of its own.
    for column in first..=last {
        let (enter, leave) = (max(a, column as f64), min(b, column as f64 + 1.0));
        add(
            column,
            area * (leave - enter) / (b - a),
            (enter + leave) / 2.0,
        );
    }
}

/// Paint shapes over the pixels, in order; `width` is that of the picture.
pub fn paint_shapes(pixels: &mut [Colour], width: usize, shapes: &Shapes) {
    let height = pixels.len().checked_div(width).unwrap_or(0);
    let begin = |contour: i64| shapes.contours[contour as usize] as usize;
    for (ends, colour) in shapes.shapes.windows(2).zip(shapes.colours) {
        let points = &shapes.points[begin(ends[0])..begin(ends[1])];
        let Some(window) = Window::around(points, width, height) else {
            continue;
        };
        let mut cover = Cover::new(window);
        let within = |point: &Place| [point[0] - window.left as f64, point[1] - window.top as f64];
        for contour in ends[0]..ends[1] {
            let contour = &shapes.points[begin(contour)..begin(contour + 1)];
            let after = contour.iter().cycle().skip(1);
            for (point, next) in contour.iter().zip(after) {
                cover.add_edge(within(point), within(next));
            }
        }
        let rows = pixels.chunks_exact_mut(width).skip(window.top);
        for (row, cover) in rows.zip(cover.rows.chunks_exact(cover.width)) {
            let mut total = 0.0;
            let row = &mut row[window.left..][..window.width];
            for (pixel, change) in row.iter_mut().zip(cover) {
                total += change;
                let part = min(f64::abs(total), 1.0);
                if part > 0.0 {
                    for (below, &colour) in pixel.iter_mut().zip(colour) {
                        let change = part * f64::from(colour - *below);
                        *below = (f64::from(*below) + change) as f32;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Paint one shape of a contour in white on a black picture of 3 by 3 pixels.
    fn paint(points: &[Place]) -> [f32; 9] {
        let mut pixels = [[0.0; 3]; 9];
        let shapes = Shapes {
            points,
            contours: &[0, points.len() as i64],
            shapes: &[0, 1],
            colours: &[[1.0; 3]],
        };
        paint_shapes(&mut pixels, 3, &shapes);
        pixels.map(|colour| colour[0])
    }

    #[test]
    fn a_pixel_takes_the_part_that_is_covered() {
        let square = [[0.5, 0.0], [2.0, 0.0], [2.0, 1.5], [0.5, 1.5]];
        let found = paint(&square);
        assert_eq!(found, [0.5, 1.0, 0.0, 0.25, 0.5, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn a_slope_covers_half_of_its_pixels() {
        let found = paint(&[[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]);
        assert_eq!(found, [1.0, 1.0, 0.5, 1.0, 0.5, 0.0, 0.5, 0.0, 0.0]);
    }

    #[test]
    fn what_is_outside_is_not_painted() {
        assert_eq!(paint(&[[5.0, 0.0], [9.0, 0.0], [5.0, 9.0]]), [0.0; 9]);
        assert_eq!(
            paint(&[[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]]),
            [1.0; 9]
        );
        assert_eq!(paint(&[]), [0.0; 9]);
    }
}
