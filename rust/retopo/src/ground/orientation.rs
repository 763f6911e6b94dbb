//! The parts of a surface, and which of their triangles are turned against the first.

/// Return the part of each triangle, and whether it is turned over against its part's first one.
///
/// across: for each side 3 f + e the other of its edge, -1 without; corner: the vertex at which
/// each side begins.
pub fn walk_parts(across: &[i32], corner: &[i32]) -> (Vec<i32>, Vec<bool>) {
    let sides = across.as_chunks::<3>().0;
    let mut part = vec![-1; sides.len()];
    let mut over = vec![false; sides.len()];
    let mut parts = 0;
    let mut stack = Vec::with_capacity(sides.len());
    for first in 0..sides.len() {
        if part[first] >= 0 {
            continue;
        }
        part[first] = parts;
        stack.push(first as i32);
        while let Some(triangle) = stack.pop() {
            let f = triangle as usize;
            for (e, &other) in sides[f].iter().enumerate() {
                if other < 0 || part[other as usize / 3] >= 0 {
                    continue;
                }
                let g = other as usize / 3;
                part[g] = parts;
                // Two that are turned alike pass their edge in opposite ways.
                over[g] = over[f] ^ (corner[3 * f + e] == corner[other as usize]);
                stack.push(other / 3);
            }
        }
        parts += 1;
    }
    (part, over)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_that_passes_its_edge_the_same_way_is_turned_over() {
        // Triangles (0, 1, 2), (1, 2, 3) and one apart; the first two share sides 1 and 3.
        let across = [-1, 3, -1, 1, -1, -1, -1, -1, -1];
        let corner = [0, 1, 2, 1, 2, 3, 4, 5, 6];
        let (part, over) = walk_parts(&across, &corner);
        assert_eq!(part, [0, 0, 1]);
        assert_eq!(over, [false, true, false]);
    }
}
