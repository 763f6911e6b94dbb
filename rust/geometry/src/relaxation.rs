//! Moves the vertices of a flat disk until every quad is well shaped and none is flipped.
//!
//! Every corner of every quad is a triangle with a wanted angle and size. Its energy blows up as its
//! area falls to zero; while some triangle is still flipped the blow-up is smoothed, and sharpened
//! step by step as the drawing untangles, so that no valid start is needed.
//!
//! Source: Garanzha et al. 2021, "Foldover-free maps in 50 lines of code", for the energy and its
//! smoothing. Differs from the paper: L-BFGS is written out here, and the outline may move by its
//! handles.

use num_complex::Complex64;

use crate::vector::{max, min};

/// Part of a triangle's energy that is about size, the rest is about shape.
const SIZE_WEIGHT: f64 = 0.2;

/// Steps that L-BFGS remembers.
const MEMORY: usize = 10;

/// Times that a step is halved before it is given up.
const HALVINGS: usize = 30;

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
struct Energy<'a> {
    disk: &'a Disk<'a>,
    corners: Vec<Corner>,
    /// Scratch: the vertices' forces.
    force: Vec<Complex64>,
}

/// What a drawing is worth.
#[derive(Clone, Copy)]
struct Measure {
    energy: f64,
    /// The smallest area of a triangle, as a part of the wanted one.
    smallest: f64,
}

