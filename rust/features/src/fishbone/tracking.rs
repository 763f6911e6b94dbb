//! The cheapest way across the ribs that keeps to one crease: the ribs are judged together, by how the
//! surface bends at them.

use patterndb_geometry::Point;
use patterndb_geometry::vector::{length, subtract};

use super::cut::{Origins, Way, spread};

/// What is known of the samples of ribs, and what it costs to go from one to another.
#[derive(Clone, Copy, Debug)]
pub struct Creases<'a> {
    /// What each sample costs, rib by rib; infinite where a rib may not be cut.
    pub costs: &'a [f64],
    /// How the surface bends at each sample: the way and by how much.
    pub bends: &'a [Point],
    /// Samples of a rib.
    pub n_rows: usize,
    /// The price of a row between each rib and the next.
    pub cross: &'a [f64],
    /// Rows that a crease may cross from each rib to the next.
    pub reach: &'a [i64],
    /// The price of a crease that is another: of bends that differ by 1.
    pub change: f64,
    /// What a leap costs, as a multiple of the price of the rows that it passes.
    pub leap: f64,
}

/// Return the rows of ribs with the least sum of their costs and of what each two neighbours cost.
///
/// Neighbours within reach cost the rows between them and the difference of their bends: a crease
/// keeps its angle, its side and its direction. Farther apart, or if it is cheaper, they cost a leap
/// and both their bends: the one crease is left and another is met. Exact dynamic programming, rib by
/// rib.
///
/// Source: feature curve recovery paper, section 4.3.3. Differs from the paper: there the sample of a
/// rib costs the same whatever its neighbours are.
pub fn track(creases: &Creases) -> Way {
    let &Creases { n_rows, change, .. } = creases;
    let mut best = creases.costs[..n_rows].to_vec();
    let mut origins = Origins::new(creases.cross.len(), n_rows);
    let ribs = creases.costs.chunks_exact(n_rows);
    let ribs = ribs.zip(creases.bends.chunks_exact(n_rows)).skip(1);
    let steps = creases.bends.chunks_exact(n_rows);
    let steps = steps.zip(creases.cross.iter().zip(creases.reach));
    for ((costs, bends), (before, (&step, &reach))) in ribs.zip(steps) {
        let leaving = best.iter().zip(before);
        let mut after: Vec<f64> = leaving
            .map(|(best, bend)| best + change * length(bend))
            .collect();
        let origins = origins.begin_rib();
        spread(&mut after, origins, creases.leap * step);
        let reach = reach as usize;
        for (j, ((after, origin), bend)) in after.iter_mut().zip(origins).zip(bends).enumerate() {
            if costs[j] == f64::INFINITY {
                *after = f64::INFINITY;
                continue;
            }
            *after += change * length(bend);
            let near = j.saturating_sub(reach)..n_rows.min(j + reach + 1);
            let rows = best[near.clone()].iter().zip(&before[near.clone()]);
            for (other, (best, other_bend)) in (near.start as i32..).zip(rows) {
                let through = best + step * f64::from((other - j as i32).abs());
                if through >= *after {
                    continue;
                }
                let through = through + change * length(&subtract(bend, other_bend));
                if through < *after {
                    *after = through;
                    *origin = other;
                }
            }
        }
        for ((best, after), cost) in best.iter_mut().zip(after).zip(costs) {
            *best = after + cost;
        }
    }
    origins.walk_back(&best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crease_is_kept_though_another_is_a_little_sharper() {
        const UP: Point = [0.0, 0.0, 1.0];
        const SIDE: Point = [1.0, 0.0, 0.0];
        let bends = [UP, SIDE].repeat(4);
        let costs = [0.0, 0.1, 0.1, 0.0, 0.1, 0.0, 0.0, 0.1];
        let way = |change: f64| {
            track(&Creases {
                costs: &costs,
                bends: &bends,
                n_rows: 2,
                cross: &[0.01; 3],
                reach: &[2; 3],
                change,
                leap: 3.0,
            })
        };
        assert_eq!(way(0.0).rows, [0, 1, 1, 0]);
        let kept = way(1.0);
        assert_eq!(kept.rows, [0; 4]);
        assert!((kept.cost - 0.2).abs() < 1e-12);
    }
}
