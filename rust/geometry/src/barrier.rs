//! Energies that blow up as the area of a triangle falls to zero, and their minimisation.
//!
//! While some triangle is flipped the blow-up is smoothed, and sharpened step by step, so that no valid
//! start is needed.
//!
//! Source: Garanzha et al. 2021, "Foldover-free maps in 50 lines of code", for the energy and its
//! smoothing. Differs from the paper: L-BFGS is written out here.

use std::ops::{AddAssign, MulAssign, Neg, Sub, SubAssign};

use num_complex::Complex64;

use crate::vector::max;

/// Times that a step is halved before it is given up.
const HALVINGS: usize = 30;

/// What a drawing is worth.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// The energy of all triangles.
    pub energy: f64,
    /// The smallest area of a triangle.
    pub smallest: f64,
}

/// An area smoothed so that it is positive, and the root in it, by which its slope is
/// `smooth / root`.
#[derive(Clone, Copy, Debug)]
pub struct SmoothArea {
    /// The smoothed area.
    pub smooth: f64,
    /// The root of the area's square and the smoothing's.
    pub root: f64,
}

/// Smooth an area; the smaller `epsilon` is, the nearer the result is to what is positive of it.
#[inline(always)]
pub fn smooth_area(area: f64, epsilon: f64) -> SmoothArea {
    let root = (area * area + epsilon * epsilon).sqrt();
    let smooth = if area < 0.0 {
        0.5 * epsilon * epsilon / (root - area)
    } else {
        0.5 * (area + root)
    };
    SmoothArea { smooth, root }
}

/// A number that is sought: a real one, or a point in the plane.
pub trait Unknown:
    Copy + Default + Neg<Output = Self> + Sub<Output = Self> + AddAssign + SubAssign + MulAssign<f64>
{
    /// The inner product.
    fn dot(self, other: Self) -> f64;
    /// A multiple.
    fn times(self, factor: f64) -> Self;
    /// How far it is from zero.
    fn size(self) -> f64;
}

impl Unknown for f64 {
    #[inline(always)]
    fn dot(self, other: f64) -> f64 {
        self * other
    }
    #[inline(always)]
    fn times(self, factor: f64) -> f64 {
        factor * self
    }
    fn size(self) -> f64 {
        self.abs()
    }
}

impl Unknown for Complex64 {
    #[inline(always)]
    fn dot(self, other: Complex64) -> f64 {
        self.re * other.re + self.im * other.im
    }
    #[inline(always)]
    fn times(self, factor: f64) -> Complex64 {
        Complex64::new(factor * self.re, factor * self.im)
    }
    fn size(self) -> f64 {
        self.re.hypot(self.im)
    }
}

/// An energy of unknowns.
pub trait Energy<T> {
    /// Measure the drawing at `at`.
    fn measure(&mut self, at: &[T]) -> Measure;
    /// Write the gradient at what was measured last.
    fn write_gradient(&self, gradient: &mut [T]);
}

fn dot<T: Unknown>(a: &[T], b: &[T]) -> f64 {
    a.iter().zip(b).fold(0.0, |total, (a, b)| total + a.dot(*b))
}

/// A step of L-BFGS: the move, how the gradient changed, and their inner product.
struct Step<T> {
    moved: Vec<T>,
    changed: Vec<T>,
    curvature: f64,
}

/// Minimises energies by L-BFGS (Nocedal and Wright 2006, algorithms 7.4 and 7.5).
pub struct Minimiser<T> {
    steps: Vec<Step<T>>,
    /// Steps that were kept since the memory was last emptied.
    kept: usize,
    /// A typical length.
    size: f64,
    gradient: Vec<T>,
    direction: Vec<T>,
    trial: Vec<T>,
    trial_gradient: Vec<T>,
    /// Scratch of the two loops.
    alpha: Vec<f64>,
}

impl<T: Unknown> Minimiser<T> {
    /// Make a minimiser for `n` unknowns that remembers `memory` steps; `size` is a typical length.
    pub fn new(n: usize, memory: usize, size: f64) -> Minimiser<T> {
        let zeros = || vec![T::default(); n];
        let step = |_| Step {
            moved: zeros(),
            changed: zeros(),
            curvature: 0.0,
        };
        Minimiser {
            steps: (0..memory).map(step).collect(),
            kept: 0,
            size,
            gradient: zeros(),
            direction: zeros(),
            trial: zeros(),
            trial_gradient: zeros(),
            alpha: vec![0.0; memory],
        }
    }

    /// Return the places of the remembered steps, the oldest first.
    fn places(&self) -> impl DoubleEndedIterator<Item = usize> + use<T> {
        let memory = self.steps.len();
        (self.kept.saturating_sub(memory)..self.kept).map(move |m| m % memory)
    }

