//! Candidate cycles: for each pair of curves at a node, the shortest paths that close them, and the
//! path that goes on in their plane.
//!
//! A network's curves come in both senses: half-curve 2 c is curve c from its first node, 2 c + 1
//! back.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::ops::ControlFlow;

use patterndb_geometry::vector::{Point, cross, dot, length, min};

/// From the end of a path to be found, the lengths of the ways to this many nodes, the nearest, are
/// known exactly; others are at least as far as the last of these. All pairs of nodes would take
/// memory with the square of their number, and patches are local.
const NEAR_NODES: usize = 512;

/// A curve that leaves a node less than this off the plane of a pair, as a sine, goes on in it:
/// strokes drawn freehand in a plane do.
const OFF_PLANE: f64 = 0.15;

/// Two curves whose directions have a lesser sine lie in no plane of their own.
const NO_PLANE: f64 = 0.2;

/// A path in a plane turns at a corner by more than this, in radians: the 20 degrees of a drawn one.
const PLANE_TURN: f64 = 0.3490658503988659;

/// The half-curves of a network.
#[derive(Clone, Copy, Debug)]
pub struct HalfCurves<'a> {
    /// The node from which every half-curve leaves.
    pub start: &'a [i64],
    /// The node at which it ends.
    pub end: &'a [i64],
    /// The first in `leaving` of every node, and their number.
    pub first: &'a [i64],
    /// The half-curves by the nodes that they leave.
    pub leaving: &'a [i64],
}

impl HalfCurves<'_> {
    fn end(&self, half: usize) -> usize {
        self.end[half] as usize
    }

    fn leaving(&self, node: usize) -> impl Iterator<Item = usize> {
        let leaving = &self.leaving[self.first[node] as usize..self.first[node + 1] as usize];
        leaving.iter().map(|&half| half as usize)
    }
}

/// Something that waits until all with lesser lengths are done; of equals the one with the lower
/// number is first.
#[derive(Clone, Copy)]
struct Waiting<T> {
    length: f64,
    number: usize,
    with: T,
}

impl<T> Ord for Waiting<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_length = self.length.total_cmp(&other.length);
        by_length.then(self.number.cmp(&other.number))
    }
}

impl<T> PartialOrd for Waiting<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> PartialEq for Waiting<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<T> Eq for Waiting<T> {}

/// Write the lengths of the shortest ways to a node from the nodes near it, by Dijkstra.
///
/// distance: of every node, inf on entry; written for the nodes that are met, which are listed in
/// `near`. Returns how many were met, and beyond which length ways are not known to be the shortest,
/// while none that is not known is shorter; inf where all that can be reached are known.
pub fn measure_ways(
    halves: &HalfCurves,
    lengths: &[f64],
    target: usize,
    distance: &mut [f64],
    near: &mut [i64],
) -> (usize, f64) {
    distance[target] = 0.0;
    near[0] = target as i64;
    let (mut met, mut settled) = (1, 0);
    let mut waiting = BinaryHeap::from([Reverse(Waiting {
        length: 0.0,
        number: target,
        with: (),
    })]);
    while let Some(Reverse(Waiting { length, number, .. })) = waiting.pop() {
        if length > distance[number] {
            continue;
        }
        settled += 1;
        if settled > NEAR_NODES {
            return (met, length);
        }
        for half in halves.leaving(number) {
            let (to, longer) = (halves.end(half), length + lengths[half]);
            if longer < distance[to] {
                if distance[to] == f64::INFINITY {
                    near[met] = to as i64;
                    met += 1;
                }
                distance[to] = longer;
                waiting.push(Reverse(Waiting {
                    length: longer,
                    number: to,
                    with: (),
                }));
            }
        }
    }
    (met, f64::INFINITY)
}

/// What is known of the ways to a node, from [`measure_ways`].
#[derive(Clone, Copy, Debug)]
pub struct Ways<'a> {
    /// The lengths from every node, inf where none is known.
    pub distance: &'a [f64],
    /// The least of those that are not known.
    pub farther: f64,
}

