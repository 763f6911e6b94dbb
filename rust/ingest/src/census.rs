//! The census: which pattern a patch reduces to, and how often each pattern was met.
//!
//! A patch is reduced, read as a code from one of its corners, and looked up; only a reading never
//! met before is turned into the canonical code. So the common case costs one reduction, one
//! breadth-first reading and one look-up.

use std::cmp::Ordering;

use patterndb_core::code::{Reading, Sense, rooted_code, smallest_code};
use patterndb_core::halfedge::border_vertices;
use patterndb_core::reduction::{
    Disk, NEVER_FULL, ReductionWork, cut_blocks, mark_chains, read_pattern,
};

use crate::hashing::{Key, KeyMap, Table, has_slot, hash_symbols};

/// Most bytes that a symbol of 16 bits takes when it is packed.
const SYMBOL_BYTES: usize = 3;

/// What a search reads of a quad mesh.
#[derive(Clone, Copy)]
pub struct KernelMesh<'a> {
    /// Half-edges of each quad.
    pub twin: &'a [[i32; 4]],
    /// Vertices of each quad.
    pub vertex: &'a [[i32; 4]],
    /// Number of quads at each vertex.
    pub valence: &'a [i32],
    /// Number of quads that makes a vertex interior, [`NEVER_FULL`] on the border.
    pub full: &'a [i32],
    /// The quads at vertex v are `star[star_start[v]..star_start[v + 1]]`.
    pub star_start: &'a [i32],
    /// Quads at vertices, one vertex after the other.
    pub star: &'a [i32],
    /// Random number of each quad.
    pub zobrist: &'a [Key],
}

impl KernelMesh<'_> {
    /// Return the half-edge across from half-edge `h`, -1 on the border.
    #[inline]
    pub fn across(&self, h: i32) -> i32 {
        self.twin[(h >> 2) as usize][(h & 3) as usize]
    }

    /// Return the vertex where half-edge `h` begins.
    #[inline]
    pub fn tail(&self, h: i32) -> usize {
        self.vertex[(h >> 2) as usize][(h & 3) as usize] as usize
    }
}

/// The arrays of a [`KernelMesh`] that follow from half-edges and vertices.
pub struct Stars {
    /// [`KernelMesh::valence`].
    pub valence: Vec<i32>,
    /// [`KernelMesh::full`].
    pub full: Vec<i32>,
    /// [`KernelMesh::star_start`].
    pub star_start: Vec<i32>,
    /// [`KernelMesh::star`].
    pub star: Vec<i32>,
}

/// List the quads at each vertex of a mesh.
pub fn list_stars(twin: &[i32], vertex: &[i32], n_vertices: usize) -> Stars {
    let mut valence = vec![0; n_vertices];
    for &v in vertex {
        valence[v as usize] += 1;
    }
    let mut star_start = vec![0; n_vertices + 1];
    for v in 0..n_vertices {
        star_start[v + 1] = star_start[v] + valence[v];
    }
    let mut at = star_start.clone();
    let mut star = vec![0; vertex.len()];
    for (h, &v) in vertex.iter().enumerate() {
        let place = &mut at[v as usize];
        star[*place as usize] = (h >> 2) as i32;
        *place += 1;
    }
    let border = border_vertices(twin, vertex, n_vertices);
    let full = valence.iter().zip(border);
    let full = full.map(|(&n, border)| if border { NEVER_FULL } else { n });
    Stars {
        full: full.collect(),
        valence,
        star_start,
        star,
    }
}

/// The patch at hand, and scratch for recognising it, for one mesh.
///
/// [`Bench::add_quad`] and [`Bench::remove_quad`] keep all up to date but the scratch: `code`,
/// `reading` and `work`.
pub struct Bench<'a> {
    /// Place of each quad of the mesh in the patch, -1 outside.
    pub member: &'a mut [i32],
    /// The patch's quads at each vertex of the mesh.
    pub held: &'a mut [i32],
    /// The patch: quads of the mesh.
    pub quads: &'a mut [i32],
    /// Half-edges of the patch on its own.
    pub twin: &'a mut [[i32; 4]],
    /// Vertices of the patch's quads.
    pub vertex: &'a mut [[i32; 4]],
    /// Sum of 4 - valence over the patch's interior vertices of valence 1 to 3.
    pub curvature: &'a mut i64,
    /// A code.
    pub code: &'a mut [u16],
    /// Scratch of the reading of codes.
    pub reading: Reading<'a>,
    /// Scratch of the reduction.
    pub work: ReductionWork<'a>,
}

