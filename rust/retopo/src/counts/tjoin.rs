//! Minimum-weight perfect matchings of complete graphs.
//!
//! They are exact, by blossoms: Edmonds, "Paths, trees, and flowers" (1965), with dual variables and
//! one forest of all single vertices at a time, as described by Galil, "Efficient algorithms for
//! finding maximum matching in graphs" (1986). A *node* is a vertex or a blossom: an odd cycle of
//! nodes, shrunk. The top nodes are those in no blossom. In the forest, even nodes lie at even
//! distance from a single one, odd nodes at odd distance; the others are out of it.
//!
//! Edges are compared at vertices: every vertex keeps its tightest edge to an even vertex of another
//! top node. Edges within a blossom drop out by themselves when it forms, so that no edges between
//! nodes are stored.

use std::mem;

/// Pair n vertices such that the sum of weights is least: return the partner of each.
///
/// `weights`: n rows of n, symmetric; n is even and above 0, and weights are 0 to 2^58. Of several
/// least matchings it is always the same one.
pub fn match_vertices(weights: &[i64], n: usize) -> Vec<i32> {
    let mut forest = Forest::new(weights, n);
    for _ in 0..n / 2 {
        forest.grow();
    }
    forest.mate.iter().map(|&v| v as i32).collect()
}

/// No vertex, no node.
const NONE: usize = usize::MAX;

/// Where a node is in the forest.
#[derive(Clone, Copy, PartialEq)]
enum Label {
    Out,
    Even,
    Odd,
}

/// An odd cycle of nodes.
#[derive(Clone, Default)]
struct Blossom {
    /// The nodes of the cycle, from the one with the base; none where the blossom is not in use.
    kids: Vec<usize>,
    /// The edge from each kid to the next: a vertex of it, a vertex of the next.
    links: Vec<[usize; 2]>,
    /// At least 0: twice what the inner edges may exceed their weight by.
    surplus: i64,
}

/// n vertices and room for n / 2 blossoms; blossom b is node n + b.
struct Forest {
    n: usize,
    /// n rows of n: twice the weights.
    weight: Vec<i64>,
    /// Of each vertex; `dual[u] + dual[v] <= weight[u][v]` where the top nodes differ, equal along
    /// edges of forest and matching.
    dual: Vec<i64>,
    /// The partner of each vertex or NONE.
    mate: Vec<usize>,
    /// The top node of each vertex.
    top: Vec<usize>,
    /// The even vertex of each vertex's tightest edge or NONE.
    tightest: Vec<usize>,
    blossoms: Vec<Blossom>,
    /// The blossom that each node lies in, or NONE.
    up: Vec<usize>,
    /// The vertex of each node that is not matched within it.
    base: Vec<usize>,
    label: Vec<Label>,
    /// Of each odd node the edge of the forest to it: the vertex before, the vertex in it.
    entry: Vec<[usize; 2]>,
}

/// What stops a change of the duals.
enum Event {
    /// The tightest edge of a vertex has no room left.
    Tight(usize),
    /// An odd blossom has no surplus left.
    Spent(usize),
}

impl Forest {
    fn new(weights: &[i64], n: usize) -> Forest {
        let m = n + n / 2;
        let weight: Vec<i64> = weights.iter().map(|w| 2 * w).collect();
        let below = (1..n).flat_map(|u| &weight[n * u..n * u + u]);
        let least = below.copied().min().unwrap_or(0);
        Forest {
            n,
            weight,
            // All equal: then the duals of even vertices keep one parity, and halves are whole.
            dual: vec![least / 2; n],
            mate: vec![NONE; n],
            top: (0..n).collect(),
            tightest: vec![NONE; n],
            blossoms: vec![Blossom::default(); n / 2],
            up: vec![NONE; m],
            base: (0..m).collect(),
            label: vec![Label::Out; m],
            entry: vec![[NONE; 2]; m],
        }
    }

