//! Fills that are paved from the loop inwards, ring by ring.
//!
//! The quads at the loop's vertices determine all quads that touch the loop: a ring. What the ring
//! leaves is a loop, too. Where every vertex of it gets what makes it regular, the next ring follows,
//! and so on until a fill with one irregular vertex, or none, fits the rest.

use super::{Fill, fill_walk};
use crate::holes::REGULAR;

/// The quads of rings, and the loop that they leave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Paving {
    /// The quads' vertices; those of the first loop come first, in order.
    pub quads: Vec<[i32; 4]>,
    /// The vertices of the loop that is left, in order.
    pub inner: Vec<i32>,
    /// The quads at each of these.
    pub counts: Vec<i32>,
    /// The number of vertices.
    pub n_vertices: usize,
}

/// Lay rings, at most as many as given, in a loop with these 1 to 4 quads at each vertex.
///
/// A ring is laid quad by quad along a front, which is the loop at first. A vertex of the loop that
/// lacks one quad gets it between the front's edges before and after; where none does, a quad is
/// laid behind an edge of the front. Before the next ring, vertices with four quads are closed: the
/// two edges of the front there become one. None where no quads fit.
pub fn pave(corners: &[i32], rings: usize) -> Option<Paving> {
    let mut front = Front::new(corners);
    let mut laid = 0;
    while front.length > 0 {
        if front.quads.len() >= front.most {
            return None;
        }
        match front.find_place() {
            Some(Place::Corner(v)) => front.lay_corner(v)?,
            Some(Place::Edge(v)) => front.lay_behind(v)?,
            None => {
                laid += 1;
                if laid == rings {
                    break;
                }
                front.begin_ring()?;
            }
        }
    }
    Some(front.finish(corners.len()))
}

/// Quads at a vertex of the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quads {
    /// A vertex of the ring's loop: quads that are to come.
    Lacks(i32),
    /// Any other: quads that came.
    Has(i32),
}

use Quads::{Has, Lacks};

/// A vertex that is or was on the front.
#[derive(Clone, Copy)]
struct Vertex {
    before: usize,
    after: usize,
    quads: Quads,
    /// Itself, or a vertex that it has become one with.
    same: usize,
}

/// Where the next quad is laid.
enum Place {
    /// Between the two edges at a vertex.
    Corner(usize),
    /// Behind the edge after a vertex.
    Edge(usize),
}

/// The front, and all that lies behind it.
struct Front {
    /// The front's vertices are linked, others are left over.
    vertices: Vec<Vertex>,
    quads: Vec<[usize; 4]>,
    /// A vertex of the front, where searches begin.
    head: usize,
    /// The number of the front's vertices.
    length: usize,
    /// Paving that takes more quads does not end.
    most: usize,
}

impl Front {
    fn new(corners: &[i32]) -> Front {
        let n = corners.len();
        let vertex = |(i, &quads)| Vertex {
            before: (i + n - 1) % n,
            after: (i + 1) % n,
            quads: Lacks(quads),
            same: i,
        };
        Front {
            vertices: corners.iter().enumerate().map(vertex).collect(),
            quads: Vec::new(),
            head: 0,
            length: n,
            most: n * n / 8 + 4 * n,
        }
    }

    fn before(&self, v: usize) -> usize {
        self.vertices[v].before
    }

    fn after(&self, v: usize) -> usize {
        self.vertices[v].after
    }

    fn lacks_one(&self, v: usize) -> bool {
        self.vertices[v].quads == Lacks(1)
    }

    /// Iterate over the front's vertices, from the head on.
    fn walk(&self) -> impl Iterator<Item = usize> {
        let next = |&v: &usize| Some(self.after(v));
        std::iter::successors(Some(self.head), next).take(self.length)
    }

    /// Make one vertex of the front follow another.
    fn link(&mut self, v: usize, w: usize) {
        self.vertices[v].after = w;
        self.vertices[w].before = v;
    }

    /// Make a vertex with one quad, which is to be linked.
    fn add_vertex(&mut self) -> usize {
        let v = self.vertices.len();
        self.vertices.push(Vertex {
            before: v,
            after: v,
            quads: Has(1),
            same: v,
        });
        v
    }