impl Energy<'_> {
    /// Measure the drawing with handles and interior vertices `y`; write its vertices' points and
    /// the energy's gradient by `y`.
    fn measure(
        &mut self,
        y: &[Complex64],
        epsilon: f64,
        points: &mut [Complex64],
        gradient: &mut [Complex64],
    ) -> Measure {
        let disk = self.disk;
        let (outline, interior) = points.split_at_mut(disk.ends.len());
        for ((point, ends), weights) in outline.iter_mut().zip(disk.ends).zip(disk.weights) {
            *point = Complex64::ZERO;
            for (&end, &weight) in ends.iter().zip(weights) {
                *point += Complex64::from(weight) * y[end as usize];
            }
        }
        interior.copy_from_slice(&y[disk.handles..]);
        let measure = self.measure_corners(points, epsilon);
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
        measure
    }

    /// Measure the drawing with vertices at `points`; set the forces.
    fn measure_corners(&mut self, points: &[Complex64], epsilon: f64) -> Measure {
        let size = self.disk.size;
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
            let root = (area * area + epsilon * epsilon).sqrt();
            let smooth = if area < 0.0 {
                0.5 * epsilon * epsilon / (root - area)
            } else {
                0.5 * (area + root)
            };
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

/// Return the inner product of two vectors of points.
fn dot(a: &[Complex64], b: &[Complex64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |total, (a, b)| total + (a.re * b.re + a.im * b.im))
}

/// The last steps of L-BFGS.
struct Memory {
    steps: Vec<Step>,
    /// Steps that were kept since the memory was last emptied.
    kept: usize,
}

/// A step: how y moved, how the gradient changed, and their inner product.
struct Step {
    moved: Vec<Complex64>,
    changed: Vec<Complex64>,
    curvature: f64,
}

impl Memory {
    fn new(n: usize) -> Memory {
        let step = || Step {
            moved: vec![Complex64::ZERO; n],
            changed: vec![Complex64::ZERO; n],
            curvature: 0.0,
        };
        Memory {
            steps: (0..MEMORY).map(|_| step()).collect(),
            kept: 0,
        }
    }

    /// Return the places of the remembered steps, the oldest first.
    fn places(&self) -> impl DoubleEndedIterator<Item = usize> + use<> {
        (self.kept.saturating_sub(MEMORY)..self.kept).map(|m| m % MEMORY)
    }

    /// Write the direction of the next step (Nocedal and Wright 2006, algorithm 7.4).
    fn write_direction(&self, gradient: &[Complex64], size: f64, direction: &mut [Complex64]) {
        for (direction, gradient) in direction.iter_mut().zip(gradient) {
            *direction = -gradient;
        }
        let mut alpha = [0.0; MEMORY];
        for s in self.places().rev() {
            let step = &self.steps[s];
            alpha[s] = dot(&step.moved, direction) / step.curvature;
            let scale = Complex64::from(alpha[s]);
            for (direction, changed) in direction.iter_mut().zip(&step.changed) {
                *direction -= scale * changed;
            }
        }
        let scale = if let Some(last) = self.places().next_back() {
            let step = &self.steps[last];
            step.curvature / dot(&step.changed, &step.changed)
        } else {
            let steepest = gradient.iter().map(|g| g.re.hypot(g.im)).fold(0.0, max);
            0.1 * size / (1e-30 + steepest)
        };
        let scale = Complex64::from(scale);
        for direction in direction.iter_mut() {
            *direction *= scale;
        }
        for s in self.places() {
            let step = &self.steps[s];
            let beta = dot(&step.changed, direction) / step.curvature;
            let scale = Complex64::from(alpha[s] - beta);
            for (direction, moved) in direction.iter_mut().zip(&step.moved) {
                *direction += scale * moved;
            }
        }
    }

    /// Remember a step in which the energy curves upwards.
    fn keep(&mut self, size: f64, y: [&[Complex64]; 2], gradient: [&[Complex64]; 2]) {
        let step = &mut self.steps[self.kept % MEMORY];
        subtract(y, &mut step.moved);
        subtract(gradient, &mut step.changed);
        step.curvature = dot(&step.moved, &step.changed);
        if step.curvature > 1e-14 * dot(&step.changed, &step.changed) * size * size {
            self.kept += 1;
        }
    }
}

/// Write the difference of two vectors, the second less the first.
fn subtract([from, to]: [&[Complex64]; 2], difference: &mut [Complex64]) {
    for ((difference, from), to) in difference.iter_mut().zip(from).zip(to) {
        *difference = to - from;
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
    let mut energy = Energy {
        disk,
        corners: disk.corners(),
        force: vec![Complex64::ZERO; points.len()],
    };
    let [mut gradient, mut direction] = [(); 2].map(|()| vec![Complex64::ZERO; y.len()]);
    let [mut trial, mut trial_gradient] = [(); 2].map(|()| vec![Complex64::ZERO; y.len()]);
    let mut memory = Memory::new(y.len());
    let mut now = energy.measure(y, 1.0, points, &mut gradient);
    for _ in 0..rounds {
        let sound = now.smallest > 0.0;
        let epsilon = if sound {
            SHARP
        } else {
            (1e-8 + 0.04 * now.smallest * now.smallest).sqrt()
        };
        now = energy.measure(y, epsilon, points, &mut gradient);
        memory.kept = 0;
        for _ in 0..steps {
            memory.write_direction(&gradient, disk.size, &mut direction);
            let descent = dot(&gradient, &direction);
            if descent >= 0.0 {
                if memory.kept == 0 {
                    break;
                }
                memory.kept = 0;
                continue;
            }
            let mut length = 1.0;
            let mut accepted = None;
            for _ in 0..HALVINGS {
                for ((trial, y), direction) in trial.iter_mut().zip(&*y).zip(&direction) {
                    *trial = y + Complex64::from(length) * direction;
                }
                let found = energy.measure(&trial, epsilon, points, &mut trial_gradient);
                // Once sound, always sound: a step that flips a triangle is cut back.
                if found.energy <= now.energy + 1e-4 * length * descent
                    && (found.smallest > 0.0 || !sound)
                {
                    accepted = Some(found);
                    break;
                }
                length *= 0.5;
            }
            let Some(found) = accepted else { break };
            memory.keep(disk.size, [&*y, &trial], [&gradient, &trial_gradient]);
            y.copy_from_slice(&trial);
            gradient.copy_from_slice(&trial_gradient);
            let settled = now.energy - found.energy <= 1e-6 * found.energy;
            now = found;
            if settled {
                break;
            }
        }
        if sound {
            break;
        }
    }
    energy.measure(y, SHARP, points, &mut gradient).smallest
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