    /// Return the partner of a node's base, or NONE.
    fn partner(&self, node: usize) -> usize {
        self.mate[self.base[node]]
    }

    /// Return what an edge from the even vertex u leaves of its weight for the dual of v.
    fn slack(&self, u: usize, v: usize) -> i64 {
        self.weight[self.n * u + v] - self.dual[u]
    }

    /// Grow the forest of all single vertices until two more vertices can be matched.
    fn grow(&mut self) {
        self.label.fill(Label::Out);
        self.tightest.fill(NONE);
        for v in 0..self.n {
            if self.mate[v] == NONE {
                self.label[self.top[v]] = Label::Even;
            }
        }
        for v in 0..self.n {
            if self.label[self.top[v]] == Label::Even {
                self.offer(v);
            }
        }
        loop {
            let (step, event) = self.next_event();
            self.change_duals(step);
            let v = match event {
                Event::Spent(blossom) => {
                    self.open_up(blossom);
                    continue;
                }
                Event::Tight(v) => v,
            };
            let u = self.tightest[v];
            if self.label[self.top[v]] == Label::Out {
                self.enter(u, v);
            } else if self.root(u) != self.root(v) {
                self.flip(u, v);
                self.flip(v, u);
                self.mate[u] = v;
                self.mate[v] = u;
                return;
            } else {
                self.shrink(u, v);
            }
        }
    }

    /// Return by how much the duals may change, and what stops them.
    fn next_event(&mut self) -> (i64, Event) {
        let mut found: Option<(i64, Event)> = None;
        let mut take = |room: i64, event: Event| {
            if found.as_ref().is_none_or(|(least, _)| room < *least) {
                found = Some((room, event));
            }
        };
        for v in 0..self.n {
            let label = self.label[self.top[v]];
            if label == Label::Odd {
                continue;
            }
            let mut u = self.tightest[v];
            if u != NONE && self.top[u] == self.top[v] {
                u = self.look(v);
            }
            if u == NONE {
                continue;
            }
            let room = self.slack(u, v) - self.dual[v];
            let both = label == Label::Even;
            take(
                if both { room.div_euclid(2) } else { room },
                Event::Tight(v),
            );
        }
        for (blossom, b) in self.blossoms.iter().zip(self.n..) {
            if self.is_top(blossom, b) && self.label[b] == Label::Odd {
                take(blossom.surplus.div_euclid(2), Event::Spent(b));
            }
        }
        found.expect("single vertices of a complete graph have edges")
    }

    fn is_top(&self, blossom: &Blossom, b: usize) -> bool {
        !blossom.kids.is_empty() && self.up[b] == NONE
    }

    fn change_duals(&mut self, step: i64) {
        for (dual, &top) in self.dual.iter_mut().zip(&self.top) {
            match self.label[top] {
                Label::Even => *dual += step,
                Label::Odd => *dual -= step,
                Label::Out => (),
            }
        }
        for row in 0..self.blossoms.len() {
            let b = self.n + row;
            if self.is_top(&self.blossoms[row], b) {
                match self.label[b] {
                    Label::Even => self.blossoms[row].surplus += 2 * step,
                    Label::Odd => self.blossoms[row].surplus -= 2 * step,
                    Label::Out => (),
                }
            }
        }
    }

    /// Return the tightest edge of v among all even vertices: the former one is within its node.
    fn look(&mut self, v: usize) -> usize {
        let mut found = NONE;
        for u in 0..self.n {
            if self.label[self.top[u]] == Label::Even
                && self.top[u] != self.top[v]
                && (found == NONE || self.slack(u, v) < self.slack(found, v))
            {
                found = u;
            }
        }
        self.tightest[v] = found;
        found
    }

