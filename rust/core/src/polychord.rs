//! Polychords: the strips of quads that run through opposite edges.
//!
//! Every quad lies on two strands (edges 0 and 2, edges 1 and 3); a polychord is a maximal chain of
//! strands. It is open, between two border edges, or a loop.

/// The polychords of a quad complex; open ones have the first numbers, in the order of their first
/// border half-edges.
pub struct Polychords {
    /// The polychord that crosses each half-edge.
    pub of_edge: Vec<i32>,
    /// Number of open polychords.
    pub n_open: i32,
    /// Number of all polychords.
    pub n: i32,
}

impl Polychords {
    /// Return whether a polychord passes a quad twice.
    pub fn has_self_crossing(&self) -> bool {
        let mut quads = self.of_edge.chunks_exact(4);
        quads.any(|quad| quad[0] == quad[1])
    }
}

/// Trace all polychords.
pub fn trace(twin: &[i32]) -> Polychords {
    let mut of_edge = vec![-1; twin.len()];
    let mut n = 0;
    let mut n_open = 0;
    for loops in [false, true] {
        for start in 0..twin.len() {
            if of_edge[start] >= 0 || (twin[start] >= 0 && !loops) {
                continue;
            }
            let mut h = start as i32;
            while h >= 0 && of_edge[h as usize] < 0 {
                of_edge[h as usize] = n;
                of_edge[(h ^ 2) as usize] = n;
                h = twin[(h ^ 2) as usize];
            }
            n += 1;
        }
        if !loops {
            n_open = n;
        }
    }
    Polychords { of_edge, n_open, n }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_of_quads_has_three_open_polychords() {
        let found = trace(&[-1, 7, -1, -1, -1, -1, -1, 1]);
        assert_eq!((found.n_open, found.n), (3, 3));
        assert_eq!(found.of_edge, [0, 1, 0, 1, 2, 1, 2, 1]);
        assert!(!found.has_self_crossing());
    }

    #[test]
    fn a_quad_joined_to_itself_has_a_loop() {
        let found = trace(&[-1, 3, -1, 1]);
        assert_eq!((found.n_open, found.n), (1, 2));
        assert_eq!(found.of_edge, [0, 1, 0, 1]);
    }
}
