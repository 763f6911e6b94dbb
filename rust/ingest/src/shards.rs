//! Cutting a mesh into shards of neighbouring quads, so that several cores can share it.

/// Return the quads of a part by distance from `root`; unconnected ones follow theirs.
///
/// `inside` marks the quads of the part among those of the mesh.
pub fn breadth_first(twin: &[i32], root: i32, inside: &[bool], part: &[i32]) -> Vec<i32> {
    let (quads, _) = twin.as_chunks::<4>();
    let mut order = Vec::with_capacity(part.len());
    let mut reached = vec![false; inside.len()];
    let mut head = 0;
    for &start in std::iter::once(&root).chain(part) {
        if std::mem::replace(&mut reached[start as usize], true) {
            continue;
        }
        order.push(start);
        while head < order.len() {
            let quad = order[head];
            head += 1;
            for &t in quads[quad as usize].iter().filter(|&&t| t >= 0) {
                let other = (t >> 2) as usize;
                if inside[other] && !reached[other] {
                    reached[other] = true;
                    order.push(t >> 2);
                }
            }
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unconnected_quads_follow() {
        // A pair, and a quad of its own.
        let twin = [-1, 7, -1, -1, -1, -1, -1, 1, -1, -1, -1, -1];
        assert_eq!(breadth_first(&twin, 1, &[true; 3], &[0, 1, 2]), [1, 0, 2]);
        assert_eq!(
            breadth_first(&twin, 1, &[false, true, true], &[1, 2]),
            [1, 2]
        );
    }
}
