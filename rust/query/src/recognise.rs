//! Quads that fill a boundary, read as a pattern, its widths and orientation.

use patterndb_core::halfedge::next_edge;

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
    fn a_block_of_two_quads_has_two_sides_of_two_edges() {
        let twin = [-1, 7, -1, -1, -1, -1, -1, 1];
        assert_eq!(lengths(&twin, &[0, 5, 6, 3]), [2, 1, 2, 1]);
    }
}
