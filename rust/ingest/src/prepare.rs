//! Preparing a mesh: polychords that only refine it are collapsed before patches are taken.
//!
//! Irregular vertices come closer together, so patches of the same number of quads hold more of
//! them. A polychord is collapsed as in a patch (it does not cross itself, its chains are simple and
//! disjoint, one of them is regular), unless that would make a degenerate quad or an edge of three
//! quads. Around holes the outcome depends on the order; the polychord with the smallest quad goes
//! first, again and again, so that a mesh always gives one result.
//!
//! Source: Marcias et al. 2015, section 3.2 ("Mesh preprocessing").

use crate::collapse::Work;

/// Collapse all polychords that may be, in place; return the quads that are left.
pub fn collapse_all(vertex: &mut [i32], twin: &mut [i32], n_vertices: usize) -> Vec<bool> {
    let mut work = Work::new(vertex, twin, n_vertices);
    let mut at = 0;
    while at < work.dirty.len() {
        if !work.dirty[at] || !work.alive[at / 2] {
            at += 1;
            continue;
        }
        let h = (4 * (at / 2) + at % 2) as i32;
        let strip = work.trace_strip(h).filter(|strip| work.may_collapse(strip));
        match strip {
            Some(strip) => at = at.min(work.collapse(&strip)),
            None => {
                work.settle(h);
                at += 1;
            }
        }
    }
    work.alive
}

#[cfg(test)]
mod tests {
    use super::*;
    use patterndb_core::halfedge::fans;

    #[test]
    fn a_strip_collapses_to_one_quad() {
        let mut twin = [-1, 7, -1, -1, -1, 11, -1, 1, -1, -1, -1, 5];
        let (mut vertex, n_vertices) = fans(&twin);
        let alive = collapse_all(&mut vertex, &mut twin, n_vertices as usize);
        assert_eq!(alive, [false, false, true]);
        assert_eq!(twin[8..], [-1; 4]);
    }

    #[test]
    fn three_quads_about_a_vertex_stay() {
        let twin = [11, -1, -1, 4, 3, -1, -1, 8, 7, -1, -1, 0];
        let (vertex, n_vertices) = fans(&twin);
        let alive = collapse_all(&mut vertex.clone(), &mut twin.clone(), n_vertices as usize);
        assert_eq!(alive, [true; 3]);
    }
}
