//! Quad connectivity as half-edges.
//!
//! Half-edge `h = 4 * quad + edge` runs from the quad's corner `edge` to the next one
//! counter-clockwise. `twin[h]` is the half-edge on the other side, -1 on the border. Corner `h` is
//! the tail of half-edge `h`.

/// Return the half-edge after `h` in its quad, counter-clockwise.
#[inline]
pub fn next_edge(h: i32) -> i32 {
    (h & !3) | ((h + 1) & 3)
}

/// Return the half-edge before `h` in its quad.
#[inline]
pub fn prev_edge(h: i32) -> i32 {
    (h & !3) | ((h + 3) & 3)
}

/// Return the vertex of every corner and the number of vertices, one for each fan of edge-connected
/// quads.
///
/// Vertices are numbered in order of first appearance. Two fans that touch at one point of the file
/// get two vertices.
pub fn fans(twin: &[i32]) -> (Vec<i32>, i32) {
    let mut vertex = vec![-1; twin.len()];
    let mut count = 0;
    for start in 0..twin.len() {
        if vertex[start] >= 0 {
            continue;
        }
        // Turn clockwise to the fan's first corner, or once round a closed fan.
        let start = start as i32;
        let mut first = start;
        loop {
            let across = twin[first as usize];
            if across < 0 {
                break;
            }
            first = next_edge(across);
            if first == start {
                break;
            }
        }
        let mut h = first;
        loop {
            vertex[h as usize] = count;
            h = twin[prev_edge(h) as usize];
            if h < 0 || h == first {
                break;
            }
        }
        count += 1;
    }
    (vertex, count)
}

/// Return for each vertex whether it lies on a border edge.
pub fn border_vertices(twin: &[i32], vertex: &[i32], n_vertices: usize) -> Vec<bool> {
    let mut border = vec![false; n_vertices];
    for h in (0..twin.len()).filter(|&h| twin[h] < 0) {
        border[vertex[h] as usize] = true;
        border[vertex[next_edge(h as i32) as usize] as usize] = true;
    }
    border
}

/// Return the border half-edge that follows border half-edge `h` along the border.
pub fn next_border_edge(twin: &[i32], h: i32) -> i32 {
    let mut h = next_edge(h);
    while twin[h as usize] >= 0 {
        h = next_edge(twin[h as usize]);
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two quads with one common edge: the second edge of the first, the fourth of the other.
    const PAIR: [i32; 8] = [-1, 7, -1, -1, -1, -1, -1, 1];

    #[test]
    fn a_pair_has_six_vertices_all_on_the_border() {
        let (vertex, count) = fans(&PAIR);
        assert_eq!(count, 6);
        assert_eq!(vertex[1], vertex[4]);
        assert_eq!(vertex[2], vertex[7]);
        assert_eq!(border_vertices(&PAIR, &vertex, 6), [true; 6]);
    }

    #[test]
    fn the_border_of_a_pair_has_six_edges() {
        let mut walked = vec![0];
        while walked.len() < 7 {
            walked.push(next_border_edge(&PAIR, walked[walked.len() - 1]));
        }
        assert_eq!(walked, [0, 4, 5, 6, 2, 3, 0]);
    }
}
