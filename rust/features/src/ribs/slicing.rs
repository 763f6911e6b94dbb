//! Slices: the edges that a plane cuts out of a model's triangles near a point, and the segments
//! that they join to along the surface patches, then end to end.

use patterndb_geometry::Point;
use patterndb_geometry::tree::{Bounds, Tree, Triangle};
use patterndb_geometry::vector::{dot, max, subtract};

use super::{Edge, Place, Segments};

/// The key of an end that is not on a mesh edge, but where the circle cuts the edge off. `RIM` in
/// `patterndb_sketch.features.ribs.slicing` is the same.
const RIM: i64 = -1;

/// A plane with its frame: an origin, and the axes x, y and the unit normal.
#[derive(Clone, Copy, Debug)]
pub struct Plane<'a> {
    /// The origin of the frame.
    pub origin: &'a Point,
    /// x, y and the unit normal.
    pub axes: &'a [Point; 3],
}

impl Plane<'_> {
    /// Return a point in the frame: x, y, and the height over the plane.
    #[inline(always)]
    fn project(&self, point: &Point) -> Point {
        let from = subtract(point, self.origin);
        [0, 1, 2].map(|k| dot(&from, &self.axes[k]))
    }

    /// Return whether a box surely does not meet the disc of a radius about the origin.
    #[inline(always)]
    fn is_apart(&self, [lower, upper]: &Bounds, radius: f64) -> bool {
        let (mut across, mut half, mut away) = (0.0, 0.0, 0.0);
        for c in 0..3 {
            let low = lower[c] - self.origin[c];
            let high = upper[c] - self.origin[c];
            let normal = self.axes[2][c];
            across += 0.5 * (low + high) * normal;
            half += 0.5 * (high - low) * f64::abs(normal);
            let d = max(max(low, 0.0), -high);
            away += d * d;
        }
        f64::abs(across) > half + 1e-9 * radius || away > radius * radius * (1.0 + 1e-9)
    }
}

/// Return the axes x, y and normal of a plane from its unit normal: x is across the coordinate axis
/// farthest from the normal.
pub fn find_axes(normal: &Point) -> [Point; 3] {
    let is_less = |a: usize, b: usize| normal[a].abs() < normal[b].abs();
    let least = (1..3).fold(0, |least, c| if is_less(c, least) { c } else { least });
    let (one, two) = ((least + 1) % 3, (least + 2) % 3);
    let size = (normal[one] * normal[one] + normal[two] * normal[two]).sqrt();
    let mut x = [0.0; 3];
    x[one] = normal[two] / size;
    x[two] = -normal[one] / size;
    let y = [0, 1, 2].map(|c| {
        let (d, e) = ((c + 1) % 3, (c + 2) % 3);
        normal[d] * x[e] - normal[e] * x[d]
    });
    [x, y, *normal]
}

/// A surface mesh's triangles.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Their corners, in a tree.
    pub tree: Tree<'a>,
    /// The points of each, ascending.
    pub triangles: &'a [[i32; 3]],
    /// The surface patch of each.
    pub components: &'a [i32],
}

/// Cut edges in the frame of a plane, an item for each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cut {
    /// The ends; all within the radius.
    pub ends: Vec<Edge>,
    /// The mesh edge that each end lies on, or [`RIM`]; ends of equal keys are one point.
    pub keys: Vec<[i64; 2]>,
    /// The surface patch that the edge was cut from.
    pub parts: Vec<i32>,
}

