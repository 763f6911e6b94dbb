//! The width problem of many patterns: in which of them strands can lie on the strokes, and the best
//! widths of each.
//!
//! The answer for a row does not depend on the others.

use crate::solving::balance::Best;
use crate::solving::strokes::{Label, OrientedProblem, Stroke, add_best_widths, can_carry};

/// The boundary labels of many patterns.
#[derive(Clone, Copy, Debug)]
pub struct Labels<'a> {
    /// Number of sides, at least 1.
    pub n_sides: usize,
    /// For every row its label as a word, see [`Label::new`].
    pub words: &'a [i16],
    /// Where each word begins, and where the last ends.
    pub start: &'a [i64],
}

impl Labels<'_> {
    fn label(&self, row: i64) -> Label {
        let range = self.start[row as usize] as usize..self.start[row as usize + 1] as usize;
        Label::new(&self.words[range], self.n_sides)
    }
}

/// A boundary and strokes, once for every orientation.
#[derive(Clone, Copy, Debug)]
pub struct WidthProblem<'a> {
    /// For each orientation a row of the edges of every side, in the pattern's order.
    pub lengths: &'a [i32],
    /// For each orientation the weights of [`OrientedProblem::weights`].
    pub weights: &'a [i32],
    /// For each orientation the strokes.
    pub strokes: &'a [Stroke],
    /// Edges that a strand's end may be off.
    pub tolerance: i32,
    /// Number of sides.
    pub n_sides: usize,
}

impl WidthProblem<'_> {
    fn n_orientations(&self) -> usize {
        self.lengths.len() / self.n_sides
    }

    fn oriented(&self, orientation: usize) -> OrientedProblem<'_> {
        let n = self.n_sides;
        let n_strokes = self.strokes.len() / self.n_orientations();
        OrientedProblem {
            lengths: &self.lengths[orientation * n..][..n],
            weights: &self.weights[orientation * n * n..][..n * n],
            strokes: &self.strokes[orientation * n_strokes..][..n_strokes],
            tolerance: self.tolerance,
        }
    }
}

/// Keep of the allowed orientations of rows those in which strands can lie on all strokes.
///
/// `allowed` has a row of orientations for each. `once`: at most one of each row. Once `is_cancelled`,
/// the answer is of no use.
pub fn filter_stroke_feasible(
    labels: &Labels,
    rows: &[i64],
    problem: &WidthProblem,
    once: bool,
    is_cancelled: &impl Fn() -> bool,
    allowed: &mut [bool],
) {
    let allowed = allowed.chunks_exact_mut(problem.n_orientations());
    for (&row, allowed) in rows.iter().zip(allowed) {
        if is_cancelled() {
            return;
        }
        let label = labels.label(row);
        let mut found = false;
        for (o, allowed) in allowed.iter_mut().enumerate() {
            *allowed = *allowed
                && !(once && found)
                && can_carry(&label, &problem.oriented(o), is_cancelled);
            found |= *allowed;
        }
    }
}

/// The best fits of some rows, to be written.
#[derive(Debug)]
pub struct Fits<'a> {
    /// How many each row has.
    pub count: &'a mut [i64],
    /// For each row the keys of its fits.
    pub key: &'a mut [i64],
    /// For each fit the widths of its strands, in label order, and last its orientation.
    pub best: &'a mut [i32],
    /// The most fits of a row.
    pub keep: usize,
}

/// Write the best fits of rows over the allowed orientations. Once `is_cancelled`, rows are missing.
pub fn find_best_widths(
    labels: &Labels,
    rows: &[i64],
    allowed: &[bool],
    problem: &WidthProblem,
    is_cancelled: &impl Fn() -> bool,
    fits: &mut Fits,
) {
    let n_orientations = problem.n_orientations();
    let width = fits.best.len() / fits.key.len().max(1);
    for (r, &row) in rows.iter().enumerate() {
        if is_cancelled() {
            return;
        }
        let label = labels.label(row);
        let mut best = Best {
            keep: fits.keep,
            ..Best::default()
        };
        for o in (0..n_orientations).filter(|o| allowed[r * n_orientations + o]) {
            add_best_widths(
                &label,
                &problem.oriented(o),
                o as i32,
                &mut best,
                is_cancelled,
            );
        }
        fits.count[r] = best.solutions.len() as i64;
        for (f, solution) in best.solutions.iter().enumerate() {
            let at = r * fits.keep + f;
            fits.key[at] = solution.key;
            let written = &mut fits.best[at * width..][..width];
            written[..solution.widths.len()].copy_from_slice(&solution.widths);
            written[width - 1] = solution.tag;
        }
    }
}
