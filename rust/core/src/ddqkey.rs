//! The keys by which the authors of Marcias et al. 2015 store patterns, and the columns of their
//! database next to them.
//!
//! A *key* lists the faces of a patch breadth-first from a start corner. For every face it names the
//! faces across three of its edges, counter-clockwise after the edge by which the face was reached;
//! face 0 is taken as reached by the border edge that leaves the start corner. Among all corners
//! (all boundary vertices where there is no corner) the smallest key is the patch's.
//!
//! Source: the database of Marcias et al. 2015.

use crate::code::{Reading, Sense, border_count, border_from, code_starts, rooted_code};
use crate::halfedge::fans;
use crate::polychord::trace;

/// The smallest key of a disk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Key {
    /// For every face the faces across three of its edges, -1 at the border.
    pub faces: Vec<i32>,
    /// The half-edges, numbered as in the key.
    pub twin: Vec<i32>,
}

/// Return the smallest key of the pattern of a code, read in a sense.
pub fn smallest_key(code: &[u16], sense: Sense) -> Key {
    let twin = half_edges(code);
    let n_quads = code.len() / 4;
    let [mut number, mut entry, mut order] = [(); 3].map(|()| vec![0; n_quads]);
    let mut reading = Reading {
        number: &mut number,
        entry: &mut entry,
        order: &mut order,
    };
    let mut rooted = vec![0; code.len()];
    let mut best: Option<Key> = None;
    for start in code_starts(&twin) {
        let h = sense.start(&twin, start);
        rooted_code(&twin, n_quads, h, sense, &mut rooted, &mut reading, false);
        if best
            .as_ref()
            .is_none_or(|best| faces(&rooted).lt(best.faces.iter().copied()))
        {
            best = Some(Key {
                faces: faces(&rooted).collect(),
                twin: half_edges(&rooted),
            });
        }
    }
    best.unwrap_or_default()
}

/// Return the half-edges that a code describes.
fn half_edges(code: &[u16]) -> Vec<i32> {
    code.iter().map(|&symbol| i32::from(symbol) - 1).collect()
}

/// Return, quad by quad, the faces across edges 1 to 3 in a code, -1 at the border.
fn faces(code: &[u16]) -> impl Iterator<Item = i32> {
    let across = code.chunks_exact(4).flat_map(|quad| &quad[1..]);
    // Symbol 0 is the border: the shift keeps the sign.
    across.map(|&symbol| (i32::from(symbol) - 1) >> 2)
}

/// What the columns next to a key are made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    /// The polychord of every boundary edge, from half-edge 0 on.
    pub chords: Vec<i32>,
    /// Whether a corner comes before each boundary edge.
    pub corners: Vec<bool>,
    /// The numbers of quads at the irregular vertices inside.
    pub valences: Vec<i32>,
    /// Number of vertices.
    pub n_vertices: i32,
    /// Number of reflex corners.
    pub n_concave: i64,
}

/// Survey a disk, given by its half-edges from the start corner on.
pub fn survey(twin: &[i32]) -> Survey {
    let (vertex, n_vertices) = fans(twin);
    let of_edge = trace(twin).of_edge;
    let mut valence = vec![0; n_vertices as usize];
    let mut inner = vec![true; n_vertices as usize];
    for (&v, &across) in vertex.iter().zip(twin) {
        valence[v as usize] += 1;
        inner[v as usize] &= across >= 0;
    }
    let border = border_from(twin, 0);
    let counts: Vec<i32> = border.iter().map(|&h| border_count(twin, h)).collect();
    let irregular = valence.into_iter().zip(inner);
    Survey {
        chords: border.iter().map(|&h| of_edge[h as usize]).collect(),
        corners: counts.iter().map(|&count| count != 2).collect(),
        valences: irregular
            .filter_map(|(valence, inner)| (inner && valence != 4).then_some(valence))
            .collect(),
        n_vertices,
        n_concave: counts.iter().filter(|&&count| count > 2).count() as i64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two quads with one common edge, as a code.
    const PAIR: [u16; 8] = [0, 5, 0, 0, 2, 0, 0, 0];

    #[test]
    fn a_key_of_a_pair_names_the_other_face_once() {
        let key = smallest_key(&PAIR, Sense::CounterClockwise);
        assert_eq!(key.faces, [-1, 1, -1, -1, -1, -1]);
        assert_eq!(key, smallest_key(&PAIR, Sense::Clockwise));
    }

    #[test]
    fn a_pair_has_six_border_edges_and_four_corners() {
        let made = survey(&half_edges(&PAIR));
        assert_eq!(made.corners, [true, false, true, true, false, true]);
        assert_eq!((made.n_vertices, made.n_concave), (6, 0));
        assert!(made.valences.is_empty());
    }
}
