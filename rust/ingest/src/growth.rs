//! Growth by whole sides: the *side* and *convex* modes of enumeration.
//!
//! From every quad, all quads beyond one whole side of the patch are added at once, and so on; in
//! the convex mode the quads around reflex corners follow until none is left. Patches are reached
//! along many ways, so those met are remembered by a hash of their quads, and the search goes
//! depth-first: a patch is grown on from the state it was reached in.
//!
//! Source: Marcias et al. 2015, section 3.2 ("Patch enumeration", "Managing duplicates"). Differs
//! from the paper: it hashes the boundary vertices, which on a closed mesh are those of the
//! patch's complement, too; here the quads are hashed.

use patterndb_core::halfedge::next_edge;

use crate::census::{Bench, Census, KernelMesh};
use crate::hashing::{Key, double_set, find, has_slot, toggle};
use crate::pulse::Pulse;

/// Slots with which the set of patches met begins.
const FIRST_SLOTS: usize = 1 << 12;

/// Which patches grow, and which of them are counted.
#[derive(Clone, Copy)]
pub struct Growth<'a> {
    /// Most quads of a patch.
    pub limit: usize,
    /// Whether reflex corners are filled.
    pub convex: bool,
    /// Patches of at most this number of quads were counted by another mode already; they are grown
    /// on, and counted in the total, but not in the census.
    pub smaller: usize,
    /// Set of hashes of patches counted by another mode.
    pub others: &'a [Key],
    /// Shard of every quad. A patch that reaches into another shard than its root's may be found
    /// from there too, so it is not counted but returned.
    pub shard: &'a [i32],
}

/// What grew from the roots.
pub struct Grown {
    /// Number of patches counted.
    pub total: i64,
    /// Set of all hashes met.
    pub met: Vec<Key>,
    /// Hashes of the patches that reach into other shards.
    pub far_hash: Vec<Key>,
    /// 2 * row + handedness of those patches, -1 where another mode counts them.
    pub far_value: Vec<i32>,
}

/// Count all patches that grow from the roots.
pub fn grow<'a>(
    roots: &[i32],
    growth: Growth<'a>,
    mesh: &KernelMesh<'a>,
    bench: &mut Bench<'a>,
    census: &mut Census<'a>,
    pulse: &mut Pulse<'a>,
) -> Grown {
    let mut search = Search {
        frames: vec![Frame::default(); growth.limit + 2],
        growth,
        mesh,
        bench,
        census,
        pulse,
        border: Vec::new(),
        corners: Vec::new(),
        mark: vec![0; mesh.zobrist.len()],
        stamp: 0,
        n_met: 0,
        grown: Grown {
            total: 0,
            met: vec![[0, 0]; FIRST_SLOTS],
            far_hash: Vec::new(),
            far_value: Vec::new(),
        },
    };
    for &root in roots {
        if search.pulse.is_stopped() {
            break;
        }
        search.grow_from(root);
    }
    search.grown
}

/// A connected set of quads: the first `size` of the bench.
#[derive(Clone, Copy, Default)]
struct Patch {
    size: usize,
    /// V - E + F.
    euler: i32,
    /// Number of quads of other shards than the root's.
    foreign: i32,
    hash: Key,
}

/// A patch on the way to the one at hand; frame 0 is the empty one.
#[derive(Clone, Copy, Default)]
struct Frame {
    patch: Patch,
    /// 2 * row + handedness, if known.
    pattern: Option<i32>,
    /// The next side to grow beyond.
    side: usize,
    /// Where its boundary ends in `border`, after that of the frame below.
    border_end: usize,
    /// Where the places of its corners on the boundary end in `corners`.
    corner_end: usize,
}

struct Search<'s, 'a> {
    growth: Growth<'a>,
    mesh: &'s KernelMesh<'a>,
    bench: &'s mut Bench<'a>,
    census: &'s mut Census<'a>,
    pulse: &'s mut Pulse<'a>,
    frames: Vec<Frame>,
    border: Vec<i32>,
    corners: Vec<i32>,
    /// For each quad the number of the last strip looked at that has it.
    mark: Vec<u64>,
    stamp: u64,
    n_met: i64,
    grown: Grown,
}

