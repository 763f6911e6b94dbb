//! Orientation and components of quad meshes.

/// Reverse quads in place so that neighbours agree, breadth-first from each component's first quad.
///
/// `quads` are vertices. The half-edges `pairs[start[q]..start[q + 1]]` are those of quad q over
/// edges that exactly two quads use, each with the half-edge on the other side. Reversing a quad's
/// corners reads it from the other side.
pub fn flip_to_agree(quads: &mut [[i32; 4]], start: &[i64], pairs: &[[i64; 2]]) {
    let mut seen = vec![false; quads.len()];
    let mut flip = vec![false; quads.len()];
    let mut queue = Vec::with_capacity(quads.len());
    for root in 0..quads.len() {
        if seen[root] {
            continue;
        }
        seen[root] = true;
        queue.clear();
        queue.push(root);
        let mut head = 0;
        while head < queue.len() {
            let quad = queue[head];
            head += 1;
            for &[here, across] in &pairs[start[quad] as usize..start[quad + 1] as usize] {
                let other = (across >> 2) as usize;
                if seen[other] {
                    continue;
                }
                seen[other] = true;
                // The half-edges run the same way exactly if their tails agree.
                let same_way =
                    quads[quad][(here & 3) as usize] == quads[other][(across & 3) as usize];
                flip[other] = flip[quad] != same_way;
                queue.push(other);
            }
        }
    }
    for (quad, _) in quads.iter_mut().zip(flip).filter(|(_, flip)| *flip) {
        quad.reverse();
    }
}

/// Return the component of every quad, numbered by their first quads.
pub fn components(twin: &[i32]) -> Vec<i32> {
    let (quads, _) = twin.as_chunks::<4>();
    let mut component = vec![-1; quads.len()];
    let mut stack = Vec::new();
    let mut count = 0;
    for root in 0..quads.len() {
        if component[root] >= 0 {
            continue;
        }
        component[root] = count;
        stack.push(root);
        while let Some(quad) = stack.pop() {
            for &t in quads[quad].iter().filter(|&&t| t >= 0) {
                let other = (t >> 2) as usize;
                if component[other] < 0 {
                    component[other] = count;
                    stack.push(other);
                }
            }
        }
        count += 1;
    }
    component
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quads_without_common_edges_are_components() {
        let pair_and_single = [-1, 7, -1, -1, -1, -1, -1, 1, -1, -1, -1, -1];
        assert_eq!(components(&pair_and_single), [0, 0, 1]);
    }

    #[test]
    fn a_neighbour_of_the_other_sense_is_reversed() {
        // Both run from 1 to 2 along their common edge.
        let mut quads = [[0, 1, 2, 3], [1, 2, 5, 4]];
        flip_to_agree(&mut quads, &[0, 1, 2], &[[1, 4], [4, 1]]);
        assert_eq!(quads, [[0, 1, 2, 3], [4, 5, 2, 1]]);
    }
}
