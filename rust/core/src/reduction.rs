//! Reduction of a disk to its pattern, in one pass.
//!
//! Collapsing polychords until none may collapse leaves the same pattern as dissolving, all at once,
//! every edge chain that runs straight through interior vertices of valence 4, crosses itself
//! nowhere, and is closed or ends at flat boundary vertices. Dissolving is the faster of the two.
//!
//! Source: Marcias et al. 2015, section 3.2 ("Pattern reduction"). Differs from the paper: it asks
//! both chains of a polychord to be free of irregular vertices; one is enough (the polychord then
//! runs parallel to its neighbour on that side), and with two many patterns would be left half
//! reduced.
//!
//! Copies of a polychord that crosses itself cross themselves, so neither way takes one of them
//! away. [`dissolve_straight`] does: it undoes all that expansion does.

use crate::halfedge::{next_edge, prev_edge};

/// [`Disk::full`] of a vertex on the mesh's border, which no number of quads closes.
pub const NEVER_FULL: i32 = 1 << 30;

/// A disk of quads cut from a mesh.
#[derive(Clone, Copy)]
pub struct Disk<'a> {
    /// Half-edges of the disk.
    pub twin: &'a [i32],
    /// Vertex of the mesh at each of the disk's corners.
    pub vertex: &'a [i32],
    /// Number of the disk's quads at each vertex of the mesh.
    pub count: &'a [i32],
    /// The count at which a vertex is interior: its valence in the mesh, [`NEVER_FULL`] on the
    /// mesh's border.
    pub full: &'a [i32],
}

impl Disk<'_> {
    fn vertex(&self, h: i32) -> usize {
        self.vertex[h as usize] as usize
    }

    fn twin(&self, h: i32) -> i32 {
        self.twin[h as usize]
    }

    /// Return the half-edge that goes straight on where half-edge `h` ends: inside a regular mesh,
    /// the one opposite to `h` at its head.
    fn straight_on(&self, h: i32) -> i32 {
        next_edge(self.twin(next_edge(h)))
    }

    /// Return the half-edges of the disk's border.
    fn border(&self) -> impl Iterator<Item = i32> {
        let places = self.twin.iter().enumerate();
        places.filter(|(_, t)| **t < 0).map(|(h, _)| h as i32)
    }
}

/// Scratch and result of a reduction, made once for many patches of a mesh.
///
/// `gone` and `seen` have a place for each vertex of the mesh, the others four for each quad of the
/// largest patch.
pub struct ReductionWork<'a> {
    /// Equal to `stamp[0]` at the vertices that dissolve.
    pub gone: &'a mut [i64],
    /// Equal to `stamp[1]` at the vertices that the search at hand has seen.
    pub seen: &'a mut [i64],
    /// The last stamps used.
    pub stamp: &'a mut [i64],
    /// Half-edges of the disk's border.
    pub border: &'a mut [i32],
    /// Side of a block that begins with each half-edge of the disk; -1 between two calls.
    pub block: &'a mut [i32],
    /// First half-edge of each side of a block.
    pub head: &'a mut [i32],
    /// Half-edges of the pattern.
    pub reduced: &'a mut [i32],
    /// Half-edges that leave the pattern's corners.
    pub starts: &'a mut [i32],
}

impl ReductionWork<'_> {
    /// Take the next stamp of kind 0 (`gone`) or 1 (`seen`).
    fn next_stamp(&mut self, kind: usize) -> i64 {
        self.stamp[kind] += 1;
        self.stamp[kind]
    }

    /// Make the sides of the first blocks no block's again.
    fn clear_blocks(&mut self, n_blocks: usize) {
        for &h in &self.head[..4 * n_blocks] {
            self.block[h as usize] = -1;
        }
    }
}

/// Reduce a disk; return the numbers of quads and of starting half-edges of the pattern, which are
/// left in `work.reduced` and `work.starts`.
pub fn dissolve(disk: Disk, work: &mut ReductionWork) -> (usize, usize) {
    let mut n_border = 0;
    for h in disk.border() {
        work.border[n_border] = h;
        n_border += 1;
    }
    let mark = work.next_stamp(1);
    let mut curvature = 0;
    for &v in disk.vertex {
        let v = v as usize;
        if work.seen[v] != mark {
            work.seen[v] = mark;
            if disk.count[v] == disk.full[v] && disk.count[v] < 4 {
                curvature += 4 - i64::from(disk.count[v]);
            }
        }
    }
    mark_chains(disk, n_border, curvature, work);
    cut_blocks(disk, work)
}

