//! Fills without irregular vertices inside, from walks on the square lattice.
//!
//! The number of quads at each loop vertex determines such a fill. The loop walks along the edges of
//! the lattice: it turns left at a vertex with one quad, goes straight on at two, turns right at
//! three and back at four.
//!
//! Where a loop is no such walk, rings of quads are laid along it until what is left is one.

mod rings;

pub use rings::{Paving, pave};

/// Quads of a loop's fill. The loop's vertices come first, in order, then inner ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fill {
    /// The vertices of each quad.
    pub quads: Vec<[i32; 4]>,
    /// The number of vertices of the loop and inside.
    pub n_vertices: usize,
}

/// A direction on the lattice, by quarter turns to the left from the first axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Direction(i32);

impl Direction {
    /// Return the direction after as many quarter turns to the left, from 0 to 3.
    fn new(quarters: i32) -> Direction {
        Direction(quarters & 3)
    }

    /// Return the direction after a vertex with this many quads.
    fn turn(self, quads: i32) -> Direction {
        Direction::new(self.0 + 2 - quads)
    }

    /// Return the next point in this direction.
    fn step(self, [x, y]: [i32; 2]) -> [i32; 2] {
        match self.0 {
            0 => [x + 1, y],
            1 => [x, y + 1],
            2 => [x - 1, y],
            _ => [x, y - 1],
        }
    }
}

/// A closed walk on the lattice: for each loop vertex its point and the direction of the edge after
/// it. The least coordinates are 0.
struct Walk {
    points: Vec<[i32; 2]>,
    directions: Vec<Direction>,
    /// The greatest coordinates.
    extent: [i32; 2],
}

impl Walk {
    /// Return the walk of a loop with these quads at its vertices, if it is closed.
    fn new(corners: &[i32]) -> Option<Walk> {
        let mut point = [0, 0];
        let mut direction = Direction(0);
        let mut points = Vec::with_capacity(corners.len());
        let mut directions = Vec::with_capacity(corners.len());
        for (i, &quads) in corners.iter().enumerate() {
            if i > 0 {
                direction = direction.turn(quads);
            }
            points.push(point);
            directions.push(direction);
            point = direction.step(point);
        }
        if point != [0, 0] {
            return None;
        }
        let [mut low, mut high] = [[0, 0]; 2];
        for point in &points {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        for [x, y] in &mut points {
            (*x, *y) = (*x - low[0], *y - low[1]);
        }
        let extent = [high[0] - low[0], high[1] - low[1]];
        Some(Walk {
            points,
            directions,
            extent,
        })
    }

    /// Return the cells inside, row by row, if the walk winds once around each and never around
    /// another the other way. A cell has the coordinates of its least point.
    fn cells(&self) -> Option<Vec<[i32; 2]>> {
        let [width, height] = self.extent;
        let row = width as usize + 1;
        // How often the walk winds around the cell on the left of each edge that runs upwards:
        // edges from it on to the right that run upwards, less those that run downwards.
        let mut winding = vec![0; row * height as usize];
        for (&[x, y], direction) in self.points.iter().zip(&self.directions) {
            match direction.0 {
                1 => winding[y as usize * row + x as usize] += 1,
                3 => winding[(y as usize - 1) * row + x as usize] -= 1,
                _ => {}
            }
        }
        let mut cells = Vec::new();
        for (y, winding) in winding.chunks_exact_mut(row).enumerate() {
            for x in (0..width as usize).rev() {
                winding[x] += winding[x + 1];
            }
            for (x, &around) in winding[1..].iter().enumerate() {
                match around {
                    0 => {}
                    1 => cells.push([x as i32, y as i32]),
                    _ => return None,
                }
            }
        }
        Some(cells)
    }
}

/// The vertex in each quarter around each lattice point.
///
/// A lattice point that the walk passes twice, along a slit, is two vertices.
struct Quarters {
    /// The vertices in the quarters of a point, counter-clockwise from the upper right; -1 where
    /// there is none.
    vertices: Vec<[i32; 4]>,
    row: usize,
}

impl Quarters {
    fn new([width, height]: [i32; 2]) -> Quarters {
        let row = width as usize + 1;
        Quarters {
            vertices: vec![[-1; 4]; row * (height as usize + 1)],
            row,
        }
    }

