//! Basic enumeration: every patch of at most a number of quads, each exactly once.
//!
//! Connected sets of quads are built from their smallest quad, never returning to a quad that was
//! passed over (Redelmeier's way to count polyominoes), so each set comes up once and nothing has to
//! be remembered; those that are disks are patches. Differs from the paper (Marcias et al. 2015),
//! which grows disks and remembers them by a hash.
//!
//! Most small patches look alike. A running hash of how each quad is attached to those before it
//! finds the pattern of a patch that was built the same way before, without reducing it.

use std::ops::Range;

use crate::census::{Bench, Census, KernelMesh};
use crate::hashing::{GOLDEN, Key, KeyMap, has_slot, mix, toggle};
use crate::pulse::Pulse;

/// Most slots with which the map of patches by how they were built begins.
const FIRST_SLOTS: usize = 1 << 16;

/// A quad that may be added to a patch, and the edge by which it was reached.
#[derive(Clone, Copy, Default)]
struct Candidate {
    quad: i32,
    entry: i32,
}

/// The patch of the search's first d quads.
#[derive(Clone, Copy, Default)]
struct Level {
    /// Place of the candidate at hand.
    at: usize,
    /// End of its candidates.
    end: usize,
    /// V - E + F.
    euler: i32,
    /// Hash of how it was built.
    build: Key,
    /// Hash of its quads.
    hash: Key,
    /// Edge by which the candidate at hand is entered.
    entered: i32,
}

struct Search<'s, 'a> {
    limit: usize,
    mesh: &'s KernelMesh<'a>,
    bench: &'s mut Bench<'a>,
    census: &'s mut Census<'a>,
    pulse: &'s mut Pulse<'a>,
    candidates: Vec<Candidate>,
    levels: Vec<Level>,
    /// Whether each quad is a candidate, or was one of a smaller patch.
    reached: Vec<bool>,
    /// What a patch that was built in some way was recognised as.
    built: KeyMap<'static>,
    n_built: i64,
    total: i64,
}

/// Count the patches of at most `limit` quads whose smallest quad is one of `roots`; return their
/// number.
pub fn count_basic<'a>(
    roots: Range<i32>,
    limit: usize,
    mesh: &KernelMesh<'a>,
    bench: &mut Bench<'a>,
    census: &mut Census<'a>,
    pulse: &mut Pulse<'a>,
) -> i64 {
    let mut search = Search {
        limit,
        built: KeyMap::new(FIRST_SLOTS.min(census.most)),
        mesh,
        bench,
        census,
        pulse,
        candidates: vec![Candidate::default(); 4 * limit + 4],
        levels: vec![Level::default(); limit + 1],
        reached: vec![false; mesh.zobrist.len()],
        n_built: 0,
        total: 0,
    };
    for root in roots {
        search.build_from(root);
    }
    search.total
}

impl Search<'_, '_> {
    /// Build every connected set of quads whose smallest is `root`; return at once when the search has
    /// to stop.
    fn build_from(&mut self, root: i32) {
        self.candidates[0] = Candidate {
            quad: root,
            entry: 0,
        };
        self.reached[root as usize] = true;
        self.levels[0].at = 0;
        self.levels[0].end = 1;
        let mut d = 0;
        loop {
            if self.pulse.is_stopped() {
                return;
            }
            let Level { at, end, .. } = self.levels[d];
            if at < end {
                self.reserve();
                self.add(d, self.candidates[at]);
                if d + 1 < self.limit {
                    self.list_candidates(d, root);
                    d += 1;
                    continue;
                }
            } else if d == 0 {
                break;
            } else {
                d -= 1;
                for candidate in &self.candidates[self.levels[d].end..end] {
                    self.reached[candidate.quad as usize] = false;
                }
            }
            let level = &mut self.levels[d];
            let quad = self.candidates[level.at].quad;
            level.at += 1;
            self.bench.remove_quad(quad, self.mesh);
        }
        self.reached[root as usize] = false;
    }

    /// Make room in the tables for one more patch.
    fn reserve(&mut self) {
        let slots = self.built.keys.len();
        if !has_slot(self.n_built, slots) {
            if slots < self.census.most {
                self.built.double();
            } else {
                self.built.keys.fill([0, 0]);
                self.n_built = 0;
            }
        }
        self.census.reserve(4 * self.limit);
    }