/// Mark the vertices of a disk's chains that dissolve: `work.gone` is `work.stamp[0]` there.
///
/// `work.border[..n_border]` are the half-edges of the disk's border, and `curvature` is the sum of
/// 4 - valence over its interior vertices of valence 1 to 3.
pub fn mark_chains(disk: Disk, n_border: usize, curvature: i64, work: &mut ReductionWork) {
    let removed = work.next_stamp(0);
    for i in 0..n_border {
        let h = work.border[i];
        let v = disk.vertex(h);
        if disk.count[v] != 2 || work.gone[v] == removed {
            continue;
        }
        let first = disk.twin(prev_edge(h));
        if first >= 0 && joins_flat_vertices(disk, v, first, work) {
            mark_open_chain(disk, first, removed, work.gone);
        }
    }
    // A closed chain encloses, by Gauss-Bonnet, irregular vertices with a sum of 4 - valence of 4,
    // so most patches need no search.
    if curvature < 4 {
        return;
    }
    for h in 0..disk.twin.len() as i32 {
        if disk.twin(h) >= 0 && is_regular(disk, disk.vertex(h)) && is_closed_chain(disk, h, work) {
            let mut t = h;
            loop {
                work.gone[disk.vertex(t)] = removed;
                t = disk.straight_on(t);
                if t == h {
                    break;
                }
            }
        }
    }
}

fn is_regular(disk: Disk, v: usize) -> bool {
    disk.count[v] == 4 && disk.full[v] == 4
}

/// Return whether the chain from flat boundary vertex `v` along half-edge `first` runs straight to
/// another one, through no vertex twice.
fn joins_flat_vertices(disk: Disk, v: usize, first: i32, work: &mut ReductionWork) -> bool {
    let mark = work.next_stamp(1);
    work.seen[v] = mark;
    let mut t = first;
    loop {
        let w = disk.vertex(next_edge(t));
        if work.seen[w] == mark {
            return false;
        }
        work.seen[w] = mark;
        if disk.count[w] != disk.full[w] {
            return disk.count[w] == 2;
        }
        if disk.count[w] != 4 {
            return false;
        }
        t = disk.straight_on(t);
    }
}

/// Mark the vertices of a straight chain between two boundary vertices that begins with half-edge
/// `first`.
fn mark_open_chain(disk: Disk, first: i32, removed: i64, gone: &mut [i64]) {
    gone[disk.vertex(first)] = removed;
    let mut t = first;
    loop {
        let w = disk.vertex(next_edge(t));
        gone[w] = removed;
        if disk.count[w] != disk.full[w] {
            return;
        }
        t = disk.straight_on(t);
    }
}

/// Return whether the chain along inner half-edge `first` runs straight back to it, through no vertex
/// twice.
fn is_closed_chain(disk: Disk, first: i32, work: &mut ReductionWork) -> bool {
    let v = disk.vertex(first);
    let mark = work.next_stamp(1);
    let mut t = first;
    loop {
        let w = disk.vertex(next_edge(t));
        if w == v {
            return disk.straight_on(t) == first;
        }
        if work.seen[w] == mark || !is_regular(disk, w) {
            return false;
        }
        work.seen[w] = mark;
        t = disk.straight_on(t);
    }
}

/// Reduce a disk as [`dissolve`] does, and dissolve chains that cross themselves, too.
///
/// Expanding the pattern gives the disk back: on both sides of a straight chain lie copies of one
/// polychord, wherever it goes.
pub fn dissolve_straight(disk: Disk, work: &mut ReductionWork) -> (usize, usize) {
    let removed = work.next_stamp(0);
    // Half-edges inside from which a walk comes to no end, or to the border.
    let mut passed = vec![false; disk.twin.len()];
    for h in 0..disk.twin.len() as i32 {
        let v = disk.vertex(h);
        let is_open = disk.twin(h) < 0;
        let first = if is_open {
            if disk.count[v] == 2 {
                disk.twin(prev_edge(h))
            } else {
                -1
            }
        } else if disk.full[v] != NEVER_FULL && !passed[h as usize] {
            h
        } else {
            -1
        };
        if first >= 0 && runs_straight(disk, first, is_open, &mut passed) {
            mark_straight(disk, first, removed, work.gone);
        }
    }
    cut_blocks(disk, work)
}

/// Return whether the chain along half-edge `first` runs straight to a flat boundary vertex (if it is
/// open, and so begins at one) or back to `first`; note the half-edges inside that it passes.
fn runs_straight(disk: Disk, first: i32, is_open: bool, passed: &mut [bool]) -> bool {
    let mut t = first;
    loop {
        let w = disk.vertex(next_edge(t));
        if disk.full[w] == NEVER_FULL || disk.count[w] != 4 {
            return is_open && disk.full[w] == NEVER_FULL && disk.count[w] == 2;
        }
        passed[t as usize] = true;
        t = disk.straight_on(t);
        if !is_open && (t == first || passed[t as usize]) {
            return t == first;
        }
    }
}

/// Mark the vertices of a straight chain that ends at the border or closes.
fn mark_straight(disk: Disk, first: i32, removed: i64, gone: &mut [i64]) {
    gone[disk.vertex(first)] = removed;
    let mut t = first;
    loop {
        let w = disk.vertex(next_edge(t));
        gone[w] = removed;
        if disk.full[w] == NEVER_FULL {
            return;
        }
        t = disk.straight_on(t);
        if t == first {
            return;
        }
    }
}

