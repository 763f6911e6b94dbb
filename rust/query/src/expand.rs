//! Expansion: a pattern and the widths of its polychords become quads.
//!
//! Each quad of the pattern becomes a grid, as many quads along an edge as the polychord across the
//! edge is wide; grids are glued along the pattern's edges (Marcias et al. 2015, section 4).

use patterndb_core::halfedge::{fans, next_border_edge};

/// The vertices along a half-edge, its ends excluded: vertex `t` of `1..width` has the number
/// `origin + sign * t`.
#[derive(Clone, Copy)]
struct EdgeVertices {
    origin: i32,
    sign: i32,
}

impl EdgeVertices {
    fn at(self, t: i32) -> i32 {
        self.origin + self.sign * t
    }
}

/// Return the quads of an expanded pattern and the number of their vertices.
///
/// `twin` and `across` have an element for each half-edge of the pattern: its twin, and the width of
/// the polychord that crosses it; half-edge 0 is on the border. `perimeter` is that of the expanded
/// pattern. Its boundary vertex `first`, counted from the tail of half-edge 0, becomes vertex 0;
/// `mirrored`, the vertices before it follow, and quads are turned over.
pub fn expand_quads(
    twin: &[i32],
    across: &[i32],
    perimeter: i32,
    first: i32,
    mirrored: bool,
) -> (Vec<[i32; 4]>, i32) {
    let (vertex, n_corners) = fans(twin);
    let mut name = vec![-1; n_corners as usize];
    let mut along = vec![EdgeVertices { origin: 0, sign: 1 }; twin.len()];
    let mut count = 0;
    let mut h = 0;
    loop {
        name[vertex[h] as usize] = count;
        along[h].origin = count;
        count += across[h];
        h = next_border_edge(twin, h as i32) as usize;
        if h == 0 {
            break;
        }
    }
    for name in name.iter_mut().filter(|name| **name < 0) {
        *name = count;
        count += 1;
    }
    for (h, &t) in twin.iter().enumerate() {
        if t > h as i32 {
            along[h].origin = count - 1;
            along[t as usize] = EdgeVertices {
                origin: count - 1 + across[h],
                sign: -1,
            };
            count += across[h] - 1;
        }
    }

    let total = across
        .chunks_exact(4)
        .map(|quad| (quad[0] * quad[1]) as usize)
        .sum();
    let mut quads = Vec::with_capacity(total);
    let mut grid = Grid::default();
    for f in (0..twin.len()).step_by(4) {
        let corners = [0, 1, 2, 3].map(|e| name[vertex[f + e] as usize]);
        let sides = [along[f], along[f + 1], along[f + 2], along[f + 3]];
        grid.number(across[f], across[f + 1], corners, sides, &mut count);
        grid.list_quads(&mut quads);
    }
    for quad in &mut quads {
        for v in quad.iter_mut().filter(|v| **v < perimeter) {
            let moved = if mirrored { first - *v } else { *v - first };
            *v = moved.rem_euclid(perimeter);
        }
        if mirrored {
            quad.swap(1, 3);
        }
    }
    (quads, count)
}

/// The vertices of the grid that a quad of the pattern becomes, row by row along its first edge.
#[derive(Default)]
struct Grid {
    vertices: Vec<i32>,
    width: usize,
    height: usize,
}

impl Grid {
    /// Number the vertices of a grid of `width` x `height` quads; inner ones are new, from `count`
    /// on.
    fn number(
        &mut self,
        width: i32,
        height: i32,
        corners: [i32; 4],
        sides: [EdgeVertices; 4],
        count: &mut i32,
    ) {
        (self.width, self.height) = (width as usize, height as usize);
        self.vertices.clear();
        self.vertices.reserve((self.width + 1) * (self.height + 1));
        for j in 0..=height {
            for i in 0..=width {
                let vertex = match (i, j) {
                    (0, 0) => corners[0],
                    (0, _) if j == height => corners[3],
                    (_, 0) if i == width => corners[1],
                    _ if i == width && j == height => corners[2],
                    (_, 0) => sides[0].at(i),
                    (0, _) => sides[3].at(height - j),
                    _ if i == width => sides[1].at(j),
                    _ if j == height => sides[2].at(width - i),
                    _ => {
                        *count += 1;
                        *count - 1
                    }
                };
                self.vertices.push(vertex);
            }
        }
    }

    fn list_quads(&self, quads: &mut Vec<[i32; 4]>) {
        let row = self.width + 1;
        for j in 0..self.height {
            let (low, high) = self.vertices[j * row..(j + 2) * row].split_at(row);
            for i in 0..self.width {
                quads.push([low[i], low[i + 1], high[i + 1], high[i]]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_becomes_a_grid_with_its_boundary_first() {
        let (quads, n_vertices) = expand_quads(&[-1; 4], &[2, 2, 2, 2], 8, 0, false);
        assert_eq!(n_vertices, 9);
        assert_eq!(
            quads,
            [[0, 1, 8, 7], [1, 2, 3, 8], [7, 8, 5, 6], [8, 3, 4, 5]]
        );
    }

    #[test]
    fn mirrored_it_runs_the_other_way() {
        let (quads, _) = expand_quads(&[-1; 4], &[1, 1, 1, 1], 4, 1, true);
        assert_eq!(quads, [[1, 2, 3, 0]]);
    }
}