impl Ways<'_> {
    fn bound(&self, node: usize) -> f64 {
        min(self.distance[node], self.farther)
    }
}

/// Paths that begin with one half-curve, each longer than another by one half-curve.
struct Paths(Vec<PathEnd>);

struct PathEnd {
    before: Option<usize>,
    half: usize,
}

impl Paths {
    /// Return the half-curves of a path, the last first.
    fn back(&self, path: usize) -> impl Iterator<Item = usize> {
        let ends = std::iter::successors(Some(&self.0[path]), |end| {
            end.before.map(|before| &self.0[before])
        });
        ends.map(|end| end.half)
    }
}

/// Find the shortest simple cycles that leave a node by `out` and come back along `back`.
///
/// Both half-curves leave the node, are of two curves and end at two other nodes. `found` gets the
/// half-curves of every cycle in order, the shortest cycle first, until it breaks. `ways` are those
/// to the end of `back`. Returns whether `most` paths were tried before.
///
/// The remaining distance bounds a path's length from below (A*), so paths come out by length.
pub fn find_closing_paths(
    halves: &HalfCurves,
    lengths: &[f64],
    ways: Ways,
    [out, back]: [usize; 2],
    most: usize,
    mut found: impl FnMut(&[usize]) -> ControlFlow<()>,
) -> bool {
    let (node, target) = (halves.start[back] as usize, halves.end(back));
    let mut paths = Paths(vec![PathEnd {
        before: None,
        half: out,
    }]);
    let mut waiting = BinaryHeap::from([Reverse(Waiting {
        length: lengths[out] + ways.bound(halves.end(out)),
        number: 0,
        with: lengths[out],
    })]);
    while let Some(Reverse(Waiting {
        number: path,
        with: so_far,
        ..
    })) = waiting.pop()
    {
        let at = halves.end(paths.0[path].half);
        if at == target {
            let mut cycle: Vec<usize> = paths.back(path).collect();
            cycle.reverse();
            cycle.push(back ^ 1);
            if found(&cycle).is_break() {
                return false;
            }
            continue;
        }
        for half in halves.leaving(at) {
            let to = halves.end(half);
            let passed = to == node || to == at || half >> 1 == back >> 1;
            if passed || paths.back(path).any(|half| halves.end(half) == to) {
                continue;
            }
            if paths.0.len() == most {
                return true;
            }
            let longer = so_far + lengths[half];
            waiting.push(Reverse(Waiting {
                length: longer + ways.bound(to),
                number: paths.0.len(),
                with: longer,
            }));
            let before = Some(path);
            paths.0.push(PathEnd { before, half });
        }
    }
    false
}

