//! The graphs of systems: nodes are the sides of patterns, edges the classes of polychords that join
//! them.

/// The graphs of many systems with the same number of sides.
#[derive(Clone, Copy, Debug)]
pub struct Graphs<'a> {
    /// Where the classes of each graph begin, and where those of the last end.
    pub first: &'a [i32],
    /// One side that each class joins, in the order in which a first flow fills the classes.
    pub class_i: &'a [i16],
    /// The other side.
    pub class_j: &'a [i16],
    /// For each graph a row: the claim of each side. A *claim* is a side and the sides that it is
    /// joined to; there are far fewer of them than sides of all graphs.
    pub claim: &'a [i32],
    /// Where the sides of each claim begin in `near`, and where those of the last end.
    pub near_first: &'a [i32],
    /// The sides that the side of each claim is joined to; one joined to itself is listed once.
    pub near: &'a [i16],
    /// Number of sides of every graph.
    pub n_sides: usize,
}

/// The graph of one system.
#[derive(Clone, Copy, Debug)]
pub struct Graph<'a> {
    class_i: &'a [i16],
    class_j: &'a [i16],
    /// The claim of each side.
    pub claim: &'a [i32],
    near_first: &'a [i32],
    near: &'a [i16],
}

impl<'a> Graphs<'a> {
    /// Return the graph of the system in a row.
    #[inline(always)]
    pub fn graph(&self, row: usize) -> Graph<'a> {
        let classes = self.first[row] as usize..self.first[row + 1] as usize;
        Graph {
            class_i: &self.class_i[classes.clone()],
            class_j: &self.class_j[classes],
            claim: &self.claim[row * self.n_sides..][..self.n_sides],
            near_first: self.near_first,
            near: self.near,
        }
    }
}

impl<'a> Graph<'a> {
    /// Return the number of sides.
    #[inline(always)]
    pub fn n_sides(&self) -> usize {
        self.claim.len()
    }

    /// Return the sides that each class joins.
    #[inline(always)]
    pub fn classes(&self) -> impl Iterator<Item = (usize, usize)> + 'a {
        let pairs = self.class_i.iter().zip(self.class_j);
        pairs.map(|(&i, &j)| (i as usize, j as usize))
    }

    /// Return the classes that are listed with their first side, side by side in their order.
    #[inline(always)]
    pub fn classes_by_side(&self) -> impl Iterator<Item = (usize, &'a [i16])> + 'a {
        let class_j = self.class_j;
        let mut at = 0;
        self.class_i.chunk_by(|i, j| i == j).map(move |run| {
            let others = &class_j[at..at + run.len()];
            at += run.len();
            (run[0] as usize, others)
        })
    }

    /// Return the sides that a side is joined to.
    #[inline(always)]
    pub fn near(&self, side: usize) -> impl Iterator<Item = usize> + Clone + 'a {
        let claim = self.claim[side] as usize;
        let range = self.near_first[claim] as usize..self.near_first[claim + 1] as usize;
        self.near[range].iter().map(|&side| side as usize)
    }
}

/// A square table, such as units that flow from side to side.
#[derive(Clone, Debug, Default)]
pub struct Square {
    n: usize,
    items: Vec<i32>,
}

impl Square {
    /// Return a table of n rows of zeros.
    pub fn new(n: usize) -> Square {
        let items = vec![0; n * n];
        Square { n, items }
    }

    /// Take a table, row by row.
    pub fn from_items(n: usize, items: &[i32]) -> Square {
        let items = items.to_vec();
        Square { n, items }
    }

    /// Return the table, row by row.
    pub fn items(&self) -> &[i32] {
        &self.items
    }
}

impl std::ops::Index<[usize; 2]> for Square {
    type Output = i32;

    #[inline(always)]
    fn index(&self, [i, j]: [usize; 2]) -> &i32 {
        &self.items[i * self.n + j]
    }
}

impl std::ops::IndexMut<[usize; 2]> for Square {
    #[inline(always)]
    fn index_mut(&mut self, [i, j]: [usize; 2]) -> &mut i32 {
        &mut self.items[i * self.n + j]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_graph_lists_its_classes_by_side() {
        let graphs = Graphs {
            first: &[0, 0, 3],
            class_i: &[0, 0, 2],
            class_j: &[1, 2, 2],
            claim: &[0, 0, 0, 1, 2, 3],
            near_first: &[0, 0, 2, 3, 5],
            near: &[1, 2, 0, 0, 2],
            n_sides: 3,
        };
        let graph = graphs.graph(1);
        assert!(graph.classes().eq([(0, 1), (0, 2), (2, 2)]));
        let by_side: Vec<_> = graph.classes_by_side().collect();
        assert_eq!(by_side, [(0, &[1, 2][..]), (2, &[2][..])]);
        assert!(graph.near(2).eq([0, 2]));
        assert_eq!(graphs.graph(0).classes().count(), 0);
    }
}