    /// Count quads that were laid at a vertex of the front; None where it lacks no more.
    fn count_quads(&mut self, v: usize, laid: i32) -> Option<()> {
        match &mut self.vertices[v].quads {
            Has(count) => *count += laid,
            Lacks(count) => {
                *count -= laid;
                if *count <= 0 {
                    return None;
                }
            }
        }
        Some(())
    }

    /// Return where to lay a quad: at the first vertex that lacks one, or behind the edge after the
    /// last that lacks more. None where the ring is complete.
    fn find_place(&self) -> Option<Place> {
        let mut place = None;
        for v in self.walk() {
            match self.vertices[v].quads {
                Lacks(1) => return Some(Place::Corner(v)),
                Lacks(_) => place = Some(Place::Edge(v)),
                Has(_) => {}
            }
        }
        place
    }

    /// Lay a quad behind the edge after a vertex that lacks two or more. Its other edges join the
    /// front.
    fn lay_behind(&mut self, v: usize) -> Option<()> {
        let w = self.after(v);
        let (x, y) = (self.add_vertex(), self.add_vertex());
        self.quads.push([v, w, y, x]);
        self.link(v, x);
        self.link(x, y);
        self.link(y, w);
        self.length += 2;
        self.head = v;
        if let Lacks(count) = &mut self.vertices[v].quads {
            *count -= 1;
        }
        self.count_quads(w, 1)
    }

    /// Lay the last quad of a vertex, which leaves the front.
    fn lay_corner(&mut self, v: usize) -> Option<()> {
        let v = self.choose_in_row(v);
        let (u, w) = (self.before(v), self.after(v));
        let (last, following) = (self.lacks_one(u), self.lacks_one(w));
        let p = if self.length == 4 {
            self.close_quad(u, w)?
        } else if last && following {
            self.join_ends(u, w)?
        } else if last {
            let p = self.before(u);
            self.close_side(p, w)?;
            p
        } else if following {
            let p = self.after(w);
            self.close_side(u, p)?;
            p
        } else {
            self.add_side(u, w)?
        };
        self.quads.push([u, v, w, p]);
        self.drop_pair()
    }

    /// Return the vertex to begin with in a row of vertices that lack one quad each: that of a quad
    /// with all three of a row is the middle one.
    fn choose_in_row(&self, mut v: usize) -> usize {
        if self.length <= 4 {
            return v;
        }
        for _ in 0..2 {
            let a = self.after(v);
            if !(self.lacks_one(a) && self.lacks_one(self.after(a))) {
                break;
            }
            v = a;
        }
        let u = self.before(v);
        let is_last = !self.lacks_one(self.after(v));
        if is_last && self.lacks_one(u) && self.lacks_one(self.before(u)) {
            v = u;
        }
        v
    }

    /// Return the fourth vertex of a front of four edges, which a quad closes.
    fn close_quad(&mut self, u: usize, w: usize) -> Option<usize> {
        let p = self.after(w);
        self.length = 0;
        let fits = |&v: &usize| matches!(self.vertices[v].quads, Has(_) | Lacks(1));
        [u, w, p].iter().all(fits).then_some(p)
    }

    /// Join the vertices before `u` and after `w`, where a quad has three vertices that lack one:
    /// they are its fourth. Return it.
    fn join_ends(&mut self, u: usize, w: usize) -> Option<usize> {
        let (p, other) = (self.before(u), self.after(w));
        let (left, right) = (self.before(p), self.after(other));
        let (p, other, joined) = match (self.vertices[p].quads, self.vertices[other].quads) {
            (_, Has(joined)) => (p, other, joined),
            (Has(joined), _) => (other, p, joined),
            _ => return None,
        };
        self.vertices[other].same = p;
        self.link(left, p);
        self.link(p, right);
        self.length -= 4;
        self.head = p;
        self.count_quads(p, joined + 1)?;
        Some(p)
    }

    /// Make the edge from `start` to `end` the fourth side of a quad.
    fn close_side(&mut self, start: usize, end: usize) -> Option<()> {
        self.link(start, end);
        self.length -= 2;
        self.lay_between(start, end)
    }

