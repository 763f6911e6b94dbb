//! Patterns of any number of sides in one table: what marked patterns are made of.

use patterndb_core::halfedge::{fans, next_edge};

/// Return for each pattern whether no two edges join the same two vertices when every polychord is 1
/// wide.
///
/// Pattern i has the code `flat[offsets[i]..offsets[i + 1]]`.
pub fn meshes(flat: &[u16], offsets: &[i64]) -> Vec<bool> {
    let codes = offsets.windows(2);
    codes
        .map(|ends| is_mesh(&flat[ends[0] as usize..ends[1] as usize]))
        .collect()
}

fn is_mesh(code: &[u16]) -> bool {
    let twin: Vec<i32> = code.iter().map(|&symbol| i32::from(symbol) - 1).collect();
    let (vertex, n_vertices) = fans(&twin);
    let vertex_of = |h: i32| vertex[h as usize];
    // The half-edges so far, by their tails; few leave one vertex.
    let mut leaving: Vec<Option<usize>> = vec![None; n_vertices as usize];
    let mut after = vec![None; twin.len()];
    for (h, &tail) in vertex.iter().enumerate() {
        let ahead = next_edge(h as i32);
        let head = vertex_of(ahead);
        if head == tail || vertex_of(next_edge(ahead)) == tail {
            return false;
        }
        let first = &mut leaving[tail as usize];
        let mut others = std::iter::successors(*first, |&other| after[other]);
        if others.any(|other| vertex_of(next_edge(other as i32)) == head) {
            return false;
        }
        after[h] = *first;
        *first = Some(h);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_joined_to_itself_is_no_mesh() {
        let flat = [0, 0, 0, 0, 0, 4, 0, 2];
        assert_eq!(meshes(&flat, &[0, 4, 8]), [true, false]);
    }
}
