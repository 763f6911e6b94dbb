//! Collapsing one polychord of a mesh in work: whether it may be, and doing it.
//!
//! The mesh is changed in place, so that a collapse costs what lies around the polychord and not
//! what the mesh has in all.

use patterndb_core::halfedge::{border_vertices, next_edge, prev_edge};

/// The mesh in work.
pub struct Work<'a> {
    /// Vertex of each corner.
    vertex: &'a mut [i32],
    twin: &'a mut [i32],
    /// The corners of a vertex form a ring.
    after: Vec<i32>,
    before: Vec<i32>,
    /// One corner of each vertex, -1 without any.
    corner: Vec<i32>,
    valence: Vec<i32>,
    border: Vec<bool>,
    /// Whether each quad is still there.
    pub alive: Vec<bool>,
    /// Strands (2 * quad + direction) that may collapse or have not been looked at since something
    /// changed next to them.
    pub dirty: Vec<bool>,
    stamp: u64,
    /// Stamps of vertices and quads.
    seen: Vec<u64>,
    passed: Vec<u64>,
    /// The vertex that each one with the stamp at hand goes into.
    merged: Vec<i32>,
    /// Stamps of the vertices whose `uses` are of the vertex at hand.
    counted: Vec<u64>,
    uses: Vec<i32>,
}

/// A polychord that does not cross itself: the half-edges by which it enters its quads.
pub struct Strip {
    entries: Vec<i32>,
    is_loop: bool,
}

/// The two vertices of an edge across a polychord.
#[derive(Clone, Copy)]
struct Rung {
    left: i32,
    right: i32,
}

impl Strip {
    fn n_rungs(&self) -> usize {
        self.entries.len() + usize::from(!self.is_loop)
    }

    /// Return whether a rung is an end of an open strip.
    fn is_end(&self, rung: usize) -> bool {
        !self.is_loop && (rung == 0 || rung == self.entries.len())
    }
}

impl<'a> Work<'a> {
    /// Begin to work on a mesh, whose arrays are changed from now on, with every strand dirty.
    pub fn new(vertex: &'a mut [i32], twin: &'a mut [i32], n_vertices: usize) -> Self {
        let n = twin.len();
        let mut corner = vec![-1; n_vertices];
        let mut valence = vec![0; n_vertices];
        let (mut after, mut before) = (vec![0; n], vec![0; n]);
        for h in 0..n {
            let v = vertex[h] as usize;
            let first = corner[v];
            if first < 0 {
                corner[v] = h as i32;
                (after[h], before[h]) = (h as i32, h as i32);
            } else {
                let last = before[first as usize];
                (after[last as usize], before[h]) = (h as i32, last);
                (after[h], before[first as usize]) = (first, h as i32);
            }
            valence[v] += 1;
        }
        Self {
            border: border_vertices(twin, vertex, n_vertices),
            vertex,
            twin,
            after,
            before,
            corner,
            valence,
            alive: vec![true; n / 4],
            dirty: vec![true; n / 2],
            stamp: 0,
            seen: vec![0; n_vertices],
            passed: vec![0; n / 4],
            merged: vec![0; n_vertices],
            counted: vec![0; n_vertices],
            uses: vec![0; n_vertices],
        }
    }

    fn next_stamp(&mut self) -> u64 {
        self.stamp += 1;
        self.stamp
    }

    fn twin(&self, h: i32) -> i32 {
        self.twin[h as usize]
    }

    fn vertex(&self, h: i32) -> i32 {
        self.vertex[h as usize]
    }

    /// Return the corners of a vertex, once round.
    fn corners(&self, v: i32) -> impl Iterator<Item = i32> {
        ring(&self.after, self.corner[v as usize])
    }

    /// Return a rung of a strip; the last of an open strip is its far end.
    fn rung(&self, strip: &Strip, i: usize) -> Rung {
        let (left, right) = match strip.entries.get(i) {
            Some(&h) => (h, next_edge(h)),
            None => {
                let far = strip.entries[i - 1] ^ 2;
                (next_edge(far), far)
            }
        };
        Rung {
            left: self.vertex(left),
            right: self.vertex(right),
        }
    }

    fn rungs(&self, strip: &Strip) -> Vec<Rung> {
        (0..strip.n_rungs()).map(|i| self.rung(strip, i)).collect()
    }

    /// Return the first half-edge of the polychord through half-edge `h`, and whether it is a loop.
    fn find_start(&self, h: i32) -> (i32, bool) {
        let mut start = h;
        while self.twin(start) >= 0 {
            start = self.twin(start) ^ 2;
            if start == h {
                return (start, true);
            }
        }
        (start, false)
    }

