//! The edges of a fill: half-edges and neighbours, straight from its quads.

/// The edges of a fill.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Neighbours {
    /// The half-edge on the other side of each, -1 on the border.
    pub twin: Vec<i32>,
    /// Where the neighbours of each vertex begin, and where those of the last end.
    pub start: Vec<i32>,
    /// The neighbours of the vertices, in a row.
    pub neighbour: Vec<i32>,
    /// The half-edge that leaves each boundary vertex along the boundary.
    pub border: Vec<i32>,
}

/// Return the edges of quads whose boundary vertices are the first `perimeter`, in order.
pub fn join(quads: &[[i32; 4]], n_vertices: usize, perimeter: usize) -> Neighbours {
    let tail = quads.as_flattened();
    let head: Vec<i32> = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [b, c, d, a])
        .collect();
    let leaving: Vec<(i32, i32)> = tail.iter().copied().zip(0..).collect();
    let leaving = Rows::group(n_vertices, &leaving);
    let mut twin = Vec::with_capacity(tail.len());
    let mut border = vec![-1; perimeter];
    // Each edge is met from both its ends: on the border, where one half-edge is, both at once.
    let mut neighbours = Vec::with_capacity(tail.len() + perimeter);
    for (h, (&a, &b)) in tail.iter().zip(&head).enumerate() {
        let mut back = leaving.row(b).iter();
        let across = back.find(|&&g| head[g as usize] == a);
        twin.push(across.copied().unwrap_or(-1));
        neighbours.push((a, b));
        if across.is_none() {
            neighbours.push((b, a));
            if let Some(border) = border.get_mut(a as usize) {
                *border = h as i32;
            }
        }
    }
    let Rows { start, items } = Rows::group(n_vertices, &neighbours);
    Neighbours {
        twin,
        start,
        neighbour: items,
        border,
    }
}

/// Items in rows, one row after another.
struct Rows {
    start: Vec<i32>,
    items: Vec<i32>,
}

impl Rows {
    /// Return the items of (row, item) pairs by row, each row in the order of the pairs.
    fn group(n_rows: usize, pairs: &[(i32, i32)]) -> Rows {
        let mut start = vec![0; n_rows + 1];
        for &(row, _) in pairs {
            start[row as usize + 1] += 1;
        }
        for row in 0..n_rows {
            start[row + 1] += start[row];
        }
        let mut place = start.clone();
        let mut items = vec![0; pairs.len()];
        for &(row, item) in pairs {
            let place = &mut place[row as usize];
            items[*place as usize] = item;
            *place += 1;
        }
        Rows { start, items }
    }

    fn row(&self, row: i32) -> &[i32] {
        let row = row as usize;
        &self.items[self.start[row] as usize..self.start[row + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_quads_have_seven_edges() {
        let made = join(&[[0, 1, 2, 3], [2, 1, 5, 4]], 6, 6);
        assert_eq!(made.twin, [-1, 4, -1, -1, 1, -1, -1, -1]);
        assert_eq!(made.neighbour.len(), 14);
        assert_eq!(made.start, [0, 2, 5, 8, 10, 12, 14]);
        assert_eq!(made.border, [0, 5, 2, 3, 7, 6]);
    }
}
