//! The tree of boxes over triangles, and the walks down it.
//!
//! The questions are in the modules [`crate::proximity`] (what is nearest or near) and
//! [`crate::casting`] (what lines hit).

use crate::sorting::argsort;
use crate::vector::{Point, max, min};

/// Triangles in a leaf, at most.
const LEAF: usize = 4;

/// The three corners of a triangle.
pub type Triangle = [Point; 3];

/// The lower and the upper corner of a box.
pub type Bounds = [Point; 2];

/// A box whose corners lie beyond everything: the box of no points.
const NOTHING: Bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];

/// Triangles and the boxes around them.
#[derive(Clone, Copy, Debug)]
pub struct Tree<'a> {
    /// The triangles.
    pub corners: &'a [Triangle],
    /// The boxes; the first is around everything.
    pub boxes: &'a [Bounds],
    /// For each box (first child, -1), the other child being the next box, or of a leaf (its first
    /// place in the order, its number of triangles).
    pub nodes: &'a [[i32; 2]],
    /// The triangles' numbers, those of a leaf in a row.
    pub order: &'a [i32],
}

/// The arrays of a [`Tree`] besides its triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boxes {
    /// See [`Tree::boxes`].
    pub boxes: Vec<Bounds>,
    /// See [`Tree::nodes`].
    pub nodes: Vec<[i32; 2]>,
    /// See [`Tree::order`].
    pub order: Vec<i32>,
}

impl Boxes {
    /// Return the tree of the triangles that these boxes were built for.
    pub fn tree<'a>(&'a self, corners: &'a [Triangle]) -> Tree<'a> {
        Tree {
            corners,
            boxes: &self.boxes,
            nodes: &self.nodes,
            order: &self.order,
        }
    }
}

/// Build the boxes: each is halved, by the number of its triangles, across the axis along which
/// their middles lie farthest apart.
pub fn build(corners: &[Triangle]) -> Boxes {
    let mut order: Vec<i32> = (0..corners.len() as i32).collect();
    let mut boxes = Vec::new();
    let mut nodes = vec![[0, corners.len() as i32]];
    let mut at = 0;
    while at < nodes.len() {
        let [first, n] = nodes[at].map(|x| x as usize);
        let inside = &mut order[first..first + n];
        let (bounds, middles) = measure(corners, inside);
        boxes.push(bounds);
        if n > LEAF {
            sort_along(corners, inside, longest_axis(&middles));
            nodes[at] = [nodes.len() as i32, -1];
            let half = n / 2;
            nodes.push([first as i32, half as i32]);
            nodes.push([(first + half) as i32, (n - half) as i32]);
        }
        at += 1;
    }
    Boxes {
        boxes,
        nodes,
        order,
    }
}

/// Return the box of some triangles and the box of their middles.
fn measure(corners: &[Triangle], triangles: &[i32]) -> (Bounds, Bounds) {
    let (mut bounds, mut middles) = (NOTHING, NOTHING);
    for &f in triangles {
        let triangle = &corners[f as usize];
        for c in 0..3 {
            let mut middle = 0.0;
            for corner in triangle {
                middle += corner[c] / 3.0;
                include(&mut bounds, c, corner[c]);
            }
            include(&mut middles, c, middle);
        }
    }
    (bounds, middles)
}

fn include([low, high]: &mut Bounds, c: usize, x: f64) {
    low[c] = min(low[c], x);
    high[c] = max(high[c], x);
}

/// Return the axis along which a box is longest, the first of equal ones.
fn longest_axis([low, high]: &Bounds) -> usize {
    let length = |c: usize| high[c] - low[c];
    (1..3).fold(0, |best, c| if length(c) > length(best) { c } else { best })
}

/// Sort triangles by the middles of their corners along an axis.
fn sort_along(corners: &[Triangle], triangles: &mut [i32], axis: usize) {
    let middle = |&f: &i32| {
        let [a, b, c] = &corners[f as usize];
        a[axis] + b[axis] + c[axis]
    };
    let middles: Vec<f64> = triangles.iter().map(middle).collect();
    let sorted: Vec<i32> = argsort(&middles)
        .into_iter()
        .map(|k| triangles[k])
        .collect();
    triangles.copy_from_slice(&sorted);
}