impl Bench<'_> {
    /// Put quad `q` into the patch at `place`; return the change of V - E + F.
    ///
    /// A non-empty patch that stays edge-connected is a disk exactly if its V - E + F is 1: a vertex
    /// that its boundary visits twice, a hole or a handle would make it smaller, and only a closed
    /// surface has more.
    pub fn add_quad(&mut self, q: i32, place: usize, mesh: &KernelMesh) -> i32 {
        let corners = mesh.vertex[q as usize];
        let across = mesh.twin[q as usize];
        let mut joined = [-1; 4];
        let mut change = -3;
        for e in 0..4 {
            let v = corners[e] as usize;
            let held = self.held[v] + 1;
            self.held[v] = held;
            change += i32::from(held == 1);
            if held < 4 && held == mesh.full[v] {
                *self.curvature += i64::from(4 - held);
            }
            if across[e] < 0 {
                continue;
            }
            let other = self.member[(across[e] >> 2) as usize];
            if other >= 0 {
                change += 1;
                let edge = across[e] & 3;
                joined[e] = 4 * other + edge;
                self.twin[other as usize][edge as usize] = (4 * place + e) as i32;
            }
        }
        self.twin[place] = joined;
        self.vertex[place] = corners;
        self.member[q as usize] = place as i32;
        self.quads[place] = q;
        change
    }

    /// Take quad `q`, the last one added, out of the patch.
    pub fn remove_quad(&mut self, q: i32, mesh: &KernelMesh) {
        let place = self.member[q as usize] as usize;
        self.member[q as usize] = -1;
        let corners = self.vertex[place];
        for v in corners {
            let v = v as usize;
            let held = self.held[v];
            self.held[v] = held - 1;
            if held < 4 && held == mesh.full[v] {
                *self.curvature -= i64::from(4 - held);
            }
        }
        for t in self.twin[place] {
            if t >= 0 {
                self.twin[(t >> 2) as usize][(t & 3) as usize] = -1;
            }
        }
    }

    /// Take the patch's quads from place `first` on, up to `end`, out of it, the last first.
    pub fn remove_from(&mut self, first: usize, end: usize, mesh: &KernelMesh) {
        for place in (first..end).rev() {
            self.remove_quad(self.quads[place], mesh);
        }
    }

    /// Return whether a half-edge of the mesh leads into the patch.
    #[inline]
    pub fn has_beyond(&self, across: i32) -> bool {
        across >= 0 && self.member[(across >> 2) as usize] >= 0
    }

    /// Read the pattern of the patch's first `n` quads from one of its corners into `code`; return
    /// its number of quads.
    ///
    /// `work.border[..n_border]` are the half-edges of the patch's border.
    fn read(&mut self, n: usize, n_border: usize, mesh: &KernelMesh) -> usize {
        let disk = Disk {
            twin: self.twin[..n].as_flattened(),
            vertex: self.vertex[..n].as_flattened(),
            count: self.held,
            full: mesh.full,
        };
        mark_chains(disk, n_border, *self.curvature, &mut self.work);
        // From a corner; without one, from the first vertex of the border that stays.
        let removed = self.work.stamp[0];
        let mut start = None;
        for &h in &self.work.border[..n_border] {
            let v = disk.vertex[h as usize] as usize;
            if disk.count[v] != 2 {
                start = Some(h);
                break;
            }
            if start.is_none() && self.work.gone[v] != removed {
                start = Some(h);
            }
        }
        read_pattern(start, disk, self.code, &mut self.work)
    }

    /// Write the canonical code of the patch's pattern to `code`, after [`Bench::read`]; return its
    /// numbers of quads and sides, and whether the patch is the mirror image of the code.
    fn write_canonical(&mut self, n: usize, mesh: &KernelMesh) -> (usize, i32, bool) {
        let disk = Disk {
            twin: self.twin[..n].as_flattened(),
            vertex: self.vertex[..n].as_flattened(),
            count: self.held,
            full: mesh.full,
        };
        let (m, n_starts) = cut_blocks(disk, &mut self.work);
        let reduced = &self.work.reduced[..4 * m];
        let starts = &self.work.starts[..n_starts];
        let (code, reading) = (&mut *self.code, &mut self.reading);
        smallest_code(reduced, m, starts, Sense::CounterClockwise, code, reading);
        let mut mirrored = false;
        for &start in starts {
            let h = Sense::Clockwise.start(reduced, start);
            let state = rooted_code(reduced, m, h, Sense::Clockwise, code, reading, true);
            mirrored |= state == Ordering::Less;
        }
        let first = disk.vertex[self.work.head[starts[0] as usize] as usize];
        let is_corner = disk.count[first as usize] != 2;
        (m, if is_corner { n_starts as i32 } else { 0 }, mirrored)
    }
}

