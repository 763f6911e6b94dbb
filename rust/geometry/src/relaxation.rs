//! Moves the vertices of a flat disk until every quad is well shaped and none is flipped.
//!
//! Every corner of every quad is a triangle with a wanted angle and size, whose energy blows up as its
//! area falls to zero: see [`crate::barrier`]. The outline may move by its handles.

use num_complex::Complex64;

use crate::barrier::{Energy, Measure, Minimiser, SmoothArea, smooth_area};
use crate::vector::min;

/// Part of a triangle's energy that is about size, the rest is about shape.
const SIZE_WEIGHT: f64 = 0.2;

/// Steps that L-BFGS remembers.
const MEMORY: usize = 10;

/// The smoothing of drawings in which no triangle is flipped.
const SHARP: f64 = 1e-4;

const I: Complex64 = Complex64::new(0.0, 1.0);

/// A disk to be drawn, and what is wanted of the drawing.
#[derive(Clone, Copy, Debug)]
pub struct Disk<'a> {
    /// Number of handles, the points by which the outline moves.
    pub handles: usize,
    /// Whether the handles may move.
    pub moving: bool,
    /// The three handles of each boundary vertex.
    pub ends: &'a [[i32; 3]],
    /// What each of the three counts.
    pub weights: &'a [[f64; 3]],
    /// The vertices of each quad; those of the boundary come first.
    pub quads: &'a [[i32; 4]],
    /// The wanted angles of each quad, 0 for a triangle that is left alone.
    pub angles: &'a [[f64; 4]],
    /// Wanted length of edges.
    pub size: f64,
}

/// The triangle at a corner of a quad.
struct Corner {
    /// Its vertex, and those after and before it in the quad.
    vertices: [usize; 3],
    sine: f64,
    cotangent: f64,
}

impl Disk<'_> {
    /// Return the corners with a wanted angle.
    fn corners(&self) -> Vec<Corner> {
        let corners = self.quads.iter().zip(self.angles);
        let of_quad = |(quad, angles): (&[i32; 4], &[f64; 4])| {
            let (quad, angles) = (*quad, *angles);
            (0..4).filter(move |&c| angles[c] > 0.0).map(move |c| {
                let sine = angles[c].sin();
                Corner {
                    vertices: [c, (c + 1) % 4, (c + 3) % 4].map(|c| quad[c] as usize),
                    sine,
                    cotangent: angles[c].cos() / sine,
                }
            })
        };
        corners.flat_map(of_quad).collect()
    }
}

/// Divide as complex numbers are divided: where the divisor is real too, the signs of zeros are
/// those of a sum.
pub fn divide(a: Complex64, by: f64) -> Complex64 {
    Complex64::new((a.re + a.im * 0.0) / by, (a.im - a.re * 0.0) / by)
}

/// The energy of a disk's drawings.
struct DiskEnergy<'a> {
    disk: &'a Disk<'a>,
    corners: Vec<Corner>,
    epsilon: f64,
    /// The vertices' points, as they were measured last.
    points: &'a mut [Complex64],
    /// The vertices' forces there.
    force: Vec<Complex64>,
}

impl Energy<Complex64> for DiskEnergy<'_> {
    /// Measure the drawing with handles and interior vertices `y`.
    fn measure(&mut self, y: &[Complex64]) -> Measure {
        let disk = self.disk;
        let (outline, interior) = self.points.split_at_mut(disk.ends.len());
        for ((point, ends), weights) in outline.iter_mut().zip(disk.ends).zip(disk.weights) {
            *point = Complex64::ZERO;
            for (&end, &weight) in ends.iter().zip(weights) {
                *point += Complex64::from(weight) * y[end as usize];
            }
        }
        interior.copy_from_slice(&y[disk.handles..]);
        self.measure_corners()
    }

    fn write_gradient(&self, gradient: &mut [Complex64]) {
        let disk = self.disk;
        let (outline, interior) = self.force.split_at(disk.ends.len());
        gradient.fill(Complex64::ZERO);
        if disk.moving {
            for ((&force, ends), weights) in outline.iter().zip(disk.ends).zip(disk.weights) {
                for (&end, &weight) in ends.iter().zip(weights) {
                    gradient[end as usize] += Complex64::from(weight) * force;
                }
            }
        }
        gradient[disk.handles..].copy_from_slice(interior);
    }
}