/// Number the sides of a block from 4 `number` on, counter-clockwise from the half-edge that begins
/// the first; note the half-edges across.
fn walk_block(start: i32, number: usize, disk: Disk, work: &mut ReductionWork) {
    let removed = work.stamp[0];
    let mut h = start;
    for side in 4 * number..4 * number + 4 {
        work.block[h as usize] = side as i32;
        work.head[side] = h;
        let mut ahead = next_edge(h);
        while work.gone[disk.vertex(ahead)] == removed {
            h = next_edge(disk.twin(ahead));
            ahead = next_edge(h);
        }
        work.reduced[side] = disk.twin(h);
        h = ahead;
    }
}

/// Cut a disk into the blocks of quads between the vertices that [`mark_chains`] left; return as
/// [`dissolve`] does.
pub fn cut_blocks(disk: Disk, work: &mut ReductionWork) -> (usize, usize) {
    let removed = work.stamp[0];
    let mut n_blocks = 0;
    for h in 0..disk.twin.len() {
        if work.block[h] < 0 && work.gone[disk.vertex[h] as usize] != removed {
            walk_block(h as i32, n_blocks, disk, work);
            n_blocks += 1;
        }
    }
    let mut n_starts = 0;
    for side in 0..4 * n_blocks {
        let t = work.reduced[side];
        if t >= 0 {
            work.reduced[side] = work.block[t as usize];
        } else if disk.count[disk.vertex(work.head[side])] != 2 {
            work.starts[n_starts] = side as i32;
            n_starts += 1;
        }
    }
    work.clear_blocks(n_blocks);
    if n_starts == 0 {
        for side in (0..4 * n_blocks).filter(|&side| work.reduced[side] < 0) {
            work.starts[n_starts] = side as i32;
            n_starts += 1;
        }
    }
    (n_blocks, n_starts)
}

/// Write the pattern of a disk as [`crate::code::rooted_code`] reads it, counter-clockwise from a
/// half-edge whose tail [`mark_chains`] left; return its number of quads.
///
/// It looks at the blocks in the order of the reading, and at no others. Without a half-edge the
/// pattern has no quads.
pub fn read_pattern(
    start: Option<i32>,
    disk: Disk,
    code: &mut [u16],
    work: &mut ReductionWork,
) -> usize {
    let Some(start) = start else { return 0 };
    walk_block(start, 0, disk, work);
    let mut n_blocks = 1;
    let mut at = 0;
    while at < 4 * n_blocks {
        let t = work.reduced[at];
        code[at] = if t < 0 {
            0
        } else {
            if work.block[t as usize] < 0 {
                // A block met for the first time, by this edge of it.
                walk_block(t, n_blocks, disk, work);
                n_blocks += 1;
            }
            (1 + work.block[t as usize]) as u16
        };
        at += 1;
    }
    work.clear_blocks(n_blocks);
    n_blocks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::halfedge::fans;

    /// A strip of three quads, one after the other.
    const STRIP: [i32; 12] = [-1, 7, -1, -1, -1, 11, -1, 1, -1, -1, -1, 5];

    /// Reduce a disk that is a mesh of its own; return the pattern's half-edges and starts.
    fn reduce(
        twin: &[i32],
        by: fn(Disk, &mut ReductionWork) -> (usize, usize),
    ) -> (Vec<i32>, Vec<i32>) {
        let (vertex, n_vertices) = fans(twin);
        let mut count = vec![0; n_vertices as usize];
        vertex.iter().for_each(|&v| count[v as usize] += 1);
        let mut full = count.clone();
        for h in (0..twin.len()).filter(|&h| twin[h] < 0) {
            full[vertex[h] as usize] = NEVER_FULL;
        }
        let (n, v) = (twin.len(), n_vertices as usize);
        let mut work = ReductionWork {
            gone: &mut vec![0; v],
            seen: &mut vec![0; v],
            stamp: &mut [0; 2],
            border: &mut vec![0; n],
            block: &mut vec![-1; n],
            head: &mut vec![0; n],
            reduced: &mut vec![0; n],
            starts: &mut vec![0; n],
        };
        let disk = Disk {
            twin,
            vertex: &vertex,
            count: &count,
            full: &full,
        };
        let (quads, starts) = by(disk, &mut work);
        assert!(work.block.iter().all(|&side| side == -1));
        (
            work.reduced[..4 * quads].to_vec(),
            work.starts[..starts].to_vec(),
        )
    }

    #[test]
    fn a_strip_reduces_to_one_quad() {
        for by in [dissolve, dissolve_straight] {
            let (pattern, starts) = reduce(&STRIP, by);
            assert_eq!(pattern, [-1; 4]);
            assert_eq!(starts, [0, 1, 2, 3]);
        }
    }

    #[test]
    fn three_quads_about_a_vertex_stay() {
        // Quad q has the vertex at its corner 0.
        let twin = [11, -1, -1, 4, 3, -1, -1, 8, 7, -1, -1, 0];
        for by in [dissolve, dissolve_straight] {
            let (pattern, starts) = reduce(&twin, by);
            assert_eq!(pattern.len(), 12);
            assert_eq!(starts.len(), 3);
        }
    }
}