impl Search<'_, '_> {
    /// Grow all patches from one quad.
    fn grow_from(&mut self, root: i32) {
        let home = self.growth.shard[root as usize];
        self.frames[1].patch = Patch {
            size: 1,
            euler: self.bench.add_quad(root, 0, self.mesh),
            foreign: 0,
            hash: self.mesh.zobrist[root as usize],
        };
        self.frames[1].pattern = None;
        let mut d = 0;
        let mut has_candidate = true;
        while !self.pulse.is_stopped() {
            // A candidate is the patch of frame d + 1: keep it or take it back.
            if has_candidate {
                self.reserve();
                if self.is_new_patch(d + 1) {
                    d += 1;
                    self.keep(d);
                } else {
                    self.take_back(d + 1);
                    if d == 0 {
                        break;
                    }
                }
            }
            let n_corners = self.frames[d].corner_end - self.frames[d - 1].corner_end;
            if self.frames[d].side < n_corners.max(1) {
                has_candidate = self.grow_side(d, n_corners, home);
            } else {
                has_candidate = false;
                self.take_back(d);
                d -= 1;
                if d == 0 {
                    break;
                }
            }
        }
    }

    /// Take the quads of frame d that the frame below does not have out of the patch.
    fn take_back(&mut self, d: usize) {
        let (first, end) = (self.frames[d - 1].patch.size, self.frames[d].patch.size);
        self.bench.remove_from(first, end, self.mesh);
    }

    /// Make room in the tables for one more patch.
    fn reserve(&mut self) {
        if !has_slot(self.n_met, self.grown.met.len()) {
            self.grown.met = double_set(&self.grown.met);
        }
        self.census.reserve(4 * self.growth.limit);
    }

    /// Note the patch of frame d if it is a disk; return whether it is one, and not met before.
    fn is_new_patch(&mut self, d: usize) -> bool {
        let Patch { euler, hash, .. } = self.frames[d].patch;
        if euler != 1 {
            return false;
        }
        let Err(slot) = find(&self.grown.met, hash) else {
            return false;
        };
        self.grown.met[slot] = hash;
        self.n_met += 1;
        self.pulse.count();
        true
    }

    /// Count the patch of frame d, and make the frame ready to grow on.
    fn keep(&mut self, d: usize) {
        let Growth {
            limit,
            smaller,
            others,
            ..
        } = self.growth;
        let Patch {
            size,
            foreign,
            hash,
            ..
        } = self.frames[d].patch;
        let is_alone = foreign == 0;
        let is_counted = size > smaller && !(is_alone && find(others, hash).is_ok());
        self.frames[d].side = 0;
        if size < limit || is_counted && self.frames[d].pattern.is_none() {
            self.walk_boundary(d);
        }
        let mut value = -1;
        if is_counted {
            value = match self.frames[d].pattern {
                Some(value) => value,
                None => self.recognise(d),
            };
            self.frames[d].pattern = Some(value);
            let quads = &self.bench.quads[..size];
            self.census.propose_example(value >> 1, hash, quads);
            if is_alone {
                self.census.count_patch(value);
            }
        }
        if is_alone {
            self.grown.total += 1;
        } else {
            self.grown.far_hash.push(hash);
            self.grown.far_value.push(value);
        }
        if size == limit {
            // It has no side to grow beyond.
            self.frames[d].side = 1;
            self.frames[d].border_end = self.frames[d - 1].border_end;
            self.frames[d].corner_end = self.frames[d - 1].corner_end;
        }
    }

    /// Return the boundary of the patch of frame d.
    fn boundary(&self, d: usize) -> &[i32] {
        &self.border[self.frames[d - 1].border_end..self.frames[d].border_end]
    }

    /// Return 2 * row + handedness of the pattern of the patch of frame d.
    fn recognise(&mut self, d: usize) -> i32 {
        let (first, end) = (self.frames[d - 1].border_end, self.frames[d].border_end);
        let boundary = &self.border[first..end];
        for (own, &h) in self.bench.work.border.iter_mut().zip(boundary) {
            *own = 4 * self.bench.member[(h >> 2) as usize] + (h & 3);
        }
        let size = self.frames[d].patch.size;
        let n_border = boundary.len();
        self.census.recognise(size, n_border, self.mesh, self.bench)
    }

