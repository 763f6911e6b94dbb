//! Faces of a mesh that are turned alike, and the loops of its border.

/// The faces of a mesh and what is across their edges. Half-edges are numbered face after face.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a> {
    /// The face of each half-edge.
    pub face: &'a [i32],
    /// The half-edge on the other side of its edge, negative where there is none.
    pub twin: &'a [i32],
    /// The first half-edge of each face, and how many half-edges there are.
    pub start: &'a [i64],
}

impl Faces<'_> {
    /// Return the number of faces.
    fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Iterate over the half-edges of a face that have a twin, and the faces across them.
    fn across(&self, f: usize) -> impl Iterator<Item = (usize, usize)> {
        let half_edges = self.start[f] as usize..self.start[f + 1] as usize;
        half_edges.filter_map(|h| {
            let twin = usize::try_from(self.twin[h]).ok()?;
            Some((h, self.face[twin] as usize))
        })
    }
}

/// Return which faces to read backwards so that neighbours agree, or a half-edge whose faces cannot.
///
/// `same` holds for half-edges that run the same way as their twin. The first face of a component is
/// read as it is, unless more than half of the faces would then be read backwards. Where a half-edge
/// is returned, the flags are not complete.
pub fn turn_alike(faces: Faces, same: &[bool]) -> (Vec<bool>, Option<usize>) {
    let mut flip = vec![false; faces.len()];
    let mut seen = vec![false; faces.len()];
    let mut members = Vec::with_capacity(faces.len());
    let mut stack = Vec::with_capacity(faces.len());
    for root in 0..faces.len() {
        if seen[root] {
            continue;
        }
        seen[root] = true;
        stack.push(root);
        members.clear();
        let mut turned = 0;
        while let Some(f) = stack.pop() {
            members.push(f);
            turned += usize::from(flip[f]);
            for (h, other) in faces.across(f) {
                let wanted = flip[f] != same[h];
                if !seen[other] {
                    seen[other] = true;
                    flip[other] = wanted;
                    stack.push(other);
                } else if flip[other] != wanted {
                    return (flip, Some(h));
                }
            }
        }
        if 2 * turned > members.len() {
            for &f in &members {
                flip[f] = !flip[f];
            }
        }
    }
    (flip, None)
}

/// Return the loops of border half-edges: the half-edges, loop after loop, and where each begins.
///
/// A loop has the hole on its right and runs as the hole does: its vertex `i` is the head of its
/// half-edge `i`. A walk that reaches a crowded edge, of more than two faces, or a walk that was
/// begun further on, is no loop and ends with -1.
pub fn walk_borders(
    border: &[i32],
    twin: &[i32],
    previous: &[i32],
    crowded: &[bool],
) -> (Vec<i32>, Vec<i64>) {
    let mut left = vec![false; twin.len()];
    for &h in border {
        left[h as usize] = true;
    }
    // Around the tail of h, by the faces outside, to the border half-edge that arrives there.
    let arriving = |h: i32| {
        let mut h = previous[h as usize];
        while twin[h as usize] >= 0 {
            h = previous[twin[h as usize] as usize];
        }
        h
    };
    let mut loops = Vec::with_capacity(border.len() + 1);
    let mut starts = vec![0];
    for &first in border {
        if !left[first as usize] {
            continue;
        }
        let mut h = first;
        loop {
            left[h as usize] = false;
            loops.push(h);
            h = arriving(h);
            if h == first {
                break;
            }
            if crowded[h as usize] || !left[h as usize] {
                loops.push(-1);
                break;
            }
        }
        starts.push(loops.len() as i64);
    }
    (loops, starts)
}

/// Return the faces that are reached from a face by way of edges, ascending, with itself.
pub fn flood(root: usize, faces: Faces) -> Vec<i64> {
    let mut seen = vec![false; faces.len()];
    seen[root] = true;
    let mut stack = vec![root];
    while let Some(f) = stack.pop() {
        for (_, other) in faces.across(f) {
            if !seen[other] {
                seen[other] = true;
                stack.push(other);
            }
        }
    }
    (0..)
        .zip(seen)
        .filter_map(|(f, seen)| seen.then_some(f))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles 0 1 2 and 2 1 3, then one that touches neither.
    const PAIR: Faces = Faces {
        face: &[0, 0, 0, 1, 1, 1, 2, 2, 2],
        twin: &[-1, 3, -1, 1, -1, -1, -1, -1, -1],
        start: &[0, 3, 6, 9],
    };

    #[test]
    fn components_are_flooded_and_turned_on_their_own() {
        assert_eq!(flood(1, PAIR), [0, 1]);
        assert_eq!(flood(2, PAIR), [2]);
        let mut same = [false; 9];
        assert_eq!(turn_alike(PAIR, &same), (vec![false; 3], None));
        (same[1], same[3]) = (true, true);
        assert_eq!(turn_alike(PAIR, &same), (vec![false, true, false], None));
        same[3] = false;
        assert_eq!(turn_alike(PAIR, &same).1, Some(3));
    }

    #[test]
    fn the_border_of_a_pair_is_a_loop_against_its_faces() {
        let previous = [2, 0, 1, 5, 3, 4];
        let border = [0, 2, 4, 5];
        let (loops, starts) = walk_borders(&border, &PAIR.twin[..6], &previous, &[false; 6]);
        assert_eq!((loops, starts), (vec![0, 2, 5, 4], vec![0, 4]));
        let crowded = [false, false, true, false, false, false];
        let (loops, starts) = walk_borders(&[0, 4, 5], &PAIR.twin[..6], &previous, &crowded);
        assert_eq!(
            (loops, starts),
            (vec![0, -1, 4, -1, 5, -1], vec![0, 2, 4, 6])
        );
    }
}