/// How much of a census is in use, by the places of `Census::used`.
mod used {
    pub const ROWS: usize = 0;
    pub const BYTES: usize = 1;
    pub const READINGS: usize = 2;
    pub const EXAMPLE_QUADS: usize = 3;
}

/// Patterns met so far; row r is one pattern.
pub struct Census<'a> {
    /// Rows; bytes of `codes`; keys of `readings`; quads of `example`.
    pub used: &'a mut [i64],
    /// Slots that a map gets at most which only saves work: when it is full it begins from empty.
    pub most: usize,
    /// Map from the hash of a reading to 2 * row + handedness; handedness 1 means that the patch is
    /// the mirror image of the row's code.
    pub readings: KeyMap<'a>,
    /// Map from the hash of a canonical code to its row.
    pub rows: KeyMap<'a>,
    /// Canonical codes, packed; row r is `codes[ends[r]..ends[r + 1]]`.
    pub codes: Table<'a, u8>,
    /// Where each code ends, after a 0.
    pub ends: Table<'a, i64>,
    /// Number of sides of each row.
    pub sides: Table<'a, i32>,
    /// Patches of each row, by handedness.
    pub patches: Table<'a, [i64; 2]>,
    /// Quads of the example of each row: the patch with the fewest quads, then the smallest hash, so
    /// that it does not depend on the order in which patches come.
    pub example_size: Table<'a, i32>,
    /// Hash of the example of each row.
    pub example_hash: Table<'a, Key>,
    /// Place in `example` of the example of each row.
    pub example_at: Table<'a, i64>,
    /// Quads of the examples.
    pub example: Table<'a, i32>,
}

