//! Shortest ways over a surface, between the middles of edges.

use patterndb_geometry::Point;
use patterndb_geometry::vector::{dot, length, max, subtract};

use super::heap::Heap;
use patterndb_geometry::adjacency::Edges;

/// A point in a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// The triangle.
    pub triangle: i32,
    /// The point.
    pub point: &'a Point,
}

/// How each edge was reached, and behind them the goal.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// The edge before it; -1 for one that is first, or was not reached.
    pub before: Vec<i32>,
    /// The side that the way leaves its triangle by.
    pub leaves: Vec<i32>,
    /// The side that it leaves the triangle before by, if the step leads through two; else -1.
    pub via: Vec<i32>,
}

/// The ways found so far, and what is to be looked at next.
struct Search {
    far: Vec<f64>,
    done: Vec<bool>,
    route: Route,
    heap: Heap,
}

impl Search {
    /// Take a step to an edge, or the goal, if it is the shortest so far; `ahead` returns what is
    /// left from there at least.
    fn reach(
        &mut self,
        to: usize,
        far: f64,
        before: i32,
        (leaves, via): (i32, i32),
        ahead: impl FnOnce() -> f64,
    ) {
        if far < self.far[to] {
            self.far[to] = far;
            self.route.before[to] = before;
            self.route.leaves[to] = leaves;
            self.route.via[to] = via;
            self.heap.push(far + ahead(), to as i32);
        }
    }
}

/// Return how far apart two points are.
fn apart(a: &Point, b: &Point) -> f64 {
    length(&subtract(a, b))
}

/// Return how far apart two points are in triangles on both sides of an edge, laid flat.
fn apart_over([a, b]: [&Point; 2], one: &Point, two: &Point) -> f64 {
    let (u, x, y) = (subtract(b, a), subtract(one, a), subtract(two, a));
    let (size, first, second) = (dot(&u, &u), dot(&u, &x), dot(&u, &y));
    let height = |squared: f64, along: f64| max(squared - along * along / size, 0.0).sqrt();
    let high = height(dot(&x, &x), first) + height(dot(&y, &y), second);
    let along = second - first;
    (along * along / size + high * high).sqrt()
}

/// Find the shortest way from a point in one triangle to a point in another by straight steps
/// through one triangle, or two laid flat, between the middles of edges.
///
/// Edges of more than two triangles lead to all of them. The search is A*: nearest first by the way
/// so far and the straight way on.
pub fn search_route(
    vertices: &[Point],
    edges: Edges<'_>,
    start: Place<'_>,
    end: Place<'_>,
) -> Route {
    let middles = edges.middles;
    let goal = middles.len();
    let mut search = Search {
        far: vec![f64::INFINITY; goal + 1],
        done: vec![false; goal + 1],
        route: Route {
            before: vec![-1; goal + 1],
            leaves: vec![-1; goal + 1],
            via: vec![-1; goal + 1],
        },
        heap: Heap::new(),
    };
    let to_end = |edge: usize| apart(&middles[edge], end.point);
    for side in 3 * start.triangle..3 * start.triangle + 3 {
        let k = edges.edges[side as usize] as usize;
        search.far[k] = apart(&middles[k], start.point);
        search.route.leaves[k] = side;
        search.heap.push(search.far[k] + to_end(k), k as i32);
    }
    while let Some((_, item)) = search.heap.pop() {
        let k = item as usize;
        if search.done[k] {
            continue;
        }
        search.done[k] = true;
        if k == goal {
            break;
        }
        let (here, far) = (&middles[k], search.far[k]);
        for &side in edges.sides_of(k) {
            let triangle = side / 3;
            if triangle == search.route.leaves[k] / 3 {
                continue;
            }
            if triangle == end.triangle {
                search.reach(goal, far + to_end(k), item, (side, -1), || 0.0);
                continue;
            }
            for out in 3 * triangle..3 * triangle + 3 {
                let m = edges.edges[out as usize] as usize;
                if m == k {
                    continue;
                }
                if !search.done[m] {
                    let reached = far + apart(&middles[m], here);
                    search.reach(m, reached, item, (out, -1), || to_end(m));
                }
                let ends = edges.ends[m].map(|v| &vertices[v as usize]);
                for &beyond in edges.sides_of(m) {
                    let next = beyond / 3;
                    if next == triangle || next == end.triangle {
                        continue;
                    }
                    for leaves in 3 * next..3 * next + 3 {
                        let o = edges.edges[leaves as usize] as usize;
                        if o == m || search.done[o] {
                            continue;
                        }
                        let reached = far + apart_over(ends, here, &middles[o]);
                        search.reach(o, reached, item, (leaves, out), || to_end(o));
                    }
                }
            }
        }
    }
    search.route
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_over_two_edges_is_found() {
        // A strip of three triangles; edges 0-1, 0-2, 1-2, 1-3, 2-3, 2-4, 3-4.
        let vertices: Vec<Point> = [[0, 0], [0, 1], [1, 0], [1, 1], [2, 0]]
            .iter()
            .map(|&[x, y]| [f64::from(x), f64::from(y), 0.0])
            .collect();
        let ends = [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3], [2, 4], [3, 4]];
        let middles = ends.map(|pair: [i32; 2]| {
            let [a, b] = pair.map(|v| vertices[v as usize]);
            [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]))
        });
        // Triangles (0, 2, 1), (1, 2, 3), (3, 2, 4).
        let edges = Edges {
            middles: &middles,
            ends: &ends,
            edges: &[1, 2, 0, 2, 4, 3, 4, 5, 6],
            side_start: &[0, 1, 2, 4, 5, 7, 8, 9],
            sides: &[2, 0, 1, 3, 5, 4, 6, 7, 8],
        };
        let start = Place {
            triangle: 0,
            point: &[0.1, 0.1, 0.0],
        };
        let end = Place {
            triangle: 2,
            point: &[1.6, 0.2, 0.0],
        };
        let route = search_route(&vertices, edges, start, end);
        assert_eq!((route.before[7], route.leaves[7]), (4, 6));
        assert_eq!((route.before[4], route.leaves[4]), (2, 4));
        assert_eq!((route.before[2], route.leaves[2]), (-1, 1));
    }
}