    /// Add a candidate to the patch of `d` quads; count what results if it is a disk.
    fn add(&mut self, d: usize, Candidate { quad, entry }: Candidate) {
        self.levels[d].entered = entry;
        let below = self.levels[d];
        let build = self.hash_build(d, quad, entry);
        let hash = toggle(below.hash, self.mesh.zobrist[quad as usize]);
        let euler = below.euler + self.bench.add_quad(quad, d, self.mesh);
        let n = d + 1;
        // The level of the largest patches has no candidates.
        let above = &mut self.levels[n];
        above.build = build;
        above.hash = hash;
        above.euler = euler;
        if euler == 1 {
            self.total += 1;
            self.pulse.count();
            // The size belongs to the hash, since a lone quad joins nothing.
            let value = self.recognise(n, [build[0].wrapping_add(n as u64), build[1]]);
            self.census.count_patch(value);
            let quads = &self.bench.quads[..n];
            self.census.propose_example(value >> 1, hash, quads);
        }
    }

    /// Return the hash of how the patch of `d` quads and one more quad, entered by edge `entry`, are
    /// built.
    fn hash_build(&self, d: usize, quad: i32, entry: i32) -> Key {
        let across = self.mesh.twin[quad as usize];
        let mut build = self.levels[d].build;
        for r in 0..4 {
            let t = across[((entry + r) & 3) as usize];
            if t < 0 {
                continue;
            }
            let other = self.bench.member[(t >> 2) as usize];
            if other < 0 {
                continue;
            }
            let other = other as usize;
            let edge = ((t & 3) - self.levels[other].entered) & 3;
            let how = ((d * self.limit + other) as u64 * 4 + r as u64) * 4 + edge as u64;
            let x = mix((how + 1).wrapping_mul(GOLDEN));
            build = toggle(build, [x, mix(x ^ 0xA076_1D64_78BD_642F)]);
        }
        build
    }

    /// Return 2 * row + handedness of the pattern of the patch of `n` quads that was built so.
    fn recognise(&mut self, n: usize, build: Key) -> i32 {
        let slot = match self.built.get(build) {
            Ok(value) => return value,
            Err(slot) => slot,
        };
        let mut n_border = 0;
        let twin = self.bench.twin[..n].as_flattened().iter();
        for (h, _) in twin.enumerate().filter(|(_, t)| **t < 0) {
            self.bench.work.border[n_border] = h as i32;
            n_border += 1;
        }
        let value = self.census.recognise(n, n_border, self.mesh, self.bench);
        self.built.set(slot, build, value);
        self.n_built += 1;
        value
    }

    /// List the candidates of the patch of `d + 1` quads: the rest of those of the patch of `d`
    /// quads, and new neighbours of its last quad that are larger than the root.
    fn list_candidates(&mut self, d: usize, root: i32) {
        let Level { at, mut end, .. } = self.levels[d];
        let last = self.candidates[at].quad as usize;
        for t in self.mesh.twin[last] {
            if t < 0 {
                continue;
            }
            let (quad, entry) = (t >> 2, t & 3);
            if quad > root && !self.reached[quad as usize] {
                self.reached[quad as usize] = true;
                self.candidates[end] = Candidate { quad, entry };
                end += 1;
            }
        }
        self.levels[d + 1].at = at + 1;
        self.levels[d + 1].end = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BenchArrays, Grid, small_census};
    use std::sync::atomic::{AtomicI64, Ordering};

    #[test]
    fn every_connected_set_of_four_quads_is_a_patch() {
        let grid = Grid::new(2, 2);
        let mesh = grid.mesh();
        let mut arrays = BenchArrays::new(&mesh, 4);
        let mut bench = arrays.bench();
        let mut used = [0; 4];
        let mut census = small_census(&mut used);
        let (stop, met) = (AtomicI64::new(0), AtomicI64::new(0));
        let mut pulse = Pulse::new(&stop, &met);
        let total = count_basic(0..4, 4, &mesh, &mut bench, &mut census, &mut pulse);
        drop(pulse);
        // Four quads, four pairs, four corners of three, and the square.
        assert_eq!((total, met.load(Ordering::Relaxed)), (13, 13));
        assert!(bench.member.iter().all(|&place| place == -1));
        assert!(bench.held.iter().all(|&held| held == 0));
        // Only three quads about a reflex corner do not reduce to one quad.
        let patches: Vec<i64> = census.patches[..2]
            .iter()
            .map(|of| of.iter().sum())
            .collect();
        assert_eq!(patches, [9, 4]);
        assert_eq!(census.sides[..2], [4, 6]);
        assert_eq!(census.example_size[..2], [1, 3]);
        assert_eq!(census.used[0], 2);
    }

    #[test]
    fn a_search_that_is_stopped_counts_nothing() {
        let grid = Grid::new(2, 2);
        let mesh = grid.mesh();
        let mut arrays = BenchArrays::new(&mesh, 4);
        let mut bench = arrays.bench();
        let mut used = [0; 4];
        let mut census = small_census(&mut used);
        let (stop, met) = (AtomicI64::new(1), AtomicI64::new(0));
        let mut pulse = Pulse::new(&stop, &met);
        let total = count_basic(0..4, 4, &mesh, &mut bench, &mut census, &mut pulse);
        assert_eq!(total, 0);
    }
}