    /// Return the polychord through half-edge `h`; `None` where it crosses itself.
    pub fn trace_strip(&mut self, h: i32) -> Option<Strip> {
        let mark = self.next_stamp();
        let (start, is_loop) = self.find_start(h);
        let mut entries = Vec::new();
        let mut entry = start;
        loop {
            let passed = &mut self.passed[(entry >> 2) as usize];
            if *passed == mark {
                return None;
            }
            *passed = mark;
            entries.push(entry);
            entry = self.twin(entry ^ 2);
            if entry < 0 || entry == start {
                return Some(Strip { entries, is_loop });
            }
        }
    }

    /// Note that the polychord through half-edge `h` may not collapse as things stand.
    pub fn settle(&mut self, h: i32) {
        let (start, _) = self.find_start(h);
        let mut entry = start;
        loop {
            self.dirty[(2 * (entry >> 2) + (entry & 1)) as usize] = false;
            entry = self.twin(entry ^ 2);
            if entry < 0 || entry == start {
                return;
            }
        }
    }

    /// Return whether a polychord has simple disjoint chains, one of them regular, and whether
    /// nothing is broken when it is gone.
    pub fn may_collapse(&mut self, strip: &Strip) -> bool {
        let rungs = self.rungs(strip);
        if !self.has_regular_chain(strip, &rungs) {
            return false;
        }
        let mark = self.next_stamp();
        for &entry in &strip.entries {
            self.passed[(entry >> 2) as usize] = mark;
        }
        for &Rung { left, right } in &rungs {
            self.seen[left as usize] = mark;
            self.merged[left as usize] = right;
        }
        rungs.iter().all(|&rung| {
            !self.makes_degenerate_quad(rung, mark) && !self.makes_triple_edge(rung, mark)
        })
    }

    /// Return whether both chains of a strip are simple and disjoint, and one of them regular.
    fn has_regular_chain(&mut self, strip: &Strip, rungs: &[Rung]) -> bool {
        let mark = self.next_stamp();
        let mut regular = [true; 2];
        for (i, &Rung { left, right }) in rungs.iter().enumerate() {
            let is_end = strip.is_end(i);
            let quads = if is_end { 2 } else { 4 };
            for (v, regular) in [left, right].into_iter().zip(&mut regular) {
                let v = v as usize;
                if self.seen[v] == mark {
                    return false;
                }
                self.seen[v] = mark;
                *regular &= self.border[v] == is_end && self.valence[v] == quads;
            }
        }
        regular[0] || regular[1]
    }

    /// Return whether a quad outside the strip, whose quads have the stamp `mark`, has both vertices
    /// of a rung.
    fn makes_degenerate_quad(&self, rung: Rung, mark: u64) -> bool {
        self.corners(rung.left).any(|h| {
            let quad = (h >> 2) as usize;
            self.passed[quad] != mark && self.vertex[4 * quad..4 * quad + 4].contains(&rung.right)
        })
    }

