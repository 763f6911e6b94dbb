//! The adjacency of a surface: triangles across edges, and how they are turned.
//!
//! Side 3 f + e is the edge of triangle f from its corner e to the next. Surfaces are taken as they
//! are: an edge may have any number of triangles, and neighbours may be turned against each other.

use crate::Point;
use crate::vector::{dot, length, subtract};

/// A triangle, by the numbers of its vertices.
pub type Triangle = [i32; 3];

/// What is added to the fold of two triangles that are turned against each other: above any fold,
/// so that they come behind all that are turned alike.
const AGAINST: f64 = 4.0;

/// The triangles of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// The vertices.
    pub vertices: &'a [Point],
    /// The triangles.
    pub triangles: &'a [Triangle],
}

/// The edges of a surface, and the sides that each has.
#[derive(Clone, Copy, Debug)]
pub struct Edges<'a> {
    /// The middle of each edge.
    pub middles: &'a [Point],
    /// The two vertices of each edge.
    pub ends: &'a [[i32; 2]],
    /// The edge of each side.
    pub edges: &'a [i32],
    /// The first place of each edge in the list of sides, and the list's length.
    pub side_start: &'a [i32],
    /// The sides, edge by edge.
    pub sides: &'a [i32],
}

impl<'a> Edges<'a> {
    /// Return the sides of an edge.
    #[inline]
    pub fn sides_of(&self, edge: usize) -> &'a [i32] {
        &self.sides[self.side_start[edge] as usize..self.side_start[edge + 1] as usize]
    }
}

/// Return three items, of a triangle's corners, from a corner on.
#[inline(always)]
pub fn from_corner<T: Copy>([a, b, c]: [T; 3], corner: usize) -> [T; 3] {
    match corner {
        0 => [a, b, c],
        1 => [b, c, a],
        _ => [c, a, b],
    }
}

/// Return the corners of a side's triangle: those at the side's ends, and the opposite one.
#[inline(always)]
pub fn side_corners(triangles: &[Triangle], side: i32) -> [i32; 3] {
    let side = side as usize;
    from_corner(triangles[side / 3], side % 3)
}

/// Return for each side the one that is the same edge seen from the neighbour, -1 at a border.
///
/// The sides of edge k are `sides[start[k]..start[k + 1]]`. Where more than two triangles share an
/// edge, those that continue each other most straightly are neighbours, of those that are turned
/// alike if there are.
pub fn pair_sides(
    vertices: &[Point],
    triangles: &[Triangle],
    start: &[i32],
    sides: &[i32],
) -> Vec<i32> {
    let surface = Surface {
        vertices,
        triangles,
    };
    let mut across = vec![-1; sides.len()];
    let mut join = |one: i32, two: i32| {
        across[one as usize] = two;
        across[two as usize] = one;
    };
    for bounds in start.windows(2) {
        match &sides[bounds[0] as usize..bounds[1] as usize] {
            [] | [_] => {}
            &[one, two] => join(one, two),
            group => {
                for (one, two) in pair_straightest(surface, group) {
                    join(one, two);
                }
            }
        }
    }
    across
}

/// Return pairs of the sides of an edge, the straightest first.
fn pair_straightest(surface: Surface<'_>, group: &[i32]) -> Vec<(i32, i32)> {
    let away: Vec<Point> = group
        .iter()
        .map(|&side| point_away(surface, side))
        .collect();
    let tails = surface.triangles.as_flattened();
    let tail = |i: usize| tails[group[i] as usize];
    let mut free: Vec<usize> = (0..group.len()).collect();
    let mut pairs = Vec::with_capacity(group.len() / 2);
    while free.len() > 1 {
        let mut best = f64::INFINITY;
        let mut found = None;
        for (k, &i) in free.iter().enumerate() {
            for &j in &free[k + 1..] {
                let mut fold = dot(&away[i], &away[j]);
                if tail(i) == tail(j) {
                    fold += AGAINST;
                }
                if fold < best {
                    best = fold;
                    found = Some((i, j));
                }
            }
        }
        let Some((i, j)) = found else {
            break;
        };
        free.retain(|&k| k != i && k != j);
        pairs.push((group[i], group[j]));
    }
    pairs
}

/// Return the unit direction from a side into its triangle, at right angles to it.
fn point_away(surface: Surface<'_>, side: i32) -> Point {
    let corners = side_corners(surface.triangles, side);
    let [a, b, c] = corners.map(|v| &surface.vertices[v as usize]);
    let (edge, other) = (subtract(b, a), subtract(c, a));
    let share = dot(&other, &edge) / dot(&edge, &edge);
    let away = [0, 1, 2].map(|k| other[k] - share * edge[k]);
    let height = length(&away);
    if height > 0.0 {
        away.map(|x| x / height)
    } else {
        away
    }
}

/// Return the component of each triangle, and whether it is turned over against the component's first.
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
    fn two_triangles_are_neighbours_over_their_edge() {
        let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let triangles = [[0, 1, 2], [2, 1, 3]];
        // Edges 0-1, 0-2, 1-2, 1-3, 2-3.
        let across = pair_sides(
            &vertices,
            &triangles,
            &[0, 1, 2, 4, 5, 6],
            &[0, 2, 1, 3, 4, 5],
        );
        assert_eq!(across, [-1, 3, -1, 1, -1, -1]);
    }

    #[test]
    fn of_three_triangles_the_straightest_two_are_neighbours() {
        let vertices = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.5, 1.0, 0.0],
            [0.5, -1.0, 0.1],
            [0.5, 0.0, 1.0],
        ];
        let triangles = [[0, 1, 2], [0, 1, 4], [1, 0, 3]];
        let start = [0, 3, 4, 5, 6, 7, 8, 9];
        let sides = [0, 3, 6, 1, 2, 4, 5, 7, 8];
        let across = pair_sides(&vertices, &triangles, &start, &sides);
        assert_eq!((across[0], across[3], across[6]), (6, -1, 0));
    }

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