/// Cut triangles by a plane, within a radius about its origin, in the order of the tree.
///
/// A vertex on the plane counts as being above it: every triangle has two cut edges or none, and
/// cuts of closed meshes are closed. Source: feature curve recovery paper, section 4.3.1.
pub fn cut_edges(surface: &Surface<'_>, plane: &Plane<'_>, radius: f64) -> Cut {
    let mut cut = Cut::default();
    let mut stack = Vec::new();
    let is_chosen = |bounds: &Bounds| !plane.is_apart(bounds, radius);
    for triangle in surface.tree.select(&mut stack, is_chosen) {
        let f = triangle as usize;
        let Some((ends, sides)) = cut_triangle(&surface.tree.corners[f], plane) else {
            continue;
        };
        let corners = &surface.triangles[f];
        let key = |[a, b]: [usize; 2]| i64::from(corners[a]) << 32 | i64::from(corners[b]);
        if let Some((ends, keys)) = clip(ends, sides.map(key), radius) {
            cut.ends.push(ends);
            cut.keys.push(keys);
            cut.parts.push(surface.components[f]);
        }
    }
    cut
}

/// Return the edge in which a plane cuts a triangle, and the corners on either side of its ends.
#[inline(always)]
fn cut_triangle(corners: &Triangle, plane: &Plane<'_>) -> Option<(Edge, [[usize; 2]; 2])> {
    let flat = [0, 1, 2].map(|k| plane.project(&corners[k]));
    let above = flat.map(|p| p[2] >= 0.0);
    // The triangle's points ascend: both triangles at a mesh edge find the same numbers.
    let crossed = match above {
        [a, b, c] if a == b && b == c => return None,
        [a, b, _] if a == b => [[0, 2], [1, 2]],
        [a, _, c] if a == c => [[0, 1], [1, 2]],
        _ => [[0, 1], [0, 2]],
    };
    let ends = crossed.map(|[one, two]| {
        let ([x, y, z], [other_x, other_y, other_z]) = (flat[one], flat[two]);
        let s = z / (z - other_z);
        [x + s * (other_x - x), y + s * (other_y - y)]
    });
    Some((ends, crossed))
}

/// Cut an edge off at the circle; None if nothing is left.
fn clip(mut ends: Edge, mut keys: [i64; 2], radius: f64) -> Option<(Edge, [i64; 2])> {
    let [[px, py], [qx, qy]] = ends;
    let (dx, dy) = (qx - px, qy - py);
    let size = radius * radius;
    let first = px * px + py * py > size;
    let last = (px + dx) * (px + dx) + (py + dy) * (py + dy) > size;
    if !(first || last) {
        return Some((ends, keys));
    }
    let a = dx * dx + dy * dy;
    let b = px * dx + py * dy;
    let inner = b * b - a * (px * px + py * py - size);
    if a == 0.0 || inner <= 0.0 {
        return None;
    }
    let root = inner.sqrt();
    let (low, high) = ((-b - root) / a, (-b + root) / a);
    if low >= 1.0 || high <= 0.0 {
        return None;
    }
    for (end, outside, share) in [(0, first, low), (1, last, high)] {
        if outside {
            ends[end] = [px + share * dx, py + share * dy];
            keys[end] = RIM;
        }
    }
    Some((ends, keys))
}

/// Join cut edges to segments.
///
/// Cut edges join where they cut the same mesh edge, so long as no third one does; then ends join
/// that lie within the tolerance of each other, so long as no third one does.
/// Source: feature curve recovery paper, section 4.3.2.
pub fn join_edges(ends: &[Edge], keys: &[[i64; 2]], tolerance: f64) -> Segments {
    let keys = keys.as_flattened();
    let ends = ends.as_flattened();
    let mut segments = Segments::default();
    for (entered, closed) in chain_ends(&find_mates(keys)).iter() {
        let (first, last) = outer_ends(entered);
        segments.points.extend(entered.iter().map(|&end| ends[end]));
        segments.points.push(ends[last]);
        segments.finish_segment(closed, [keys[first] == RIM, keys[last] == RIM]);
    }
    stitch_segments(&segments, tolerance)
}

/// Return the end where a string of pieces begins, and the one where it ends.
pub(super) fn outer_ends(entered: &[usize]) -> (usize, usize) {
    (entered[0], entered[entered.len() - 1] ^ 1)
}