    /// Return whether an edge at the merged vertex would have three quads or more, and had not before.
    ///
    /// Quads of the strip and vertices of its left chain have the stamp `mark`.
    fn makes_triple_edge(&mut self, rung: Rung, mark: u64) -> bool {
        let tally = self.next_stamp();
        for v in [rung.left, rung.right] {
            for h in ring(&self.after, self.corner[v as usize]) {
                if self.passed[(h >> 2) as usize] == mark {
                    continue;
                }
                for neighbour in [next_edge(h), prev_edge(h)] {
                    let mut w = self.vertex[neighbour as usize] as usize;
                    if self.seen[w] == mark {
                        w = self.merged[w] as usize;
                    }
                    if self.counted[w] != tally {
                        self.counted[w] = tally;
                        self.uses[w] = 0;
                    }
                    self.uses[w] += 1;
                    if self.uses[w] > 2 && !self.has_triple_edge(v, h) {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Return whether an edge at corner `h` of vertex `v` has three quads or more.
    fn has_triple_edge(&self, v: i32, h: i32) -> bool {
        [next_edge(h), prev_edge(h)].into_iter().any(|neighbour| {
            let w = self.vertex(neighbour);
            let uses = |edge: i32| usize::from(self.vertex(edge) == w);
            let corners = self.corners(v);
            let count: usize = corners
                .map(|g| uses(next_edge(g)) + uses(prev_edge(g)))
                .sum();
            count > 2
        })
    }

    /// Take a strip out and merge its left chain into its right; return the smallest strand that
    /// became dirty.
    pub fn collapse(&mut self, strip: &Strip) -> usize {
        let rungs = self.rungs(strip);
        for &entry in &strip.entries {
            self.take_out(entry);
        }
        for &rung in &rungs {
            self.merge(rung);
        }
        for rung in &rungs {
            self.close_slits(rung.right);
        }
        for rung in &rungs {
            self.update_border(rung.right);
        }
        self.make_dirty(&rungs)
    }

    /// Take the quad that a strip enters by half-edge `entry` out, and join its sides.
    fn take_out(&mut self, entry: i32) {
        let (one, other) = (self.twin(prev_edge(entry)), self.twin(next_edge(entry)));
        if one >= 0 {
            self.twin[one as usize] = other;
        }
        if other >= 0 {
            self.twin[other as usize] = one;
        }
        let quad = (entry >> 2) as usize;
        self.alive[quad] = false;
        for c in 4 * quad..4 * quad + 4 {
            let v = self.vertex[c] as usize;
            self.valence[v] -= 1;
            let (before, after) = (self.before[c], self.after[c]);
            self.after[before as usize] = after;
            self.before[after as usize] = before;
            if self.corner[v] == c as i32 {
                self.corner[v] = if after == c as i32 { -1 } else { after };
            }
        }
    }

    /// Make the left vertex of a rung one with the right.
    fn merge(&mut self, Rung { left, right }: Rung) {
        let (left, right) = (left as usize, right as usize);
        let first = self.corner[left];
        if first < 0 {
            return;
        }
        for h in ring(&self.after, first) {
            self.vertex[h as usize] = right as i32;
        }
        let there = self.corner[right];
        if there < 0 {
            self.corner[right] = first;
        } else {
            let (last, last_there) = (self.before[first as usize], self.before[there as usize]);
            self.after[last_there as usize] = first;
            self.before[first as usize] = last_there;
            self.after[last as usize] = there;
            self.before[there as usize] = last;
        }
        self.valence[right] += self.valence[left];
        self.valence[left] = 0;
        self.corner[left] = -1;
    }

    /// Join two border edges at a vertex that have come to lie on each other: they
    /// close a hole of two edges.
    fn close_slits(&mut self, v: i32) {
        let corners: Vec<i32> = self.corners(v).collect();
        for &h in &corners {
            if self.twin(h) >= 0 {
                continue;
            }
            // Of the edges to the same vertex, the last border half-edge that ends in v.
            let w = self.vertex(next_edge(h));
            let mut count = 0;
            let mut match_at = None;
            for &g in &corners {
                count += i32::from(self.vertex(next_edge(g)) == w);
                let p = prev_edge(g);
                if self.vertex(p) == w {
                    count += 1;
                    if self.twin(p) < 0 && p >> 2 != h >> 2 {
                        match_at = Some(p);
                    }
                }
            }
            if let (2, Some(p)) = (count, match_at) {
                self.twin[h as usize] = p;
                self.twin[p as usize] = h;
                self.update_border(w);
            }
        }
    }

    fn update_border(&mut self, v: i32) {
        let is_border = self
            .corners(v)
            .any(|h| self.twin(h) < 0 || self.twin(prev_edge(h)) < 0);
        self.border[v as usize] = is_border;
    }

    /// Mark the strands of all quads within two rings of the merged vertices; return the smallest.
    fn make_dirty(&mut self, rungs: &[Rung]) -> usize {
        let mut smallest = self.dirty.len();
        for rung in rungs {
            for h in ring(&self.after, self.corner[rung.right as usize]) {
                let quad = (h >> 2) as usize;
                for &v in &self.vertex[4 * quad..4 * quad + 4] {
                    for g in ring(&self.after, self.corner[v as usize]) {
                        let strand = 2 * (g >> 2) as usize;
                        self.dirty[strand] = true;
                        self.dirty[strand + 1] = true;
                        smallest = smallest.min(strand);
                    }
                }
            }
        }
        smallest
    }
}

/// Walk a ring of corners once, from `first` on; nothing where that is -1.
fn ring(after: &[i32], first: i32) -> impl Iterator<Item = i32> {
    let next = move |&h: &i32| Some(after[h as usize]).filter(|&h| h != first);
    std::iter::successors((first >= 0).then_some(first), next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use patterndb_core::halfedge::fans;

    #[test]
    fn a_ring_is_walked_once() {
        assert_eq!(ring(&[2, 1, 0], 0).collect::<Vec<_>>(), [0, 2]);
        assert_eq!(ring(&[0], -1).count(), 0);
    }

    #[test]
    fn the_only_strip_through_a_quad_may_collapse_and_none_that_crosses_itself() {
        let mut twin = [-1, 7, -1, -1, -1, -1, -1, 1];
        let (mut vertex, n_vertices) = fans(&twin);
        let mut work = Work::new(&mut vertex, &mut twin, n_vertices as usize);
        let strip = work.trace_strip(0).expect("it does not cross itself");
        assert_eq!(strip.entries, [0]);
        assert!(work.may_collapse(&strip));
        assert_eq!(work.collapse(&strip), 2);
        assert_eq!(work.alive, [false, true]);
        // Edges 0 and 1 of one quad joined.
        let mut twin = [1, 0, -1, -1];
        let (mut vertex, n_vertices) = fans(&twin);
        let mut work = Work::new(&mut vertex, &mut twin, n_vertices as usize);
        assert!(work.trace_strip(2).is_none());
    }
}