    /// Set the direction of the next step.
    fn set_direction(&mut self) {
        let mut largest = 0.0;
        for (direction, gradient) in self.direction.iter_mut().zip(&self.gradient) {
            *direction = -*gradient;
            largest = max(largest, gradient.size());
        }
        for s in self.places().rev() {
            let step = &self.steps[s];
            self.alpha[s] = dot(&step.moved, &self.direction) / step.curvature;
            for (direction, changed) in self.direction.iter_mut().zip(&step.changed) {
                *direction -= changed.times(self.alpha[s]);
            }
        }
        let scale = if let Some(last) = self.places().next_back() {
            let step = &self.steps[last];
            step.curvature / dot(&step.changed, &step.changed)
        } else {
            0.1 * self.size / (1e-30 + largest)
        };
        self.direction.iter_mut().for_each(|x| *x *= scale);
        for s in self.places() {
            let step = &self.steps[s];
            let beta = dot(&step.changed, &self.direction) / step.curvature;
            let scale = self.alpha[s] - beta;
            for (direction, moved) in self.direction.iter_mut().zip(&step.moved) {
                *direction += moved.times(scale);
            }
        }
    }

    /// Remember the step from `at` to the trial, if the energy curves upwards in it.
    fn keep(&mut self, at: &[T]) {
        let place = self.kept % self.steps.len();
        let step = &mut self.steps[place];
        write_difference([at, &self.trial], &mut step.moved);
        write_difference([&self.gradient, &self.trial_gradient], &mut step.changed);
        step.curvature = dot(&step.moved, &step.changed);
        let size = self.size;
        if step.curvature > 1e-14 * dot(&step.changed, &step.changed) * size * size {
            self.kept += 1;
        }
    }

    /// Take at most `most` steps from `at`, in place; return what is reached.
    ///
    /// With `is_sound` no step is taken that flips a triangle. The energy may have been measured last
    /// at a step that was given up.
    pub fn descend(
        &mut self,
        energy: &mut impl Energy<T>,
        at: &mut [T],
        most: usize,
        is_sound: bool,
    ) -> Measure {
        let mut now = energy.measure(at);
        energy.write_gradient(&mut self.gradient);
        self.kept = 0;
        for _ in 0..most {
            self.set_direction();
            let descent = dot(&self.gradient, &self.direction);
            if descent >= 0.0 {
                if self.kept == 0 {
                    break;
                }
                self.kept = 0;
                continue;
            }
            let mut length = 1.0;
            let mut accepted = None;
            for _ in 0..HALVINGS {
                self.trial.copy_from_slice(at);
                for (trial, direction) in self.trial.iter_mut().zip(&self.direction) {
                    *trial += direction.times(length);
                }
                let found = energy.measure(&self.trial);
                if found.energy <= now.energy + 1e-4 * length * descent
                    && (found.smallest > 0.0 || !is_sound)
                {
                    accepted = Some(found);
                    break;
                }
                length *= 0.5;
            }
            let Some(found) = accepted else { break };
            energy.write_gradient(&mut self.trial_gradient);
            self.keep(at);
            at.copy_from_slice(&self.trial);
            self.gradient.copy_from_slice(&self.trial_gradient);
            let settled = now.energy - found.energy <= 1e-6 * found.energy;
            now = found;
            if settled {
                break;
            }
        }
        now
    }
}

/// Write the difference of two vectors, the second less the first.
fn write_difference<T: Unknown>([from, to]: [&[T]; 2], difference: &mut [T]) {
    for ((difference, from), to) in difference.iter_mut().zip(from).zip(to) {
        *difference = *to - *from;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The squared distance from 3 and -1, the second weighed ten times.
    #[derive(Default)]
    struct Bowl(Vec<f64>);

    impl Energy<f64> for Bowl {
        fn measure(&mut self, at: &[f64]) -> Measure {
            self.0 = vec![2.0 * (at[0] - 3.0), 20.0 * (at[1] + 1.0)];
            let energy = (at[0] - 3.0).powi(2) + 10.0 * (at[1] + 1.0).powi(2);
            Measure {
                energy,
                smallest: 1.0,
            }
        }
        fn write_gradient(&self, gradient: &mut [f64]) {
            gradient.copy_from_slice(&self.0);
        }
    }

    #[test]
    fn a_bowl_is_descended_to_its_bottom() {
        let mut at = [0.0, 5.0];
        let reached = Minimiser::new(2, 4, 1.0).descend(&mut Bowl::default(), &mut at, 60, true);
        assert!(reached.energy < 1e-9);
        assert!((at[0] - 3.0).abs() < 1e-4 && (at[1] + 1.0).abs() < 1e-4);
    }

    #[test]
    fn smoothed_areas_are_positive_and_sharpen() {
        assert!(smooth_area(-1.0, 0.1).smooth > 0.0);
        assert!((smooth_area(2.0, 1e-6).smooth - 2.0).abs() < 1e-9);
    }
}