    /// Offer the even vertex u to all vertices of other nodes.
    fn offer(&mut self, u: usize) {
        let (n, within, dual) = (self.n, self.top[u], self.dual[u]);
        let row = &self.weight[n * u..n * u + n];
        for (v, weight) in row.iter().enumerate() {
            let top = self.top[v];
            if top == within {
                continue;
            }
            let t = self.tightest[v];
            // What is in one node with v is of no use to it any more.
            if t == NONE || self.top[t] == top || weight - dual < self.slack(t, v) {
                self.tightest[v] = u;
            }
        }
    }

    /// Make a node even.
    fn make_even(&mut self, node: usize) {
        self.label[node] = Label::Even;
        for v in 0..self.n {
            if self.top[v] == node {
                self.offer(v);
            }
        }
    }

    /// Make a node out of the forest odd, by the edge (u, v), and its partner even.
    fn enter(&mut self, u: usize, v: usize) {
        let node = self.top[v];
        self.label[node] = Label::Odd;
        self.entry[node] = [u, v];
        self.make_even(self.top[self.partner(node)]);
    }

    /// Return the even node two edges above an even node that is matched.
    fn above(&self, node: usize) -> usize {
        let odd = self.top[self.partner(node)];
        self.top[self.entry[odd][0]]
    }

    /// Return the single vertex of the tree of an even vertex.
    fn root(&self, v: usize) -> usize {
        let mut node = self.top[v];
        while self.partner(node) != NONE {
            node = self.above(node);
        }
        self.base[node]
    }

    /// Match along the tree from the even vertex u to its root, so that u is free for v.
    fn flip(&mut self, mut u: usize, mut v: usize) {
        loop {
            let node = self.top[u];
            let before = self.partner(node);
            self.rebase(node, u);
            self.mate[u] = v;
            if before == NONE {
                return;
            }
            let odd = self.top[before];
            [u, v] = self.entry[odd];
            self.rebase(odd, v);
            self.mate[v] = u;
        }
    }

    /// Return the place, in the cycle of blossom b, of the node that holds a vertex.
    fn kid_with(&self, b: usize, vertex: usize) -> usize {
        let mut node = vertex;
        while self.up[node] != b {
            node = self.up[node];
        }
        let kids = &self.blossoms[b - self.n].kids;
        let place = kids.iter().position(|&kid| kid == node);
        place.expect("a node is in the cycle of its blossom")
    }

    /// Match within a node so that it is the vertex that is left for an edge outwards.
    fn rebase(&mut self, node: usize, vertex: usize) {
        let n = self.n;
        let mut todo = vec![(node, vertex)];
        while let Some((b, vertex)) = todo.pop() {
            if b < n {
                continue;
            }
            let j = self.kid_with(b, vertex);
            self.base[b] = vertex;
            let Blossom { kids, links, .. } = &mut self.blossoms[b - n];
            todo.push((kids[j], vertex));
            // Kids 1 and 2 are matched, 3 and 4, and so on. From an even place the pairs go round
            // downwards, from an odd one upwards, until they take in the kid that was the base.
            let k = kids.len();
            let pairs = if j.is_multiple_of(2) { 0..j } else { j + 1..k };
            for i in pairs.step_by(2) {
                let [here, there] = links[i];
                self.mate[here] = there;
                self.mate[there] = here;
                todo.extend([(kids[i], here), (kids[(i + 1) % k], there)]);
            }
            kids.rotate_left(j);
            links.rotate_left(j);
        }
    }

