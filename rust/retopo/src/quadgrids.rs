//! Meshes of quads, cut into regular grids along their separatrices.
//!
//! Half-edges are those of [`patterndb_core::halfedge`]; vertices are those of the mesh.

use patterndb_core::halfedge::{next_edge, prev_edge};

/// A mesh of quads.
#[derive(Clone, Copy, Debug)]
pub struct Quads<'a> {
    /// Of each half-edge the one on the other side, -1 on the border.
    pub twin: &'a [i32],
    /// Of each half-edge the vertex that it leaves.
    pub tail: &'a [i32],
}

impl Quads<'_> {
    fn twin(&self, h: i32) -> i32 {
        self.twin[h as usize]
    }

    fn tail(&self, h: i32) -> usize {
        self.tail[h as usize] as usize
    }

    fn half_edges(&self) -> std::ops::Range<i32> {
        0..self.twin.len() as i32
    }
}

/// Half-edges on curves between patches.
#[derive(Debug)]
pub struct Separatrices<'a> {
    mesh: Quads<'a>,
    /// Of each vertex: is it irregular?
    irregular: &'a [bool],
    /// Of each vertex: do curves end there?
    stop: Vec<bool>,
    /// Of each half-edge: is it on a curve?
    marked: &'a mut [bool],
}

impl<'a> Separatrices<'a> {
    /// Take a mesh, which vertices are irregular and which on the border, and the half-edges that
    /// are on curves already.
    pub fn new(
        mesh: Quads<'a>,
        irregular: &'a [bool],
        border: &[bool],
        marked: &'a mut [bool],
    ) -> Separatrices<'a> {
        let stop = irregular.iter().zip(border).map(|(&a, &b)| a | b).collect();
        Separatrices {
            mesh,
            irregular,
            stop,
            marked,
        }
    }

    /// Mark edges straight ahead from half-edge h on, until one that is marked, or a stop.
    fn run(&mut self, mut h: i32) {
        while !self.marked[h as usize] {
            self.marked[h as usize] = true;
            if let Ok(twin) = usize::try_from(self.mesh.twin(h)) {
                self.marked[twin] = true;
            }
            let ahead = next_edge(h);
            if self.stop[self.mesh.tail(ahead)] {
                return;
            }
            // Across the edge ahead, and on: a regular vertex inside has four.
            h = next_edge(self.mesh.twin(ahead));
        }
    }

    /// Mark edges straight ahead from every irregular vertex.
    pub fn run_all(&mut self) {
        for h in self.mesh.half_edges() {
            if self.irregular[self.mesh.tail(h)] {
                self.run(h);
            }
        }
    }

    /// Cut parts without irregular vertices: across from a vertex of the border, where there is one;
    /// else from the first vertex along both of its lines.
    pub fn cut_regular(&mut self) {
        let mut seen = vec![false; self.mesh.twin.len() / 4];
        let mut part = Vec::new();
        for root in 0..seen.len() {
            if seen[root] {
                continue;
            }
            self.list_part(root as i32, &mut seen, &mut part);
            if part.iter().any(|&h| self.irregular[self.mesh.tail(h)]) {
                continue;
            }
            let rim = part.iter().filter(|&&h| self.mesh.twin(h) < 0);
            // The edge to the left of a half-edge's start, seen along it.
            if let Some(&begin) = rim.min() {
                self.run(self.mesh.twin(prev_edge(begin)));
            } else {
                let first = 4 * root as i32;
                self.run(first);
                self.run(self.mesh.twin(prev_edge(first)));
            }
        }
    }

    /// List the half-edges of a quad's part of the mesh.
    fn list_part(&self, root: i32, seen: &mut [bool], part: &mut Vec<i32>) {
        part.clear();
        part.extend(4 * root..4 * root + 4);
        seen[root as usize] = true;
        let mut at = 0;
        while at < part.len() {
            if let Ok(twin) = usize::try_from(self.mesh.twin(part[at]))
                && !seen[twin / 4]
            {
                seen[twin / 4] = true;
                let quad = twin as i32 & !3;
                part.extend(quad..quad + 4);
            }
            at += 1;
        }
    }
}

/// Marked half-edges as curves from corner to corner; half-curve 2 k runs along curve k, 2 k + 1
/// back.
#[derive(Clone, Debug)]
pub struct GridCurves {
    /// Those of curve k from `start[k]` to `start[k + 1]`, in order.
    pub edges: Vec<i32>,
    /// One more than there are curves.
    pub start: Vec<i32>,
    /// Of each half-edge the half-curve that it is on, -1 for none.
    pub half: Vec<i32>,
}