    fn at(&mut self, [x, y]: [i32; 2]) -> &mut [i32; 4] {
        &mut self.vertices[y as usize * self.row + x as usize]
    }

    /// Give a walk's vertices the quarters inside; return whether no two have the same.
    fn place(&mut self, walk: &Walk, corners: &[i32]) -> bool {
        for (i, &point) in walk.points.iter().enumerate() {
            let quarters = self.at(point);
            let first = walk.directions[i].0;
            for k in first..first + corners[i] {
                let vertex = &mut quarters[k as usize & 3];
                if *vertex >= 0 {
                    return false;
                }
                *vertex = i as i32;
            }
        }
        true
    }

    /// Number the vertices at points of the cells that the walk does not pass, from `count` on;
    /// return how many vertices there are then.
    fn number_inner(&mut self, cells: &[[i32; 2]], mut count: usize) -> usize {
        let mut inside = vec![false; self.vertices.len()];
        for &[x, y] in cells {
            let at = y as usize * self.row + x as usize;
            for place in [at, at + 1, at + self.row, at + self.row + 1] {
                inside[place] = true;
            }
        }
        for (vertices, inside) in self.vertices.iter_mut().zip(inside) {
            if inside && *vertices == [-1; 4] {
                *vertices = [count as i32; 4];
                count += 1;
            }
        }
        count
    }

    /// Return the quad of a cell.
    fn quad(&mut self, [x, y]: [i32; 2]) -> [i32; 4] {
        [
            self.at([x, y])[0],
            self.at([x + 1, y])[1],
            self.at([x + 1, y + 1])[2],
            self.at([x, y + 1])[3],
        ]
    }
}

/// Return the fill that has no irregular vertex inside and these 1 to 4 quads at each loop vertex.
///
/// The walk belongs to a fill if it is closed, turns once in all, and winds once around every cell
/// inside.
pub fn fill_walk(corners: &[i32]) -> Option<Fill> {
    let turning: i32 = corners.iter().map(|quads| 2 - quads).sum();
    if turning != 4 {
        return None;
    }
    let walk = Walk::new(corners)?;
    let mut quarters = Quarters::new(walk.extent);
    if !quarters.place(&walk, corners) {
        return None;
    }
    let cells = walk.cells()?;
    let n_vertices = quarters.number_inner(&cells, corners.len());
    let quads: Vec<_> = cells.iter().map(|&cell| quarters.quad(cell)).collect();
    if quads.is_empty() || quads.as_flattened().iter().any(|&v| v < 0) {
        return None;
    }
    Some(Fill { quads, n_vertices })
}

/// How far a walk may have turned in between, in quarters to the right and to the left.
///
/// `MOST_RIGHT` and `MOST_LEFT` in query/holes/regular.py are the same.
const MOST_RIGHT: i32 = 6;
const MOST_LEFT: i32 = 10;

/// The number of turnings.
pub const TURNS: usize = (MOST_RIGHT + MOST_LEFT + 1) as usize;

/// What walks earn that cannot be closed; `_NEVER` in query/holes/regular.py is the same.
const NEVER: f32 = -1e18;

/// Logarithms of the probabilities of 1 to 4 quads at a loop vertex.
type Logs = [f64; 4];

/// Walks by the vertex that they have reached, their place and turning, and what they can earn.
struct Table {
    /// What the walk earns from each vertex on, by vertex, x, y and turning.
    rest: Vec<[f32; TURNS]>,
    /// The number of places along an axis.
    size: i32,
}

impl Table {
    fn at(&self, vertex: usize, [x, y]: [i32; 2]) -> usize {
        let size = self.size as usize;
        (vertex * size + x as usize) * size + y as usize
    }