    /// Make a vertex the fourth of a quad at `u` and `w`; return it.
    fn add_side(&mut self, u: usize, w: usize) -> Option<usize> {
        let p = self.add_vertex();
        self.link(u, p);
        self.link(p, w);
        self.lay_between(u, w)?;
        Some(p)
    }

    /// Count a quad at two vertices, the second of which becomes the head.
    fn lay_between(&mut self, start: usize, end: usize) -> Option<()> {
        self.head = end;
        self.count_quads(start, 1)?;
        self.count_quads(end, 1)
    }

    /// Close a front of two edges, which are one; None where one of its vertices lacks quads.
    fn drop_pair(&mut self) -> Option<()> {
        if self.length > 2 {
            return Some(());
        }
        let lacks = |v: usize| matches!(self.vertices[v].quads, Lacks(_));
        if self.walk().any(lacks) {
            return None;
        }
        self.length = 0;
        Some(())
    }

    /// Return the quads that came to a vertex; 0 where it is of the ring's loop.
    fn count(&self, v: usize) -> i32 {
        match self.vertices[v].quads {
            Has(count) => count,
            Lacks(_) => 0,
        }
    }

    /// Make the front, whose ring is complete, the loop of the next one; or fill it. None where it
    /// does not turn to the left.
    fn begin_ring(&mut self) -> Option<()> {
        let corner = |v: usize| Corner {
            vertex: v,
            lacks: REGULAR - self.count(v),
        };
        let rim: Vec<Corner> = self.walk().map(corner).collect();
        let turning: i32 = rim.iter().map(|corner| 2 - corner.lacks).sum();
        if turning <= 0 {
            return None;
        }
        if (3..=5).contains(&turning)
            && let Some(rest) = fill_rest(&rim, turning - 4)
            && self.quads.len() + rest.fill.quads.len() <= self.most
        {
            self.take_rest(&rest);
            return Some(());
        }
        self.close_full_vertices();
        if self.length <= 2 {
            self.length = 0;
            return Some(());
        }
        for v in self.walk().collect::<Vec<_>>() {
            self.vertices[v].quads = Lacks(REGULAR - self.count(v));
        }
        if self.length == 4 {
            let (u, v) = (self.before(self.head), self.head);
            let w = self.after(v);
            self.quads.push([u, v, w, self.after(w)]);
            self.length = 0;
        }
        Some(())
    }

    /// Close the front by a fill.
    fn take_rest(&mut self, rest: &Rest) {
        for &(v, other) in &rest.joined {
            self.vertices[v].same = other;
        }
        let first = self.vertices.len();
        let m = rest.rim.len();
        let name = |v: i32| match rest.rim.get(v as usize) {
            Some(&vertex) => vertex,
            None => first + v as usize - m,
        };
        let quads = rest.fill.quads.iter().map(|quad| quad.map(name));
        self.quads.extend(quads);
        for _ in m..rest.fill.n_vertices {
            self.add_vertex();
        }
        self.length = 0;
    }

    /// Join the edges before and after vertices that have four quads.
    fn close_full_vertices(&mut self) {
        let mut v = self.head;
        let mut passed = 0;
        while self.length > 2 && passed < self.length {
            if self.count(v) < REGULAR {
                v = self.after(v);
                passed += 1;
                continue;
            }
            let (u, x) = (self.before(v), self.after(v));
            self.vertices[u].quads = Has(self.count(u) + self.count(x));
            self.vertices[x].same = u;
            self.link(u, self.after(x));
            self.length -= 2;
            (self.head, v) = (u, u);
            passed = 0;
        }
    }

    /// Return the vertex that a vertex has become one with.
    fn find_same(&self, mut v: usize) -> usize {
        while self.vertices[v].same != v {
            v = self.vertices[v].same;
        }
        v
    }

