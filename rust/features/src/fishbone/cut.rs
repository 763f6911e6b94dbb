//! The cheapest way across the ribs: the minimum cut of the fishbone's graph, exactly.

/// The cheapest way across ribs.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// The sample of each rib that is cut.
    pub rows: Vec<i64>,
    /// The sum of all costs.
    pub cost: f64,
}

/// From which row of the rib before each row of a rib is reached.
pub(super) struct Origins {
    n_rows: usize,
    rows: Vec<i32>,
}

impl Origins {
    pub(super) fn new(n_ribs: usize, n_rows: usize) -> Origins {
        let rows = Vec::with_capacity(n_ribs * n_rows);
        Origins { n_rows, rows }
    }

    /// Add a rib that is reached in a straight line, to be changed.
    pub(super) fn begin_rib(&mut self) -> &mut [i32] {
        let begun = self.rows.len();
        self.rows.extend(0..self.n_rows as i32);
        &mut self.rows[begun..]
    }

    /// Return the cheapest way, by the cost of reaching each row of the last rib.
    pub(super) fn walk_back(&self, costs: &[f64]) -> Way {
        let less = |best: usize, j: usize| if costs[j] < costs[best] { j } else { best };
        let last = (1..costs.len()).fold(0, less);
        let mut rows = vec![last as i64];
        let mut row = last;
        for origins in self.rows.rchunks_exact(self.n_rows) {
            row = origins[row] as usize;
            rows.push(row as i64);
        }
        rows.reverse();
        let cost = costs[last];
        Way { rows, cost }
    }
}

/// Spread costs to the next rows where that makes these cheaper, by one pass down and one up: their
/// lower envelope of cones with a slope. `origins` are the rows that costs come from.
///
/// Source: Felzenszwalb and Huttenlocher 2012, "Distance transforms of sampled functions".
pub(super) fn spread(costs: &mut [f64], origins: &mut [i32], slope: f64) {
    pass_on(costs.iter_mut().zip(origins.iter_mut()), slope);
    pass_on(costs.iter_mut().zip(origins).rev(), slope);
}

/// Pass costs on from each row to the next.
fn pass_on<'a>(rows: impl Iterator<Item = (&'a mut f64, &'a mut i32)>, slope: f64) {
    let mut before = (f64::INFINITY, 0);
    for (cost, origin) in rows {
        let through = before.0 + slope;
        if through < *cost {
            (*cost, *origin) = (through, before.1);
        }
        before = (*cost, *origin);
    }
}

/// Return the rows of ribs with the least sum of their costs and of what the rows between neighbours
/// cost.
///
/// `costs` has `n_rows` items for each rib, and `cross` the price of a row between each rib and the
/// next.
///
/// Source: feature curve recovery paper, section 4.3.3. Differs from the paper: dynamic programming in
/// place of a maximum flow.
pub fn find_cheapest(costs: &[f64], n_rows: usize, cross: &[f64]) -> Way {
    let (first, rest) = costs.split_at(n_rows);
    let mut best = first.to_vec();
    let mut origins = Origins::new(cross.len(), n_rows);
    for (costs, &step) in rest.chunks_exact(n_rows).zip(cross) {
        spread(&mut best, origins.begin_rib(), step);
        for (best, cost) in best.iter_mut().zip(costs) {
            *best += cost;
        }
    }
    origins.walk_back(&best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_taken_where_it_pays() {
        let costs = [0.0, 5.0, 5.0, 5.0, 5.0, 0.0];
        let rows = |step: f64| find_cheapest(&costs, 3, &[step]);
        let (near, far) = (rows(1.0), rows(4.0));
        assert_eq!((near.rows, near.cost), (vec![0, 2], 2.0));
        assert_eq!((far.rows, far.cost), (vec![0, 0], 5.0));
    }
}
