//! What a choice of cycles can be worth at most with each candidate.
//!
//! The gain of a candidate is laid on its curves in shares, and so is the cost of a pair. Any choice
//! is then worth no more than the sum, over all curves, of the best one or two candidates at each.
//! Shares are moved from curves where a candidate could not be missed to those where it could not be
//! afforded, one candidate after another, and the sum falls at every step: block coordinate ascent of
//! the dual of set packing, as in MPLP (Globerson and Jaakkola 2007).

use std::ops::Range;

use patterndb_geometry::vector::max;

/// What lacks at a curve that must be bounded twice: more than any gain, and a number that can be
/// shared out (LACKING in patterndb_sketch.surfacing.cycles.packing).
const LACKING: f64 = 1e5;

/// Which candidates are at which curves. An entry is a candidate and one of its curves.
#[derive(Clone, Copy, Debug)]
pub struct Incidence<'a> {
    /// The first entry of every candidate, and the number of entries.
    pub first: &'a [i64],
    /// The curve of every entry.
    pub member: &'a [i64],
    /// The candidate's place among the curve's candidates, for every entry.
    pub place: &'a [i64],
    /// Where the shares of every curve's candidates begin, and their number.
    pub start: &'a [i64],
    /// Where every curve's table of costs begins: of the pairs of its candidates.
    pub offset: &'a [i64],
}

impl Incidence<'_> {
    fn entries(&self, candidate: usize) -> Range<usize> {
        self.first[candidate] as usize..self.first[candidate + 1] as usize
    }

    fn curve(&self, entry: usize) -> usize {
        self.member[entry] as usize
    }

    fn place(&self, entry: usize) -> usize {
        self.place[entry] as usize
    }

    fn shares(&self, curve: usize) -> Range<usize> {
        self.start[curve] as usize..self.start[curve + 1] as usize
    }

    fn costs(&self, curve: usize) -> Range<usize> {
        self.offset[curve] as usize..self.offset[curve + 1] as usize
    }

    /// Return the entries of two candidates at the curves that they share.
    fn meetings(&self, one: usize, other: usize) -> impl Iterator<Item = (usize, usize)> {
        self.entries(one)
            .flat_map(move |e| self.entries(other).map(move |f| (e, f)))
            .filter(|&(e, f)| self.member[e] == self.member[f])
    }
}

/// The costs of pairs of candidates.
#[derive(Clone, Copy, Debug)]
pub struct Pairs<'a> {
    /// One candidate of every pair.
    pub one: &'a [i64],
    /// The other.
    pub other: &'a [i64],
    /// What both together cost; LACKING or more where they cannot be had.
    pub price: &'a [f64],
}

/// Write the costs of pairs to the tables of the curves that they share, in equal parts.
///
/// What cannot be had costs all at each.
pub fn spread_costs(incidence: &Incidence, pairs: &Pairs, cost: &mut [f64]) {
    for ((&one, &other), &price) in pairs.one.iter().zip(pairs.other).zip(pairs.price) {
        let (one, other) = (one as usize, other as usize);
        let shared = incidence.meetings(one, other).count();
        let part = if price >= LACKING {
            price
        } else {
            price / shared as f64
        };
        for (e, f) in incidence.meetings(one, other) {
            let curve = incidence.curve(e);
            let width = incidence.shares(curve).len();
            let table = &mut cost[incidence.costs(curve)];
            let (e, f) = (incidence.place(e), incidence.place(f));
            table[e * width + f] = part;
            table[f * width + e] = part;
        }
    }
}

/// The candidates at a curve.
#[derive(Clone, Copy)]
struct Choosing<'a> {
    /// What every candidate is worth here.
    shares: &'a [f64],
    /// The costs of pairs, k rows of k.
    cost: &'a [f64],
    /// How many of them may be chosen.
    room: i64,
    /// What is paid for room that is left.
    lacking: f64,
}

impl Choosing<'_> {
    fn costs(&self, candidate: usize) -> &[f64] {
        &self.cost[candidate * self.shares.len()..][..self.shares.len()]
    }

    /// Return what the candidates but one are worth at most, as many as there is room for.
    fn find_best_without(&self, left_out: Option<usize>) -> f64 {
        let mut best = (-self.room) as f64 * self.lacking;
        if self.room == 0 {
            return best;
        }
        let others = || {
            let numbered = self.shares.iter().copied().enumerate();
            numbered.filter(|&(a, _)| Some(a) != left_out)
        };
        let rest = (self.room - 1) as f64 * self.lacking;
        let mut top = f64::NEG_INFINITY;
        for (_, share) in others() {
            best = max(best, share - rest);
            top = max(top, share);
        }
        if self.room == 1 {
            return best;
        }
        for (a, share) in others() {
            if share + top <= best {
                continue;
            }
            for ((b, &other), cost) in self.shares[..a].iter().enumerate().zip(self.costs(a)) {
                if Some(b) != left_out && share + other > best {
                    best = max(best, share + other - cost);
                }
            }
        }
        best
    }

    /// Return what those choices are worth at most that have one of the candidates; there must be
    /// room.
    fn find_best_with(&self, one: usize) -> f64 {
        if self.room == 1 {
            return self.shares[one];
        }
        let mut partner = -self.lacking;
        for (b, (share, cost)) in self.shares.iter().zip(self.costs(one)).enumerate() {
            if b != one {
                partner = max(partner, share - cost);
            }
        }
        self.shares[one] + partner
    }
}