/// Find the other end of the same key, where a key has just two.
fn find_mates(keys: &[i64]) -> Vec<Option<usize>> {
    let mut order: Vec<usize> = (0..keys.len()).collect();
    order.sort_by_key(|&end| keys[end]);
    let mut mates = vec![None; keys.len()];
    for same in order.chunk_by(|&one, &other| keys[one] == keys[other]) {
        if let &[one, other] = same
            && keys[one] != RIM
        {
            mates[one] = Some(other);
            mates[other] = Some(one);
        }
    }
    mates
}

/// Pieces strung up.
#[derive(Clone, Debug)]
pub(super) struct Strings {
    /// The ends where pieces are entered, in turn; piece i has the ends 2 i and 2 i + 1.
    entered: Vec<usize>,
    /// Where each string stops, and whether it is closed.
    strings: Vec<(usize, bool)>,
}

impl Strings {
    /// Return the entered ends of each string, and whether it is closed.
    pub fn iter(&self) -> impl Iterator<Item = (&[usize], bool)> {
        let mut begin = 0;
        self.strings.iter().map(move |&(stop, closed)| {
            let entered = &self.entered[begin..stop];
            begin = stop;
            (entered, closed)
        })
    }
}

/// String up pieces with two ends each, 2 i and 2 i + 1, where ends are mates. Open strings come
/// first.
pub(super) fn chain_ends(mates: &[Option<usize>]) -> Strings {
    let n = mates.len() / 2;
    let mut used = vec![false; n];
    let mut entered = Vec::with_capacity(n);
    let mut strings = Vec::new();
    for closed in [false, true] {
        for end in 0..2 * n {
            if used[end >> 1] || (!closed && mates[end].is_some()) {
                continue;
            }
            let mut next = Some(end);
            while let Some(at) = next
                && !used[at >> 1]
            {
                used[at >> 1] = true;
                entered.push(at);
                next = mates[at ^ 1];
            }
            strings.push((entered.len(), closed));
        }
    }
    Strings { entered, strings }
}

impl Segments {
    /// Return the place of an end, 2 s of segment s its first point, 2 s + 1 its last.
    pub(super) fn place(&self, end: usize) -> Place {
        self.points[self.end(end >> 1, end & 1)]
    }

    /// Return whether an end is on the circle.
    pub(super) fn is_rim(&self, end: usize) -> bool {
        self.rims[end >> 1][end & 1]
    }

    /// Append the points of a segment that is entered at an end.
    pub(super) fn append_entered(&self, end: usize, points: &mut Vec<Place>) {
        let own = self.points_of(end >> 1);
        if end & 1 == 0 {
            points.extend_from_slice(own);
        } else {
            points.extend(own.iter().rev());
        }
    }
}

/// Put segments end to end where two free ends meet, and thin them.
pub(super) fn stitch_segments(segments: &Segments, tolerance: f64) -> Segments {
    let mut result = Segments::default();
    for (entered, is_loop) in chain_ends(&find_ends_within(segments, tolerance)).iter() {
        let (begin, last) = outer_ends(entered);
        let first = result.points.len();
        for &end in entered {
            segments.append_entered(end, &mut result.points);
        }
        if is_loop {
            result.points.push(result.points[first]);
        }
        let whole = is_loop || segments.closed[begin >> 1];
        thin(&mut result.points, first, whole, tolerance);
        if result.points.len() > first {
            result.finish_segment(whole, [begin, last].map(|end| segments.is_rim(end)));
        }
    }
    result
}

/// Find the one other free end within reach of each; None with none, and with several.
fn find_ends_within(segments: &Segments, reach: f64) -> Vec<Option<usize>> {
    let free: Vec<(usize, Place)> = (0..2 * segments.len())
        .filter(|&end| segments.has_end(end >> 1, end & 1))
        .map(|end| (end, segments.place(end)))
        .collect();
    let mut mates = vec![None; 2 * segments.len()];
    let mut count = vec![0; mates.len()];
    for (k, &(one, p)) in free.iter().enumerate() {
        for &(other, q) in &free[..k] {
            let (dx, dy) = (p[0] - q[0], p[1] - q[1]);
            if dx * dx + dy * dy <= reach * reach {
                mates[one] = Some(other);
                mates[other] = Some(one);
                count[one] += 1;
                count[other] += 1;
            }
        }
    }
    for end in 0..mates.len() {
        if let Some(other) = mates[end]
            && (count[end] > 1 || count[other] > 1)
        {
            mates[end] = None;
        }
    }
    mates
}