    /// Return the most that a walk earns from a vertex and place on, for each turning before it.
    fn look_ahead(&self, vertex: usize, place: [i32; 2], logs: &Logs) -> [f32; TURNS] {
        let on_table = |axis: i32| (0..self.size).contains(&axis);
        // What the walk earns after the vertex, by its direction there.
        let ahead: [Option<&[f32; TURNS]>; 4] = [0, 1, 2, 3].map(|quarters| {
            let next = Direction(quarters).step(place);
            let is_there = next.into_iter().all(on_table);
            is_there.then(|| &self.rest[self.at(vertex + 1, next)])
        });
        let mut most = [NEVER; TURNS];
        for (turned, most) in (-MOST_RIGHT..).zip(&mut most) {
            for (quads, log) in (1..).zip(logs) {
                let now = turned + 2 - quads;
                if !(-MOST_RIGHT..=MOST_LEFT).contains(&now) {
                    continue;
                }
                let Some(ahead) = ahead[Direction::new(now).0 as usize] else {
                    continue;
                };
                let ahead = ahead[(now + MOST_RIGHT) as usize];
                if ahead > NEVER {
                    let earned = (f64::from(ahead) + log) as f32;
                    *most = if earned > *most { earned } else { *most };
                }
            }
        }
        most
    }
}

/// Return what closed walks still earn: the most of vertices `i` to `n - 1`, and then 0, from a place
/// `x`, `y` on, turned by `t - 6` quarters so far, by `i`, `x`, `y` and `t`.
///
/// `logs` has the log probabilities of 1 to 4 quads at each vertex. `i`, `x` and `y` are from 0 to
/// `n`; the walk begins in the middle.
pub fn tabulate_rest(logs: &[Logs]) -> Vec<[f32; TURNS]> {
    let n = logs.len();
    let size = n as i32 + 1;
    let middle = n as i32 / 2;
    let mut table = Table {
        rest: vec![[NEVER; TURNS]; (n + 1).pow(3)],
        size,
    };
    let end = table.at(n, [middle, middle]);
    for (turned, rest) in (-MOST_RIGHT..).zip(&mut table.rest[end]) {
        let quads = 2 - (4 - turned);
        if (1..=4).contains(&quads) {
            *rest = logs[0][quads as usize - 1] as f32;
        }
    }
    for i in (1..n).rev() {
        let far = i.min(n - i) as i32;
        for x in middle - far..=middle + far {
            let beyond = far - (x - middle).abs();
            for y in middle - beyond..=middle + beyond {
                let at = table.at(i, [x, y]);
                table.rest[at] = table.look_ahead(i, [x, y], &logs[i]);
            }
        }
    }
    table.rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_corners_are_a_quad_and_eight_edges_a_grid() {
        let quad = fill_walk(&[1, 1, 1, 1]).unwrap();
        assert_eq!((quad.quads, quad.n_vertices), (vec![[0, 1, 2, 3]], 4));
        let grid = fill_walk(&[1, 2, 1, 2, 1, 2, 1, 2]).unwrap();
        assert_eq!((grid.quads.len(), grid.n_vertices), (4, 9));
        assert_eq!(grid.quads[0], [0, 1, 8, 7]);
    }

    #[test]
    fn a_walk_that_is_open_or_turns_otherwise_has_no_fill() {
        assert_eq!(fill_walk(&[1, 2, 1, 1, 1]), None);
        assert_eq!(fill_walk(&[1, 1, 1, 2]), None);
        assert_eq!(fill_walk(&[]), None);
    }

    #[test]
    fn a_slit_is_two_vertices_at_a_point() {
        // A grid of two by two, cut open from the middle of a side to its centre.
        let grid = fill_walk(&[1, 2, 1, 2, 1, 2, 1, 1, 4, 1]).unwrap();
        assert_eq!((grid.quads.len(), grid.n_vertices), (4, 10));
    }

    #[test]
    fn the_best_closed_walk_of_four_edges_is_a_quad() {
        let logs = [[-1.0, -2.0, -3.0, -4.0]; 4];
        let rest = tabulate_rest(&logs);
        // After the first edge: at vertex 1, one place to the right of the middle.
        let at = (25 + 3 * 5 + 2) as usize;
        assert_eq!(rest[at][MOST_RIGHT as usize], -4.0);
    }
}