impl Census<'_> {
    /// Make room for one more reading, and one more row of `n_symbols` symbols with its example.
    #[inline]
    pub fn reserve(&mut self, n_symbols: usize) {
        let used = &*self.used;
        let has_room = has_slot(used[used::READINGS], self.readings.keys.len())
            && has_slot(used[used::ROWS], self.rows.keys.len())
            && used[used::BYTES] as usize + SYMBOL_BYTES * n_symbols <= self.codes.len()
            && (used[used::ROWS] as usize) < self.patches.len()
            && used[used::EXAMPLE_QUADS] as usize + n_symbols / 4 <= self.example.len();
        if !has_room {
            self.grow(n_symbols);
        }
    }

    #[cold]
    fn grow(&mut self, n_symbols: usize) {
        let in_use = |what: usize| self.used[what] as usize;
        let (n_bytes, n_example) = (in_use(used::BYTES), in_use(used::EXAMPLE_QUADS));
        if !has_slot(self.used[used::READINGS], self.readings.keys.len()) {
            if self.readings.keys.len() < self.most {
                self.readings.double();
            } else {
                // Rows keep their codes, so that a reading that is forgotten finds its row again.
                self.readings.keys.fill([0, 0]);
                self.used[used::READINGS] = 0;
            }
        }
        if !has_slot(self.used[used::ROWS], self.rows.keys.len()) {
            self.rows.double();
        }
        let n = self.codes.len();
        if n_bytes + SYMBOL_BYTES * n_symbols > n {
            self.codes
                .lengthen(n_bytes, 2 * n + SYMBOL_BYTES * n_symbols);
        }
        let n = self.example.len();
        if n_example + n_symbols / 4 > n {
            self.example.lengthen(n_example, 2 * n + n_symbols / 4);
        }
        let n = self.patches.len();
        if self.used[used::ROWS] as usize == n {
            self.ends.lengthen(n + 1, 2 * n + 1);
            self.sides.lengthen(n, 2 * n);
            self.patches.lengthen(n, 2 * n);
            self.example_size.lengthen(n, 2 * n);
            self.example_hash.lengthen(n, 2 * n);
            self.example_at.lengthen(n, 2 * n);
        }
    }

    /// Return 2 * row + handedness of the pattern of the patch of the bench's first `n` quads, which
    /// must be a disk. There must be room for it ([`Census::reserve`]).
    ///
    /// `bench.work.border[..n_border]` are the half-edges of the patch's border.
    pub fn recognise(
        &mut self,
        n: usize,
        n_border: usize,
        mesh: &KernelMesh,
        bench: &mut Bench,
    ) -> i32 {
        let m = bench.read(n, n_border, mesh);
        match self.readings.get(hash_symbols(&bench.code[..4 * m])) {
            Ok(value) => value,
            Err(_) => self.add_reading(n, n_border, mesh, bench),
        }
    }

    /// Note a reading that is not known, and its pattern if that is new; return as
    /// [`Census::recognise`].
    #[cold]
    fn add_reading(
        &mut self,
        n: usize,
        n_border: usize,
        mesh: &KernelMesh,
        bench: &mut Bench,
    ) -> i32 {
        let m = bench.read(n, n_border, mesh);
        let reading = hash_symbols(&bench.code[..4 * m]);
        let (m, sides, mirrored) = bench.write_canonical(n, mesh);
        let value = 2 * self.row_of(&bench.code[..4 * m], sides) + i32::from(mirrored);
        if let Err(slot) = self.readings.get(reading) {
            self.readings.set(slot, reading, value);
            self.used[used::READINGS] += 1;
        }
        value
    }

    /// Return the row of a canonical code, a new one if there is none.
    fn row_of(&mut self, code: &[u16], sides: i32) -> i32 {
        let key = hash_symbols(code);
        let slot = match self.rows.get(key) {
            Ok(row) => return row,
            Err(slot) => slot,
        };
        let row = self.used[used::ROWS] as usize;
        let mut at = self.ends[row] as usize;
        for &symbol in code {
            let mut symbol = symbol;
            while symbol > 127 {
                self.codes[at] = (symbol & 127) as u8 | 128;
                symbol >>= 7;
                at += 1;
            }
            self.codes[at] = symbol as u8;
            at += 1;
        }
        self.ends[row + 1] = at as i64;
        self.sides[row] = sides;
        self.rows.set(slot, key, row as i32);
        self.used[used::ROWS] = row as i64 + 1;
        self.used[used::BYTES] = at as i64;
        row as i32
    }

    /// Count a patch of a pattern and handedness, as [`Census::recognise`] returns them.
    #[inline]
    pub fn count_patch(&mut self, value: i32) {
        self.patches[(value >> 1) as usize][(value & 1) as usize] += 1;
    }

    /// Let a patch with hash `hash` be the row's example if it is the first of its size or smaller
    /// than the one there.
    #[inline]
    pub fn propose_example(&mut self, row: i32, hash: Key, quads: &[i32]) {
        let row = row as usize;
        let size = self.example_size[row] as usize;
        let n = quads.len();
        if size != 0 && (size < n || size == n && self.example_hash[row] <= hash) {
            return;
        }
        if size == 0 {
            self.example_at[row] = self.used[used::EXAMPLE_QUADS];
            self.used[used::EXAMPLE_QUADS] += n as i64;
        }
        // A better one has no more quads than the first, and takes its place.
        let at = self.example_at[row] as usize;
        self.example_size[row] = n as i32;
        self.example_hash[row] = hash;
        self.example[at..at + n].copy_from_slice(quads);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BenchArrays, Grid, small_census};

    #[test]
    fn a_grid_has_stars_and_a_quad_that_goes_leaves_the_patch_as_it_was() {
        let grid = Grid::new(2, 2);
        let mesh = grid.mesh();
        let middle = mesh.valence.iter().position(|&n| n == 4);
        assert_eq!(mesh.full.iter().position(|&n| n != NEVER_FULL), middle);
        let mut arrays = BenchArrays::new(&mesh, 4);
        let mut bench = arrays.bench();
        let changes: Vec<i32> = (0..4)
            .map(|q| bench.add_quad(q, q as usize, &mesh))
            .collect();
        assert_eq!(changes, [1, 0, 0, 0]);
        assert_eq!(bench.twin[..4], mesh.twin[..]);
        bench.remove_from(1, 4, &mesh);
        assert_eq!(bench.twin[0], [-1; 4]);
        assert_eq!(bench.held.iter().sum::<i32>(), 4);
    }

    #[test]
    fn the_smaller_example_stays() {
        let mut used = [0; 4];
        let mut census = small_census(&mut used);
        census.reserve(16);
        for (hash, quads) in [
            ([3, 1], &[7, 8][..]),
            ([2, 9], &[5, 6]),
            ([2, 9], &[1, 2]),
            ([0, 0], &[1, 2, 3]),
        ] {
            census.propose_example(0, hash, quads);
        }
        assert_eq!(census.example[..2], [5, 6]);
        assert_eq!((census.example_size[0], census.used[3]), (2, 2));
    }
}