/// Drop points within reach of the one before from those that begin at `first`, never the ends; all
/// of them if too few are left.
fn thin(points: &mut Vec<Place>, first: usize, is_loop: bool, reach: f64) {
    if points.len() <= first {
        return;
    }
    let last = points[points.len() - 1];
    let mut at = first;
    for k in first + 1..points.len() {
        let (dx, dy) = (points[k][0] - points[at][0], points[k][1] - points[at][1]);
        if dx * dx + dy * dy > reach * reach {
            at += 1;
            points[at] = points[k];
        }
    }
    if at - first < if is_loop { 3 } else { 1 } {
        points.truncate(first);
        return;
    }
    points[at] = last;
    points.truncate(at + 1);
}

#[cfg(test)]
mod tests {
    use super::*;
    use patterndb_geometry::tree::build;

    #[test]
    fn axes_are_a_right_handed_frame() {
        let normal = [0.6, 0.0, -0.8];
        let [x, y, z] = find_axes(&normal);
        assert_eq!(z, normal);
        for (a, b, wanted) in [(x, x, 1.0), (y, y, 1.0), (x, y, 0.0), (x, z, 0.0)] {
            assert!((dot(&a, &b) - wanted).abs() < 1e-15);
        }
        assert!((dot(&patterndb_geometry::vector::cross(&x, &y), &z) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_tetrahedron_is_cut_in_a_closed_segment() {
        let points = [
            [0.0, 0.0, -1.0],
            [3.0, 0.0, -1.0],
            [0.0, 3.0, -1.0],
            [0.0, 0.0, 2.0],
        ];
        let triangles = [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]];
        let corners = triangles.map(|t: [i32; 3]| t.map(|v| points[v as usize]));
        let boxes = build(&corners);
        let surface = Surface {
            tree: boxes.tree(&corners),
            triangles: &triangles,
            components: &[0; 4],
        };
        let axes = find_axes(&[0.0, 0.0, 1.0]);
        let plane = Plane {
            origin: &[0.0; 3],
            axes: &axes,
        };
        let cut = cut_edges(&surface, &plane, 9.0);
        let segments = join_edges(&cut.ends, &cut.keys, 1e-6);
        assert_eq!((segments.len(), segments.points.len()), (1, 4));
        assert!(segments.closed[0]);
        let short = cut_edges(&surface, &plane, 1.0);
        assert_eq!(join_edges(&short.ends, &short.keys, 1e-6).rims, [[true; 2]]);
        assert_eq!(
            short
                .keys
                .iter()
                .flatten()
                .filter(|&&key| key == RIM)
                .count(),
            2
        );
    }

    #[test]
    fn three_edges_at_a_point_stay_apart() {
        let ends = [
            [[0.0, 0.0], [1.0, 0.0]],
            [[0.0, 0.0], [0.0, 1.0]],
            [[0.0, 0.0], [-1.0, 0.0]],
        ];
        let keys = [[1, 2], [1, 3], [1, 4]];
        assert_eq!(join_edges(&ends, &keys, 1e-6).len(), 3);
        assert_eq!(join_edges(&ends[..2], &keys[..2], 1e-6).len(), 1);
    }

    #[test]
    fn thinning_keeps_the_ends() {
        let mut points = vec![[0.0, 0.0], [0.1, 0.0], [1.0, 0.0], [1.1, 0.0]];
        thin(&mut points, 0, false, 0.5);
        assert_eq!(points, [[0.0, 0.0], [1.1, 0.0]]);
        thin(&mut points, 0, true, 0.5);
        assert!(points.is_empty());
    }
}
