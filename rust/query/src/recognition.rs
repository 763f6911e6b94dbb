//! Recognition: whether quads fill a boundary, which fill they are, and when two fills are the same.

use patterndb_core::code::{Reading, Sense, rooted_code};
use patterndb_core::halfedge::{fans, next_edge};

/// What quads that should fill a boundary are not. The numbers are those of `FAULTS` in Python.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Fault {
    /// The quads fill the boundary.
    None = 0,
    /// A quad repeats a vertex.
    RepeatedVertex = 1,
    /// Two edges join the same two vertices.
    DoubleEdge = 2,
    /// A border edge does not run from a boundary vertex to the next, counter-clockwise.
    OtherBorder = 3,
    /// The border is not the whole boundary.
    ShortBorder = 4,
    /// The quads are not a disk.
    NoDisk = 5,
}

/// Return the half-edges of quads that fill a boundary, and what is wrong with them.
///
/// Vertices `0..perimeter` of `0..n_vertices` run along the boundary counter-clockwise. Where there
/// is a fault, the half-edges are not complete.
pub fn weld_quads(quads: &[[i32; 4]], n_vertices: usize, perimeter: i32) -> (Vec<i32>, Fault) {
    let mut twin = vec![-1; 4 * quads.len()];
    if quads
        .iter()
        .any(|quad| (1..4).any(|i| quad[..i].contains(&quad[i])))
    {
        return (twin, Fault::RepeatedVertex);
    }
    let leaving = HalfEdgesByTail::new(quads.as_flattened(), n_vertices);
    let tail = quads.as_flattened();
    let head = |h: i32| tail[next_edge(h) as usize];

    let mut n_border = 0;
    for h in 0..tail.len() as i32 {
        let (a, b) = (tail[h as usize], head(h));
        if leaving.of(a).iter().any(|&g| g != h && head(g) == b) {
            return (twin, Fault::DoubleEdge);
        }
        for &g in leaving.of(b) {
            if head(g) == a {
                twin[h as usize] = g;
            }
        }
        if twin[h as usize] < 0 {
            n_border += 1;
            if a >= perimeter || b != (a + 1) % perimeter {
                return (twin, Fault::OtherBorder);
            }
        }
    }
    if n_border != perimeter {
        return (twin, Fault::ShortBorder);
    }
    let n_edges = (tail.len() as i32 + n_border) / 2;
    let euler = n_vertices as i32 - n_edges + quads.len() as i32;
    let disk = euler == 1 && fans(&twin).1 == n_vertices as i32 && is_connected(&twin);
    (twin, if disk { Fault::None } else { Fault::NoDisk })
}

/// Half-edges by the vertex that they leave.
pub(crate) struct HalfEdgesByTail {
    first: Vec<usize>,
    half_edges: Vec<i32>,
}

impl HalfEdgesByTail {
    /// List half-edges by their tails, below `n_vertices`.
    pub(crate) fn new(tail: &[i32], n_vertices: usize) -> Self {
        let mut first = vec![0; n_vertices + 1];
        for &v in tail {
            first[v as usize + 1] += 1;
        }
        for v in 0..n_vertices {
            first[v + 1] += first[v];
        }
        let mut free = first.clone();
        let mut half_edges = vec![0; tail.len()];
        for (h, &v) in tail.iter().enumerate() {
            half_edges[free[v as usize]] = h as i32;
            free[v as usize] += 1;
        }
        Self { first, half_edges }
    }

    /// Return the half-edges that leave vertex `v`, in order.
    pub(crate) fn of(&self, v: i32) -> &[i32] {
        &self.half_edges[self.first[v as usize]..self.first[v as usize + 1]]
    }
}

/// Are all quads reached from the first across edges?
fn is_connected(twin: &[i32]) -> bool {
    let mut seen = vec![false; twin.len() / 4];
    let mut stack = vec![0];
    seen[0] = true;
    let mut reached = 0;
    while let Some(quad) = stack.pop() {
        reached += 1;
        for &t in &twin[4 * quad..4 * quad + 4] {
            let other = (t >> 2) as usize;
            if t >= 0 && !seen[other] {
                seen[other] = true;
                stack.push(other);
            }
        }
    }
    reached == seen.len()
}

/// Return the code of a fill as read from boundary vertex 0.
///
/// A closed side has no first vertex: there it is the smallest code from any. Symbols are wider than
/// those of patterns, which name at most 16,383 quads.
pub fn read_code(quads: &[[i32; 4]], twin: &[i32], closed: bool) -> Vec<i32> {
    let q = quads.len();
    let tail = quads.as_flattened();
    let mut code = vec![0; 4 * q];
    let (mut number, mut entry, mut order) = (vec![0; q], vec![0; q], vec![0; q]);
    let mut reading = Reading {
        number: &mut number,
        entry: &mut entry,
        order: &mut order,
    };
    let starts = (0..4 * q).filter(|&h| twin[h] < 0 && (closed || tail[h] == 0));
    for (read_before, start) in starts.enumerate() {
        let (start, sense, best) = (start as i32, Sense::CounterClockwise, read_before > 0);
        rooted_code(twin, q, start, sense, &mut code, &mut reading, best);
    }
    code
}

/// Return the number of edges along every side of blocks, whose sides begin at the half-edges `head`.
pub fn lengths(twin: &[i32], head: &[i32]) -> Vec<i32> {
    let length = |b: usize| {
        let end = head[next_edge(b as i32) as usize];
        let mut h = head[b];
        let mut length = 1;
        while next_edge(h) != end {
            h = next_edge(twin[next_edge(h) as usize]);
            length += 1;
        }
        length
    };
    (0..head.len()).map(length).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_fills_four_edges() {
        assert_eq!(
            weld_quads(&[[0, 1, 2, 3]], 4, 4),
            (vec![-1; 4], Fault::None)
        );
        assert_eq!(weld_quads(&[[0, 1, 2, 3]], 4, 3).1, Fault::OtherBorder);
        assert_eq!(weld_quads(&[[0, 1, 2, 1]], 3, 3).1, Fault::RepeatedVertex);
    }

    #[test]
    fn a_closed_side_has_the_smallest_code_of_all_starts() {
        let quads = [[1, 2, 5, 0], [2, 3, 4, 5]];
        let (twin, fault) = weld_quads(&quads, 6, 6);
        assert_eq!(fault, Fault::None);
        assert_eq!(read_code(&quads, &twin, false), [0, 0, 5, 0, 3, 0, 0, 0]);
        assert_eq!(read_code(&quads, &twin, true), [0, 0, 0, 5, 4, 0, 0, 0]);
    }

    #[test]
    fn a_block_of_two_quads_has_two_sides_of_two_edges() {
        let twin = [-1, 7, -1, -1, -1, -1, -1, 1];
        assert_eq!(lengths(&twin, &[0, 5, 6, 3]), [2, 1, 2, 1]);
    }
}