/// What is chosen at curves.
#[derive(Clone, Copy, Debug)]
pub struct Curves<'a> {
    /// The costs of pairs at every curve, from [`spread_costs`].
    pub cost: &'a [f64],
    /// How many candidates may be chosen at every curve.
    pub room: &'a [i64],
    /// Whether LACKING is paid there for room that is left.
    pub whole: &'a [bool],
}

impl Curves<'_> {
    fn choosing<'a>(
        &'a self,
        curve: usize,
        incidence: &Incidence,
        shares: &'a [f64],
    ) -> Choosing<'a> {
        Choosing {
            shares: &shares[incidence.shares(curve)],
            cost: &self.cost[incidence.costs(curve)],
            room: self.room[curve],
            lacking: if self.whole[curve] { LACKING } else { 0.0 },
        }
    }
}

/// Move shares until what the best at all curves are worth is little; return their sum.
///
/// margin: written for every entry: what the best at the curve gain by having the candidate.
pub fn move_shares(
    incidence: &Incidence,
    curves: &Curves,
    shares: &mut [f64],
    margin: &mut [f64],
    sweeps: usize,
) -> f64 {
    let n = incidence.first.len() - 1;
    for sweep in 0..=sweeps {
        for k in 0..n {
            let candidate = if sweep % 2 == 0 { k } else { n - 1 - k };
            let entries = incidence.entries(candidate);
            let mut total = 0.0;
            for e in entries.clone() {
                let place = incidence.place(e);
                let here = curves.choosing(incidence.curve(e), incidence, shares);
                margin[e] = here.find_best_with(place) - here.find_best_without(Some(place));
                total += margin[e];
            }
            if sweep < sweeps {
                // As much is gained at each of its curves: nowhere more than is lost elsewhere.
                let mean = total / entries.len() as f64;
                for e in entries {
                    let here = &mut shares[incidence.shares(incidence.curve(e))];
                    here[incidence.place(e)] += mean - margin[e];
                }
            }
        }
    }
    (0..curves.room.len()).fold(0.0, |best, curve| {
        best + curves
            .choosing(curve, incidence, shares)
            .find_best_without(None)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_candidates_at_one_curve_are_worth_the_better() {
        let incidence = Incidence {
            first: &[0, 1, 2],
            member: &[0, 0],
            place: &[0, 1],
            start: &[0, 2],
            offset: &[0, 4],
        };
        let curves = Curves {
            cost: &[0.0; 4],
            room: &[1],
            whole: &[false],
        };
        let (mut shares, mut margin) = ([3.0, 2.0], [0.0; 2]);
        let best = move_shares(&incidence, &curves, &mut shares, &mut margin, 4);
        assert_eq!(best, 3.0);
        assert_eq!(margin, [1.0, -1.0]);
    }

    #[test]
    fn a_pair_costs_its_price_where_it_meets() {
        // Two candidates on the same two curves.
        let incidence = Incidence {
            first: &[0, 2, 4],
            member: &[0, 1, 1, 0],
            place: &[0, 0, 1, 1],
            start: &[0, 2, 4],
            offset: &[0, 4, 8],
        };
        let pairs = Pairs {
            one: &[0],
            other: &[1],
            price: &[3.0],
        };
        let mut cost = [0.0; 8];
        spread_costs(&incidence, &pairs, &mut cost);
        assert_eq!(cost, [0.0, 1.5, 1.5, 0.0, 0.0, 1.5, 1.5, 0.0]);
        let curves = Curves {
            cost: &cost,
            room: &[2, 2],
            whole: &[false, true],
        };
        let (mut shares, mut margin) = ([2.0, 2.0, 2.0, 2.0], [0.0; 4]);
        // Both are worth 4 + 4 - 3.
        let best = move_shares(&incidence, &curves, &mut shares, &mut margin, 16);
        assert!(best >= 5.0 - 1e-9);
    }
}
