//! The fishbone of strokes: ribs, where they bend, and the cheapest way across them.

pub mod backbone;
pub mod cut;
pub mod terms;
pub mod tracking;

use patterndb_geometry::Point;

/// The samples of ribs.
#[derive(Clone, Copy, Debug)]
pub struct Ribs<'a> {
    /// The samples, rib by rib, as many of each.
    pub points: &'a [Point],
    /// Samples of a rib.
    pub n_rows: usize,
    /// The first sample of each rib that is on the surface.
    pub first: &'a [i64],
    /// The sample after the last of each rib that is on the surface.
    pub stop: &'a [i64],
}

impl<'a> Ribs<'a> {
    /// Return the number of ribs.
    fn len(&self) -> usize {
        self.first.len()
    }

    /// Return the samples of a rib.
    fn rib(&self, i: usize) -> &'a [Point] {
        &self.points[i * self.n_rows..][..self.n_rows]
    }

    /// Return the samples of a rib that are on the surface.
    fn valid(&self, i: usize) -> std::ops::Range<usize> {
        self.first[i] as usize..self.stop[i] as usize
    }

    /// Return the samples of a rib that have samples on both sides.
    fn inner(&self, i: usize) -> std::ops::Range<usize> {
        let valid = self.valid(i);
        valid.start + 1..valid.end.saturating_sub(1)
    }

    /// Return how many samples there are on both sides of one within [`Ribs::inner`].
    fn room(&self, i: usize, j: usize) -> usize {
        let valid = self.valid(i);
        (j - valid.start).min(valid.end - 1 - j)
    }
}