    /// Add the quads beyond the next side of the patch of frame d, as the candidate of frame d + 1;
    /// return whether there is one.
    fn grow_side(&mut self, d: usize, n_corners: usize, home: i32) -> bool {
        let side = self.frames[d].side;
        self.frames[d].side += 1;
        let below = self.frames[d - 1];
        let perimeter = self.frames[d].border_end - below.border_end;
        let corners = &self.corners[below.corner_end..self.frames[d].corner_end];
        let begin = corners.get(side).map_or(0, |&at| at as usize);
        let length = match (corners.get(side + 1), corners.first()) {
            (Some(&next), _) => next as usize - begin,
            (None, Some(&first)) => first as usize + perimeter - begin,
            (None, None) => perimeter,
        };
        if !self.may_grow(d, begin, length) {
            return false;
        }
        let grown_from = self.frames[d];
        let mut patch = grown_from.patch;
        let first = below.border_end;
        for i in 0..length {
            let h = self.border[first + wrapped(begin + i, perimeter)];
            let q = self.mesh.across(h) >> 2;
            if self.bench.member[q as usize] < 0 {
                self.add(q, home, &mut patch);
            }
        }
        let added = patch.size - grown_from.patch.size;
        if self.growth.convex && !self.mend_reflex(grown_from.patch.size, home, &mut patch) {
            let (first, end) = (grown_from.patch.size, patch.size);
            self.bench.remove_from(first, end, self.mesh);
            return false;
        }
        // A strip with nothing else, grown over a chain that dissolves, leaves the pattern.
        let is_strip = added == length
            && patch.size == grown_from.patch.size + added
            && n_corners != 1
            && self.runs_straight(d, begin, length, n_corners == 0);
        self.frames[d + 1].patch = patch;
        self.frames[d + 1].pattern = grown_from.pattern.filter(|_| is_strip);
        true
    }

    /// Return whether there is a quad beyond every edge of a side, they are few enough, and the patch
    /// with them was not met before.
    ///
    /// Patches are met only when they are convex, so none around reflex corners is missed.
    fn may_grow(&mut self, d: usize, begin: usize, length: usize) -> bool {
        self.stamp += 1;
        let Patch { size, mut hash, .. } = self.frames[d].patch;
        let mut room = self.growth.limit - size;
        let boundary = &self.border[self.frames[d - 1].border_end..self.frames[d].border_end];
        for i in 0..length {
            let t = self
                .mesh
                .across(boundary[wrapped(begin + i, boundary.len())]);
            if t < 0 {
                return false;
            }
            let q = (t >> 2) as usize;
            if self.mark[q] != self.stamp {
                self.mark[q] = self.stamp;
                hash = toggle(hash, self.mesh.zobrist[q]);
                if room == 0 {
                    return false;
                }
                room -= 1;
            }
        }
        find(&self.grown.met, hash).is_err()
    }

    /// Add a quad to a patch.
    fn add(&mut self, q: i32, home: i32, patch: &mut Patch) {
        patch.euler += self.bench.add_quad(q, patch.size, self.mesh);
        patch.foreign += i32::from(self.growth.shard[q as usize] != home);
        patch.hash = toggle(patch.hash, self.mesh.zobrist[q as usize]);
        patch.size += 1;
    }

    /// Add the quads around reflex corners until there is none; only vertices of the quads from
    /// place `first_new` on can be one.
    ///
    /// Returns false where a reflex corner lies on the mesh's border, or the patch would have more
    /// quads than the limit.
    fn mend_reflex(&mut self, first_new: usize, home: i32, patch: &mut Patch) -> bool {
        let mesh = self.mesh;
        let mut i = first_new;
        while i < patch.size {
            for v in self.bench.vertex[i] {
                let v = v as usize;
                let held = self.bench.held[v];
                if held < 3 || held == mesh.full[v] {
                    continue;
                }
                let missing = (mesh.valence[v] - held) as usize;
                if mesh.full[v] != mesh.valence[v] || patch.size + missing > self.growth.limit {
                    return false;
                }
                let star = mesh.star_start[v] as usize..mesh.star_start[v + 1] as usize;
                for &q in &mesh.star[star] {
                    if self.bench.member[q as usize] < 0 {
                        self.add(q, home, patch);
                    }
                }
            }
            i += 1;
        }
        true
    }

