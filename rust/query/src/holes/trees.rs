//! Ensembles of decision trees (Friedman 2001, "Greedy function approximation: a gradient boosting
//! machine").

/// Trees of which tree `t` adds to score `t % base.len()`.
#[derive(Clone, Copy, Debug)]
pub struct Trees<'a> {
    /// Where the nodes of each tree begin, and how many nodes there are in all.
    pub start: &'a [i32],
    /// The feature that a node compares, -1 at a leaf.
    pub feature: &'a [i16],
    /// The left child is taken where the feature is not above this.
    pub threshold: &'a [f32],
    /// The left child, counted from the tree's first node; the right one is the next.
    pub child: &'a [i16],
    /// What a leaf adds.
    pub value: &'a [f32],
    /// The scores without any tree.
    pub base: &'a [f64],
}

impl Trees<'_> {
    /// Return what the tree whose nodes begin at `first` adds for a row of features.
    fn evaluate(&self, first: usize, row: &[f64]) -> f32 {
        let mut at = first;
        while let Ok(feature) = usize::try_from(self.feature[at]) {
            let is_above = row[feature] > f64::from(self.threshold[at]);
            at = first + self.child[at] as usize + usize::from(is_above);
        }
        self.value[at]
    }

    /// Return the scores of rows of `n_features` features: all of the first row, then of the next.
    pub fn score(&self, rows: &[f64], n_features: usize) -> Vec<f64> {
        let kinds = self.base.len();
        let n_rows = rows.len().checked_div(n_features).unwrap_or(0);
        let mut scores = self.base.repeat(n_rows);
        let firsts = self
            .start
            .split_last()
            .map_or(&[][..], |(_, firsts)| firsts);
        let rows = rows.chunks_exact(n_features.max(1));
        for (row, scores) in rows.zip(scores.chunks_exact_mut(kinds.max(1))) {
            for (t, &first) in firsts.iter().enumerate() {
                scores[t % kinds] += f64::from(self.evaluate(first as usize, row));
            }
        }
        scores
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_add_up() {
        let trees = Trees {
            start: &[0, 3, 4],
            feature: &[1, -1, -1, -1],
            threshold: &[0.5, 0.0, 0.0, 0.0],
            child: &[1, 0, 0, 0],
            value: &[0.0, 1.0, 2.0, 10.0],
            base: &[0.25],
        };
        let scores = trees.score(&[9.0, 0.5, -9.0, 0.75], 2);
        assert_eq!(scores, [11.25, 12.25]);
    }
}
