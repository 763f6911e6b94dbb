//! Strands: the strips of quads of a fill, one quad wide, from boundary edge to boundary edge.

/// Return the half-edge on the other side of a quad.
fn cross(half_edge: i32) -> i32 {
    half_edge ^ 2
}

/// Return the half-edges of the transversal edges from `first` on, each entering a quad but for the
/// last one of an open strand, which is the far side of the last quad.
pub fn walk(twin: &[i32], first: i32) -> Vec<i32> {
    let mut chain = vec![first];
    loop {
        let far = cross(chain[chain.len() - 1]);
        let next = twin[far as usize];
        if next == first {
            return chain;
        }
        if next < 0 {
            chain.push(far);
            return chain;
        }
        chain.push(next);
    }
}

/// Return, for each boundary edge, the position of the boundary edge where its strand ends.
///
/// `border` holds the half-edges along the boundary, in order.
pub fn find_far_ends(twin: &[i32], border: &[i32]) -> Vec<i32> {
    let mut place = vec![-1; twin.len()];
    for (i, &h) in (0..).zip(border) {
        place[h as usize] = i;
    }
    let far_end = |&h: &i32| {
        let mut far = cross(h);
        while twin[far as usize] >= 0 {
            far = cross(twin[far as usize]);
        }
        place[far as usize]
    };
    border.iter().map(far_end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two quads side by side: half-edge 1 of the first is half-edge 7 of the second.
    const PAIR: [i32; 8] = [-1, 7, -1, -1, -1, -1, -1, 1];

    #[test]
    fn a_strand_passes_both_quads() {
        assert_eq!(walk(&PAIR, 3), [3, 7, 5]);
        assert_eq!(walk(&PAIR, 0), [0, 2]);
    }

    #[test]
    fn strands_end_across() {
        let border = [0, 4, 5, 6, 2, 3];
        assert_eq!(find_far_ends(&PAIR, &border), [4, 3, 5, 1, 0, 2]);
    }

    #[test]
    fn a_loop_ends_before_its_first_edge() {
        let ring = [-1, 7, -1, 5, -1, 3, -1, 1];
        assert_eq!(walk(&ring, 3), [3, 7]);
    }
}