    /// Return whether a side of the boundary of frame d, which the patch has grown over, is now a
    /// chain through vertices of valence 4, closed or between flat boundary vertices, and the strip
    /// that grew over it is open along its far side.
    fn runs_straight(&self, d: usize, begin: usize, length: usize, is_closed: bool) -> bool {
        let (mesh, bench) = (self.mesh, &*self.bench);
        let boundary = self.boundary(d);
        let is_flat = |v: usize| bench.held[v] == 2 && mesh.full[v] != 2;
        for i in 0..length {
            let h = boundary[wrapped(begin + i, boundary.len())];
            let v = mesh.tail(h);
            // Where the far sides of the strip's quads are one edge (about a vertex of valence 2),
            // collapsing the strip folds the old side just so, and the pattern is another.
            if bench.has_beyond(mesh.across(mesh.across(h) ^ 2)) {
                return false;
            }
            if i == 0 && !is_closed {
                let end = boundary[wrapped(begin + length, boundary.len())];
                if !is_flat(v) || !is_flat(mesh.tail(end)) {
                    return false;
                }
            } else if bench.held[v] != 4 || mesh.full[v] != 4 {
                return false;
            }
        }
        true
    }

    /// Write the boundary of the patch of frame d, and where its corners lie on it, after those of
    /// the frame below.
    fn walk_boundary(&mut self, d: usize) {
        let (mesh, bench) = (self.mesh, &*self.bench);
        let is_border = |h: i32| !bench.has_beyond(mesh.across(h));
        let quads = bench.quads[..self.frames[d].patch.size].iter().rev();
        let first = quads
            .flat_map(|&q| 4 * q..4 * q + 4)
            .find(|&h| is_border(h))
            .expect("a disk has a border");
        let below = self.frames[d - 1];
        self.border.truncate(below.border_end);
        self.corners.truncate(below.corner_end);
        let mut h = first;
        loop {
            if bench.held[mesh.tail(h)] != 2 {
                let place = self.border.len() - below.border_end;
                self.corners.push(place as i32);
            }
            self.border.push(h);
            h = next_edge(h);
            while !is_border(h) {
                h = next_edge(mesh.across(h));
            }
            if h == first {
                break;
            }
        }
        self.frames[d].border_end = self.border.len();
        self.frames[d].corner_end = self.corners.len();
    }
}

/// Return a place on a boundary that may lie once round too far (no division).
#[inline]
fn wrapped(place: usize, perimeter: usize) -> usize {
    if place < perimeter {
        place
    } else {
        place - perimeter
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BenchArrays, Grid, small_census};
    use std::sync::atomic::AtomicI64;

    /// Grow from all quads of shard 0; return what grew and the patches of each row.
    fn grow_on(grid: &Grid, convex: bool, limit: usize, shard: &[i32]) -> (Grown, Vec<[i64; 2]>) {
        let mesh = grid.mesh();
        let mut arrays = BenchArrays::new(&mesh, limit);
        let mut bench = arrays.bench();
        let mut used = [0; 4];
        let mut census = small_census(&mut used);
        let (stop, met) = (AtomicI64::new(0), AtomicI64::new(0));
        let growth = Growth {
            limit,
            convex,
            smaller: 0,
            others: &[[0, 0]],
            shard,
        };
        let roots: Vec<i32> = (0..shard.len() as i32)
            .filter(|&quad| shard[quad as usize] == 0)
            .collect();
        let mut pulse = Pulse::new(&stop, &met);
        let grown = grow(&roots, growth, &mesh, &mut bench, &mut census, &mut pulse);
        assert!(bench.member.iter().all(|&place| place == -1));
        let rows = census.used[0] as usize;
        (grown, census.patches[..rows].to_vec())
    }

    #[test]
    fn rectangles_grow_on_a_grid() {
        let grid = Grid::new(3, 3);
        for convex in [false, true] {
            let (grown, patches) = grow_on(&grid, convex, 9, &[0; 9]);
            // Choose two of four lines in each direction.
            assert_eq!(grown.total, 36);
            assert_eq!(patches, [[36, 0]]);
            assert!(grown.far_hash.is_empty());
        }
    }

    #[test]
    fn patches_that_reach_into_another_shard_are_returned() {
        let grid = Grid::new(1, 3);
        let (grown, patches) = grow_on(&grid, false, 3, &[0, 0, 1]);
        // Two quads and their pair; two of the pairs and the three reach into the other shard.
        assert_eq!((grown.total, patches), (3, vec![[3, 0]]));
        assert_eq!(grown.far_value, [0, 0]);
    }
}