/// Return the polygon in the plane of two half-curves that leave a node, of which `back` closes it.
///
/// tangents: unit vectors along which half-curves leave their nodes. At every node the path takes, of
/// those that leave nearly in the plane, the one that turns most to the polygon's inside. Returns the
/// half-curves in order; None if it does not close, passes a node twice, has more than `most`
/// half-curves or has corners at less than half of its nodes: where curves mostly go straight on past
/// others that end there, it is as likely the rim of an opening as a lid, such as the ground of a car.
pub fn find_flat_polygon(
    halves: &HalfCurves,
    tangents: &[Point],
    [out, back]: [usize; 2],
    most: usize,
) -> Option<Vec<usize>> {
    let normal = cross(&tangents[out], &tangents[back]);
    let size = length(&normal);
    if size < NO_PLANE {
        return None;
    }
    let normal = normal.map(|x| x / size);
    let node = halves.start[back] as usize;
    let mut path = vec![out];
    let (mut last, mut corners) = (out, 1);
    loop {
        let at = halves.end(last);
        if at == node {
            break;
        }
        let before = &path[..path.len() - 1];
        if path.len() == most || before.iter().any(|&half| halves.end(half) == at) {
            return None;
        }
        let arriving = tangents[last ^ 1].map(|x| -x);
        let mut best = None;
        let mut turned = f64::NEG_INFINITY;
        for other in halves.leaving(at) {
            let tangent = &tangents[other];
            if other >> 1 == last >> 1
                || halves.end(other) == at
                || dot(tangent, &normal).abs() > OFF_PLANE
            {
                continue;
            }
            // Never -0.0: straight back is to the inside.
            let sine = dot(&cross(&arriving, tangent), &normal) + 0.0;
            let turn = sine.atan2(dot(&arriving, tangent));
            if turn > turned {
                (best, turned) = (Some(other), turn);
            }
        }
        last = best?;
        corners += usize::from(turned.abs() > PLANE_TURN);
        path.push(last);
    }
    (last == back ^ 1 && 2 * corners >= path.len()).then_some(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square 0, 1, 2, 3 with the diagonal from 0 to 2, in a plane.
    struct Square {
        start: Vec<i64>,
        end: Vec<i64>,
        first: Vec<i64>,
        leaving: Vec<i64>,
        lengths: Vec<f64>,
        tangents: Vec<Point>,
    }

    impl Square {
        fn new() -> Square {
            let curves = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]];
            let corners: [Point; 4] = [
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
            ];
            let halves = curves.iter().flat_map(|&[a, b]| [[a, b], [b, a]]);
            let halves: Vec<[i64; 2]> = halves.collect();
            let mut leaving: Vec<i64> = (0..10).collect();
            leaving.sort_by_key(|&half| halves[half as usize][0]);
            let begin =
                |node| leaving.partition_point(|&half| halves[half as usize][0] < node) as i64;
            let along = |&[a, b]: &[i64; 2]| {
                [0, 1, 2].map(|d| corners[b as usize][d] - corners[a as usize][d])
            };
            let lengths: Vec<f64> = halves.iter().map(|half| length(&along(half))).collect();
            let tangents = halves.iter().zip(&lengths);
            let tangents = tangents.map(|(half, size)| along(half).map(|x| x / size));
            Square {
                start: halves.iter().map(|half| half[0]).collect(),
                end: halves.iter().map(|half| half[1]).collect(),
                first: (0..5).map(begin).collect(),
                tangents: tangents.collect(),
                leaving,
                lengths,
            }
        }

        fn halves(&self) -> HalfCurves<'_> {
            HalfCurves {
                start: &self.start,
                end: &self.end,
                first: &self.first,
                leaving: &self.leaving,
            }
        }
    }

    #[test]
    fn cycles_come_by_length() {
        let square = Square::new();
        let (mut distance, mut near) = ([f64::INFINITY; 4], [0; 4]);
        let ways = measure_ways(
            &square.halves(),
            &square.lengths,
            3,
            &mut distance,
            &mut near,
        );
        assert_eq!(ways, (4, f64::INFINITY));
        assert_eq!(distance, [1.0, 2.0, 1.0, 0.0]);
        // From node 0 over node 1, back from node 3.
        let ways = Ways {
            distance: &distance,
            farther: f64::INFINITY,
        };
        let mut cycles = Vec::new();
        let cut_short = find_closing_paths(
            &square.halves(),
            &square.lengths,
            ways,
            [0, 7],
            100,
            |cycle| {
                cycles.push(cycle.to_vec());
                ControlFlow::Continue(())
            },
        );
        assert!(!cut_short);
        assert_eq!(cycles, [[0, 2, 4, 6]]);
    }

    #[test]
    fn a_polygon_takes_the_sharpest_turn_to_its_inside() {
        let square = Square::new();
        let polygon =
            |pair, most| find_flat_polygon(&square.halves(), &square.tangents, pair, most);
        assert_eq!(polygon([0, 8], 128), Some(vec![0, 2, 9]));
        assert_eq!(polygon([0, 8], 2), None);
        assert_eq!(polygon([0, 7], 128), None);
        // The same seen from below: the normal points down.
        assert_eq!(polygon([8, 0], 128), Some(vec![8, 3, 1]));
    }
}