/// Follow marked edges from corner to corner.
pub fn follow_marked(mesh: Quads, marked: &[bool], corner: &[bool]) -> GridCurves {
    let mut half = vec![-1; mesh.twin.len()];
    let (mut edges, mut start) = (Vec::new(), vec![0]);
    for first in mesh.half_edges() {
        let begins = marked[first as usize] && corner[mesh.tail(first)];
        if !begins || half[first as usize] >= 0 {
            continue;
        }
        let name = 2 * (start.len() as i32 - 1);
        let mut h = first;
        loop {
            edges.push(h);
            half[h as usize] = name;
            if let Ok(twin) = usize::try_from(mesh.twin(h)) {
                half[twin] = name + 1;
            }
            let ahead = next_edge(h);
            if corner[mesh.tail(ahead)] {
                break;
            }
            h = next_edge(mesh.twin(ahead));
        }
        start.push(edges.len() as i32);
    }
    GridCurves { edges, start, half }
}

/// Return the vertices of the grid of `w` x `n` quads whose first row begins with half-edge h, `n + 1`
/// rows of `w + 1`: row 0 from its start on, ahead of it; rows lie one left of the other.
pub fn read_grid(mesh: Quads, h: i32, w: usize, n: usize) -> Vec<i32> {
    let mut found = Vec::with_capacity((n + 1) * (w + 1));
    let mut row = h;
    for j in 0..n {
        if j > 0 {
            row = mesh.twin(prev_edge(prev_edge(row)));
        }
        let along = list_row(mesh, row, w);
        found.extend(along.iter().map(|&at| mesh.tail(at) as i32));
        found.push(mesh.tail(next_edge(along[w - 1])) as i32);
    }
    let along = list_row(mesh, row, w);
    found.extend(along.iter().map(|&at| mesh.tail(prev_edge(at)) as i32));
    found.push(mesh.tail(prev_edge(prev_edge(along[w - 1]))) as i32);
    found
}

/// Return the half-edges of w quads in a row, along its right.
fn list_row(mesh: Quads, first: i32, w: usize) -> Vec<i32> {
    let mut along = Vec::with_capacity(w);
    along.push(first);
    while along.len() < w {
        let at = along[along.len() - 1];
        along.push(next_edge(mesh.twin(next_edge(at))));
    }
    along
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three quads in a row: 0 1 2 3 below, 4 5 6 7 above.
    const ROW: Quads = Quads {
        twin: &[-1, 7, -1, -1, -1, 11, -1, 1, -1, -1, -1, 5],
        tail: &[0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6],
    };

    #[test]
    fn a_grid_has_its_vertices_in_rows() {
        assert_eq!(read_grid(ROW, 0, 3, 1), [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(read_grid(ROW, 9, 1, 3), [3, 7, 2, 6, 1, 5, 0, 4]);
    }

    #[test]
    fn curves_run_straight_on_from_irregular_vertices() {
        let irregular = [0, 1, 2, 3, 4, 5, 6, 7].map(|v| [0, 1, 3, 4, 7].contains(&v));
        let mut marked: Vec<bool> = ROW.twin.iter().map(|&twin| twin < 0).collect();
        Separatrices::new(ROW, &irregular, &[true; 8], &mut marked).run_all();
        assert!(marked[1] && marked[7] && !marked[5]);
        let corner = [0, 1, 2, 3, 4, 5, 6, 7].map(|v| ![2, 6].contains(&v));
        let curves = follow_marked(ROW, &marked, &corner);
        assert_eq!(curves.edges, [0, 1, 2, 3, 4, 8, 9, 10, 6]);
        assert_eq!(curves.start, [0, 1, 2, 3, 4, 6, 7, 9]);
        assert_eq!(curves.half[7], 3);
    }

    #[test]
    fn a_part_without_irregular_vertices_is_cut_across() {
        // Two quads in a ring.
        let ring = Quads {
            twin: &[-1, 7, -1, 5, -1, 3, -1, 1],
            tail: &[0, 1, 3, 2, 1, 0, 2, 3],
        };
        let mut marked: Vec<bool> = ring.twin.iter().map(|&twin| twin < 0).collect();
        Separatrices::new(ring, &[false; 4], &[true; 4], &mut marked).cut_regular();
        assert_eq!(marked, [true, false, true, true, true, true, true, false]);
    }
}