    /// Make the cycle that the edge (u, v) closes in a tree a blossom, even.
    fn shrink(&mut self, u: usize, v: usize) {
        let mut seen = vec![false; self.up.len()];
        let mut node = self.top[u];
        seen[node] = true;
        while self.partner(node) != NONE {
            node = self.above(node);
            seen[node] = true;
        }
        let mut stem = self.top[v];
        while !seen[stem] {
            stem = self.above(stem);
        }
        let row = self.blossoms.iter().position(|b| b.kids.is_empty());
        let row = row.expect("there are n / 2 blossoms at most");
        let b = self.n + row;
        // Down from the stem to u: found upwards, and turned round.
        let (mut kids, mut links) = self.climb(self.top[u], stem);
        kids.push(stem);
        kids.reverse();
        links.reverse();
        for link in &mut links {
            link.reverse();
        }
        links.push([u, v]);
        let (more_kids, more_links) = self.climb(self.top[v], stem);
        kids.extend(more_kids);
        links.extend(more_links);
        self.base[b] = self.base[stem];
        self.up[b] = NONE;
        self.label[b] = Label::Even;
        for &kid in &kids {
            self.up[kid] = b;
        }
        self.blossoms[row] = Blossom {
            kids,
            links,
            surplus: 0,
        };
        let mut were_odd = Vec::new();
        for w in 0..self.n {
            let node = self.top[w];
            if self.up[node] == b {
                if self.label[node] == Label::Odd {
                    were_odd.push(w);
                }
                self.top[w] = b;
            }
        }
        for w in were_odd {
            self.offer(w);
        }
    }

    /// Return the nodes from an even node to below the stem, and their edges upwards.
    fn climb(&self, mut node: usize, stem: usize) -> (Vec<usize>, Vec<[usize; 2]>) {
        let (mut kids, mut links) = (Vec::new(), Vec::new());
        while node != stem {
            let odd = self.top[self.partner(node)];
            let [above, inside] = self.entry[odd];
            kids.extend([node, odd]);
            links.extend([[self.base[node], self.partner(node)], [inside, above]]);
            node = self.top[above];
        }
        (kids, links)
    }

    /// Dissolve an odd blossom without surplus: its kids are top nodes again.
    fn open_up(&mut self, b: usize) {
        let [mut before, mut inside] = self.entry[b];
        let mut j = self.kid_with(b, inside);
        let Blossom { kids, links, .. } = mem::take(&mut self.blossoms[b - self.n]);
        let k = kids.len();
        for &kid in &kids {
            self.label[kid] = Label::Out;
            self.up[kid] = NONE;
        }
        for v in 0..self.n {
            if self.top[v] == b {
                let mut node = v;
                while self.up[node] != NONE {
                    node = self.up[node];
                }
                self.top[v] = node;
            }
        }
        // From where the tree enters to the base, round the side that begins with a matched edge.
        let down = j.is_multiple_of(2);
        loop {
            let odd = kids[j];
            self.label[odd] = Label::Odd;
            self.entry[odd] = [before, inside];
            if j == 0 {
                return;
            }
            let even;
            if down {
                (even, j) = (j - 1, j - 2);
                [inside, before] = links[j];
            } else {
                (even, j) = (j + 1, (j + 2) % k);
                [before, inside] = links[even];
            }
            self.make_even(kids[even]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Return the least sum of weights over all perfect matchings.
    fn least(weights: &[i64], n: usize, left: &[usize]) -> i64 {
        let Some((&u, rest)) = left.split_first() else {
            return 0;
        };
        let sums = (0..rest.len()).map(|i| {
            let mut others = rest.to_vec();
            let v = others.remove(i);
            weights[n * u + v] + least(weights, n, &others)
        });
        sums.min().unwrap()
    }

    #[test]
    fn matchings_are_the_cheapest_of_all() {
        let mut state = 1_u64;
        for n in [2, 4, 6, 8] {
            for _ in 0..100 {
                let mut weights = vec![0; n * n];
                for u in 0..n {
                    for v in 0..u {
                        state = state
                            .wrapping_mul(6_364_136_223_846_793_005)
                            .wrapping_add(1);
                        weights[n * u + v] = (state >> 60) as i64;
                        weights[n * v + u] = weights[n * u + v];
                    }
                }
                let mate = match_vertices(&weights, n);
                let sum: i64 = (0..n).map(|u| weights[n * u + mate[u] as usize]).sum();
                assert!((0..n).all(|u| mate[mate[u] as usize] == u as i32));
                let every: Vec<usize> = (0..n).collect();
                assert_eq!(sum, 2 * least(&weights, n, &every));
            }
        }
    }
}