    /// Number the vertices, those of the first loop, `0..n`, as they are.
    fn finish(&self, n: usize) -> Paving {
        let mut number: Vec<i32> = (0..n as i32).collect();
        let mut n_vertices = n;
        for (v, vertex) in self.vertices.iter().enumerate().skip(n) {
            let is_first = vertex.same == v;
            number.push(if is_first { n_vertices as i32 } else { -1 });
            n_vertices += usize::from(is_first);
        }
        let name = |v: usize| number[self.find_same(v)];
        Paving {
            quads: self.quads.iter().map(|quad| quad.map(name)).collect(),
            inner: self.walk().map(|v| number[v]).collect(),
            counts: self.walk().map(|v| self.count(v)).collect(),
            n_vertices,
        }
    }
}

/// A vertex of a loop, and the quads that it lacks to be regular.
#[derive(Clone, Copy, Debug)]
struct Corner {
    vertex: usize,
    lacks: i32,
}

/// A fill of a loop, some of whose vertices become one before.
struct Rest {
    /// Pairs of vertices of which the first becomes one with the second.
    joined: Vec<(usize, usize)>,
    /// The vertices of the loop that is left, which the fill numbers from 0.
    rim: Vec<usize>,
    fill: Fill,
}

/// Fill a loop with one irregular vertex on it, which gets `off` more quads than it lacks, or with
/// none where `off` is 0.
fn fill_rest(rim: &[Corner], off: i32) -> Option<Rest> {
    let irregular = if off == 0 { 0..1 } else { 0..rim.len() };
    irregular
        .into_iter()
        .find_map(|i| fill_with_irregular(rim.to_vec(), i, off))
}

/// Fill a loop of which vertex `i` gets `off` more quads than it lacks.
fn fill_with_irregular(mut rim: Vec<Corner>, i: usize, off: i32) -> Option<Rest> {
    rim[i].lacks += off;
    let mut joined = Vec::new();
    while rim.len() > 2
        && let Some(j) = rim.iter().position(|corner| corner.lacks == 0)
    {
        // No quad is left for a vertex: the edges before and after it become one.
        let (u, x) = ((j + rim.len() - 1) % rim.len(), (j + 1) % rim.len());
        joined.push((rim[x].vertex, rim[u].vertex));
        rim[u].lacks += rim[x].lacks - REGULAR;
        rim.remove(j.max(x));
        rim.remove(j.min(x));
    }
    let lacks: Vec<i32> = rim.iter().map(|corner| corner.lacks).collect();
    let fill = if rim.len() == 2 {
        let empty = Fill {
            quads: Vec::new(),
            n_vertices: 2,
        };
        (lacks == [0, 0]).then_some(empty)?
    } else if lacks.iter().all(|lacks| (1..=REGULAR).contains(lacks)) {
        fill_walk(&lacks)?
    } else {
        return None;
    };
    Some(Rest {
        joined,
        rim: rim.iter().map(|corner| corner.vertex).collect(),
        fill,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_is_paved_ring_by_ring() {
        // Three by three quads: a ring of eight leaves a loop of four edges.
        let corners = [1, 2, 2, 1, 2, 2, 1, 2, 2, 1, 2, 2];
        let ring = pave(&corners, 1).unwrap();
        assert_eq!((ring.quads.len(), ring.inner.len()), (8, 4));
        assert_eq!(ring.counts, [3; 4]);
        assert_eq!(ring.n_vertices, 16);
        let whole = pave(&corners, 1_000_000).unwrap();
        assert_eq!((whole.quads.len(), whole.n_vertices), (9, 16));
        assert!(whole.inner.is_empty());
    }

    #[test]
    fn five_corners_meet_at_a_vertex_of_five_quads() {
        let paved = pave(&[1, 2, 1, 2, 1, 2, 1, 2, 1, 2], 1_000_000).unwrap();
        assert_eq!((paved.quads.len(), paved.n_vertices), (5, 11));
        let counts = |v: i32| {
            paved
                .quads
                .as_flattened()
                .iter()
                .filter(|&&w| w == v)
                .count()
        };
        assert_eq!(counts(10), 5);
    }

    #[test]
    fn quads_that_do_not_fit_are_not_laid() {
        assert_eq!(pave(&[1, 1, 3, 1], 1), None);
        assert_eq!(pave(&[2; 8], 1_000_000), None);
    }
}