/// A question to a tree, with the best answer so far.
pub trait Search {
    /// Return how far a box is; of two boxes the nearer is opened first.
    fn measure(&self, bounds: &Bounds) -> f64;

    /// Return whether a box can be left out, given its measure.
    fn is_beyond(&self, bounds: &Bounds, far: f64) -> bool;

    /// Look at a triangle of a leaf.
    fn visit(&mut self, triangle: i32);
}

impl<'a> Tree<'a> {
    /// Walk to the leaves that may hold the answer, the nearer box first, of equal ones the first.
    ///
    /// `stack` is scratch, which many walks share.
    #[inline(always)]
    pub fn search(&self, stack: &mut Vec<(i32, f64)>, search: &mut impl Search) {
        stack.clear();
        stack.push((0, search.measure(&self.boxes[0])));
        while let Some((b, far)) = stack.pop() {
            let b = b as usize;
            if search.is_beyond(&self.boxes[b], far) {
                continue;
            }
            let [first, n] = self.nodes[b];
            if n >= 0 {
                for &triangle in self.leaf(first, n) {
                    search.visit(triangle);
                }
                continue;
            }
            let one = (first, search.measure(&self.boxes[first as usize]));
            let other = (first + 1, search.measure(&self.boxes[first as usize + 1]));
            if one.1 > other.1 {
                stack.extend([one, other]);
            } else {
                stack.extend([other, one]);
            }
        }
    }

    /// Return the triangles of the leaves whose boxes, and all boxes around them, are chosen; of
    /// two children those of the second come first.
    #[inline(always)]
    pub fn select(
        &self,
        stack: &'a mut Vec<i32>,
        is_chosen: impl Fn(&Bounds) -> bool + 'a,
    ) -> impl Iterator<Item = i32> + 'a {
        let tree = *self;
        stack.clear();
        stack.push(0);
        let leaves = std::iter::from_fn(move || {
            while let Some(b) = stack.pop() {
                if !is_chosen(&tree.boxes[b as usize]) {
                    continue;
                }
                let [first, n] = tree.nodes[b as usize];
                if n >= 0 {
                    return Some(tree.leaf(first, n));
                }
                stack.extend([first, first + 1]);
            }
            None
        });
        leaves.flatten().copied()
    }

    fn leaf(&self, first: i32, n: i32) -> &'a [i32] {
        &self.order[first as usize..(first + n) as usize]
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A lattice of small triangles, n by n, each at the height of its number.
    pub(crate) fn lattice(n: usize) -> Vec<Triangle> {
        let triangle = |k: usize| {
            let (x, y, z) = ((k % n) as f64, (k / n) as f64, k as f64);
            [[x, y, z], [x + 0.5, y, z], [x, y + 0.5, z]]
        };
        (0..n * n).map(triangle).collect()
    }

    #[test]
    fn each_triangle_lies_in_its_leaf_and_each_box_in_its_parent() {
        let corners = lattice(9);
        let Boxes {
            boxes,
            nodes,
            order,
        } = build(&corners);
        let holds =
            |[low, high]: &Bounds, p: &Point| (0..3).all(|c| low[c] <= p[c] && p[c] <= high[c]);
        let mut met = vec![0; corners.len()];
        for (b, &[first, n]) in nodes.iter().enumerate() {
            if n < 0 {
                for child in [first, first + 1] {
                    for corner in &boxes[child as usize] {
                        assert!(holds(&boxes[b], corner));
                    }
                }
                continue;
            }
            assert!(n as usize <= LEAF);
            for &f in &order[first as usize..(first + n) as usize] {
                met[f as usize] += 1;
                assert!(corners[f as usize].iter().all(|p| holds(&boxes[b], p)));
            }
        }
        assert!(met.into_iter().all(|times| times == 1));
    }

    #[test]
    fn no_triangles_have_one_empty_leaf() {
        let made = build(&[]);
        assert_eq!(made.nodes, [[0, 0]]);
        assert!(made.order.is_empty());
    }

    #[test]
    fn all_boxes_chosen_give_all_triangles() {
        let corners = lattice(5);
        let made = build(&corners);
        let mut found: Vec<i32> = made
            .tree(&corners)
            .select(&mut Vec::new(), |_| true)
            .collect();
        found.sort_unstable();
        assert!(found.into_iter().eq(0..25));
    }
}