impl DiskEnergy<'_> {
    /// Measure the drawing; set the forces.
    fn measure_corners(&mut self) -> Measure {
        let (size, points) = (self.disk.size, &*self.points);
        let mut energy = 0.0;
        let mut smallest = f64::INFINITY;
        let force = &mut self.force;
        force.fill(Complex64::ZERO);
        for corner in &self.corners {
            let [i, j, k] = corner.vertices;
            // The map from the wanted triangle to this one takes (1, 0) to u, (0, 1) to w.
            let cotangent = Complex64::from(corner.cotangent);
            let u = divide(points[j] - points[i], size);
            let v = divide(points[k] - points[i], size);
            let w = divide(v, corner.sine) - u * cotangent;
            let norm = 0.5 * (u.re * u.re + u.im * u.im + w.re * w.re + w.im * w.im);
            let area = u.re * w.im - u.im * w.re;
            smallest = min(smallest, area);
            let SmoothArea { smooth, root } = smooth_area(area, self.epsilon);
            let slope = smooth / root;
            let shape = norm / smooth;
            let bulk = (area * area + 1.0) / (2.0 * smooth);
            energy += (1.0 - SIZE_WEIGHT) * shape + SIZE_WEIGHT * bulk;
            let mut by_area = -(1.0 - SIZE_WEIGHT) * shape * slope / smooth;
            by_area += SIZE_WEIGHT * (area - bulk * slope) / smooth;
            let by_area = Complex64::from(by_area);
            let by_norm = Complex64::from((1.0 - SIZE_WEIGHT) / smooth);
            let by_u = by_norm * u - I * w * by_area;
            let by_w = by_norm * w + I * u * by_area;
            let by_u = divide(by_u - by_w * cotangent, size);
            let by_v = divide(by_w, corner.sine * size);
            force[j] += by_u;
            force[k] += by_v;
            force[i] -= by_u + by_v;
        }
        Measure { energy, smallest }
    }
}

/// Minimise the energy of the drawing whose handles and interior vertices are `y`, in place; write
/// the vertices' points and return the smallest area of a triangle, as a part of the wanted one.
///
/// Each of at most `rounds` rounds takes at most `steps` L-BFGS steps with one smoothing; once a
/// round begins with no triangle flipped it is the last.
pub fn relax_points(
    disk: &Disk,
    y: &mut [Complex64],
    rounds: usize,
    steps: usize,
    points: &mut [Complex64],
) -> f64 {
    let force = vec![Complex64::ZERO; points.len()];
    let mut energy = DiskEnergy {
        disk,
        corners: disk.corners(),
        epsilon: 1.0,
        points,
        force,
    };
    let mut minimiser = Minimiser::new(y.len(), MEMORY, disk.size);
    let mut smallest = energy.measure(y).smallest;
    for _ in 0..rounds {
        let is_sound = smallest > 0.0;
        energy.epsilon = if is_sound {
            SHARP
        } else {
            (1e-8 + 0.04 * smallest * smallest).sqrt()
        };
        // Once sound, always sound: a step that flips a triangle is cut back.
        smallest = minimiser.descend(&mut energy, y, steps, is_sound).smallest;
        if is_sound {
            break;
        }
    }
    energy.epsilon = SHARP;
    energy.measure(y).smallest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nine vertices of four quads, the boundary a square of side 2, the middle one elsewhere.
    const QUADS: [[i32; 4]; 4] = [[0, 1, 8, 7], [1, 2, 3, 8], [8, 3, 4, 5], [7, 8, 5, 6]];

    #[test]
    fn a_vertex_outside_returns_to_the_middle() {
        let outline = [
            (0, 0),
            (1, 0),
            (2, 0),
            (2, 1),
            (2, 2),
            (1, 2),
            (0, 2),
            (0, 1),
        ];
        let mut y: Vec<Complex64> = outline
            .iter()
            .map(|&(x, y)| Complex64::new(f64::from(x), f64::from(y)))
            .collect();
        y.push(Complex64::new(3.5, 2.5));
        let disk = Disk {
            handles: 8,
            moving: false,
            ends: &std::array::from_fn::<_, 8, _>(|k| [k as i32; 3]),
            weights: &[[1.0, 0.0, 0.0]; 8],
            quads: &QUADS,
            angles: &[[std::f64::consts::FRAC_PI_2; 4]; 4],
            size: 1.0,
        };
        let mut points = vec![Complex64::ZERO; 9];
        let smallest = relax_points(&disk, &mut y, 12, 60, &mut points);
        assert!((smallest - 1.0).abs() < 1e-2);
        assert!((points[8] - Complex64::new(1.0, 1.0)).norm_sqr() < 1e-4);
    }
}
