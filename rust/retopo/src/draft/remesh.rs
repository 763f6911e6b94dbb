//! Even remeshing of surfaces: triangles of one size and nearly one shape, for fields to be solved
//! on.
//!
//! After Botsch and Kobbelt 2004, "A Remeshing Approach to Multiresolution Modeling": long edges are
//! split, short ones collapsed, edges flipped towards six triangles a vertex, and vertices moved
//! along the surface. Borders stay where they are, except for their division.
//!
//! Side `3 * triangle + corner` runs from a triangle's corner to the next one; `twin` of a side is
//! the one beyond, -1 at a border.

use patterndb_geometry::vector::{Point, cross, dot, length, subtract};

/// Sweeps of halving at most: an edge of a thousand times the wanted length takes some thirty.
const MOST_HALVINGS: usize = 60;

/// A border's vertex may go if its border turns there by less than this: the cosine of 10 degrees.
const STRAIGHT: f64 = 0.985;

/// Sides that leave a vertex, at most, where edges are collapsed or flipped.
const MOST_SIDES: usize = 64;

/// Sides that leave the two ends of an edge that is collapsed, at most.
const MOST_OF_BOTH: usize = 60;

/// No side.
const NONE: i32 = -1;

/// A triangle: its vertices.
pub type Triangle = [i32; 3];

/// Return the side after one in its triangle.
fn after(side: usize) -> usize {
    if side % 3 == 2 { side - 2 } else { side + 1 }
}

/// Return the side before one in its triangle.
fn before(side: usize) -> usize {
    if side.is_multiple_of(3) {
        side + 2
    } else {
        side - 1
    }
}

/// Make two sides twins; none where the other is.
fn join(twin: &mut [i32], a: i32, b: i32) {
    if a >= 0 {
        twin[a as usize] = b;
    }
    if b >= 0 {
        twin[b as usize] = a;
    }
}

fn distance(a: &Point, b: &Point) -> f64 {
    length(&subtract(a, b))
}

/// Return the normal of a triangle, twice its area long.
fn normal(a: &Point, b: &Point, c: &Point) -> Point {
    cross(&subtract(b, a), &subtract(c, a))
}

/// Return the sum of two vectors.
fn add(a: &Point, b: &Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// A mesh whose edges are divided.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Of every vertex.
    pub points: Vec<Point>,
    /// All turned alike.
    pub triangles: Vec<Triangle>,
    /// Of every side the one beyond.
    pub twin: Vec<i32>,
}

impl Mesh {
    /// Halve edges that are longer than `longest` until none is.
    pub fn split_long(&mut self, longest: f64) {
        for _ in 0..MOST_HALVINGS {
            let last = self.triangles.len();
            for f in 0..last {
                if let Some(side) = self.find_long(f, longest) {
                    self.halve(side);
                }
            }
            if self.triangles.len() == last {
                break;
            }
        }
    }

    /// Return the longest side of a triangle, as Rivara 1984: any other would make needles of
    /// needles. None where it is not too long.
    fn find_long(&self, f: usize, longest: f64) -> Option<usize> {
        let [a, b, c] = self.triangles[f].map(|v| self.points[v as usize]);
        let (mut found, mut size) = (0, -1.0);
        for (e, far) in [distance(&a, &b), distance(&b, &c), distance(&c, &a)]
            .into_iter()
            .enumerate()
        {
            if far > size {
                (found, size) = (e, far);
            }
        }
        (size > longest).then_some(3 * f + found)
    }

    /// Put a vertex in the middle of a side.
    fn halve(&mut self, side: usize) {
        let (f, e) = (side / 3, side % 3);
        let a = self.points[self.triangles[f][e] as usize];
        let b = self.points[self.triangles[f][(e + 1) % 3] as usize];
        let middle = self.points.len() as i32;
        self.points.push(add(&a, &b).map(|x| 0.5 * x));
        let beyond = self.twin[side];
        // (a, b, c) becomes (a, m, c) and (m, b, c).
        let new = self.cut_triangle(side, middle);
        if beyond < 0 {
            return;
        }
        // (b, a, d) becomes (b, m, d) and (m, a, d).
        let other = self.cut_triangle(beyond as usize, middle);
        join(&mut self.twin, side as i32, 3 * other);
        join(&mut self.twin, 3 * new, beyond);
    }

    /// Cut a triangle in two from the middle of a side to the corner across; the new one has the
    /// side's end. Returns its number.
    fn cut_triangle(&mut self, side: usize, middle: i32) -> i32 {
        let (f, e) = (side / 3, side % 3);
        let [b, c] = [1, 2].map(|k| self.triangles[f][(e + k) % 3]);
        let ahead = 3 * f + (e + 1) % 3;
        let beyond = self.twin[ahead];
        let new = self.triangles.len() as i32;
        self.triangles[f][(e + 1) % 3] = middle;
        self.triangles.push([middle, b, c]);
        self.twin.extend([NONE; 3]);
        join(&mut self.twin, 3 * new + 1, beyond);
        join(&mut self.twin, 3 * new + 2, ahead as i32);
        new
    }
}

/// Return for each of n vertices whether it lies on a border side.
pub fn mark_border(n: usize, triangles: &[Triangle], twin: &[i32]) -> Vec<bool> {
    let mut found = vec![false; n];
    for (sides, triangle) in twin.chunks_exact(3).zip(triangles) {
        for e in (0..3).filter(|&e| sides[e] < 0) {
            found[triangle[e] as usize] = true;
            found[triangle[(e + 1) % 3] as usize] = true;
        }
    }
    found
}

/// Return the vertex that a side leaves.
fn tail(triangles: &[Triangle], side: usize) -> i32 {
    triangles[side / 3][side % 3]
}

/// Return the vertex that a side leads to.
fn head(triangles: &[Triangle], side: usize) -> i32 {
    triangles[side / 3][(side % 3 + 1) % 3]
}

/// The sides that leave a vertex.
struct Ring {
    sides: [usize; MOST_SIDES],
    n: usize,
    /// Do they go all the way round?
    whole: bool,
}

impl Ring {
    /// Return the sides that leave the vertex that `first` leaves; None where there are too many.
    fn around(first: usize, twin: &[i32]) -> Option<Ring> {
        let mut ring = Ring {
            sides: [0; MOST_SIDES],
            n: 0,
            whole: false,
        };
        let mut side = first;
        loop {
            ring.push(side)?;
            let beyond = twin[before(side)];
            if beyond == first as i32 {
                ring.whole = true;
                return Some(ring);
            }
            if beyond < 0 {
                break;
            }
            side = beyond as usize;
        }
        // The other way round, up to the border.
        side = first;
        while let Ok(beyond) = usize::try_from(twin[side]) {
            side = after(beyond);
            ring.push(side)?;
        }
        Some(ring)
    }

    fn push(&mut self, side: usize) -> Option<()> {
        *self.sides.get_mut(self.n)? = side;
        self.n += 1;
        Some(())
    }

    fn sides(&self) -> &[usize] {
        &self.sides[..self.n]
    }

    /// Return the neighbour along the border that no side of an open ring leads to.
    fn find_border_neighbour(&self, triangles: &[Triangle], twin: &[i32]) -> Option<i32> {
        let mut sides = self.sides().iter().map(|&side| before(side));
        let side = sides.find(|&side| twin[side] < 0)?;
        Some(tail(triangles, side))
    }

    /// Return all neighbours of the vertex.
    fn neighbours(&self, triangles: &[Triangle], twin: &[i32]) -> impl Iterator<Item = i32> {
        let heads = self.sides().iter().map(|&side| head(triangles, side));
        let last = (!self.whole).then(|| self.find_border_neighbour(triangles, twin));
        heads.chain(last.flatten())
    }
}

/// A mesh whose edges are collapsed.
#[derive(Debug)]
pub struct Collapse<'a> {
    /// Of every vertex.
    pub points: &'a mut [Point],
    /// All turned alike.
    pub triangles: &'a mut [Triangle],
    /// Of every side the one beyond.
    pub twin: &'a mut [i32],
    /// Edges that are shorter are collapsed.
    pub shortest: f64,
    /// No edge may become longer.
    pub longest: f64,
}

impl Collapse<'_> {
    /// Collapse edges that are too short: return for each triangle whether it is left.
    pub fn run(mut self) -> Vec<bool> {
        let mut alive = vec![true; self.triangles.len()];
        let mut border = mark_border(self.points.len(), self.triangles, self.twin);
        for f in 0..self.triangles.len() {
            for side in 3 * f..3 * f + 3 {
                if !alive[f] {
                    break;
                }
                if let Some(collapse) = self.examine(side, &border) {
                    self.collapse(collapse, &mut alive, &mut border);
                }
            }
        }
        alive
    }

    fn point(&self, vertex: i32) -> &Point {
        &self.points[vertex as usize]
    }

    /// Return how a side can be collapsed; None where it cannot, or is long enough.
    fn examine(&self, side: usize, border: &[bool]) -> Option<Merge> {
        let (a, b) = (tail(self.triangles, side), head(self.triangles, side));
        if distance(self.point(a), self.point(b)) >= self.shortest {
            return None;
        }
        let on_border = [a, b].map(|v| border[v as usize]);
        let inside = self.twin[side] >= 0;
        // Across the surface no two borders come together.
        if inside && on_border == [true; 2] {
            return None;
        }
        let one = Ring::around(side, self.twin)?;
        let two = Ring::around(after(side), self.twin)?;
        if one.n + two.n > MOST_OF_BOTH {
            return None;
        }
        // Of a tetrahedron, the least there is, two triangles would be left on each other.
        if one.whole && two.whole && one.n == 3 && two.n == 3 {
            return None;
        }
        // The two have exactly two neighbours in common: else a tunnel or a sheet would close.
        let around: Vec<i32> = one.neighbours(self.triangles, self.twin).collect();
        let beside = two.neighbours(self.triangles, self.twin);
        let common: usize = beside
            .map(|v| around.iter().filter(|&&u| u == v).count())
            .sum();
        if common != if inside { 2 } else { 1 } {
            return None;
        }
        let place = if !inside {
            // A vertex of a border goes only along it, and only where it is straight.
            let along = one.find_border_neighbour(self.triangles, self.twin)?;
            if !is_straight(self.point(along), self.point(a), self.point(b)) {
                return None;
            }
            *self.point(b)
        } else if on_border[0] {
            *self.point(a)
        } else if on_border[1] {
            *self.point(b)
        } else {
            add(self.point(a), self.point(b)).map(|x| 0.5 * x)
        };
        (self.fits(&one, a, b, &place) && self.fits(&two, b, a, &place)).then_some(Merge {
            side,
            gone: a,
            kept: b,
            ring: one,
            place,
        })
    }

    /// Return whether a vertex may go to a place: no edge too long, no triangle turned over.
    fn fits(&self, ring: &Ring, vertex: i32, other: i32, place: &Point) -> bool {
        ring.sides().iter().all(|&side| {
            let triangle = &self.triangles[side / 3];
            let ends = [1, 2].map(|k| triangle[(side % 3 + k) % 3]);
            if ends.contains(&other) {
                return true;
            }
            let ends = ends.map(|v| self.point(v));
            let is_long = |end: &Point| {
                let way = subtract(end, place);
                dot(&way, &way) > self.longest * self.longest
            };
            if ends.into_iter().any(is_long) {
                return false;
            }
            let was = normal(self.point(vertex), ends[0], ends[1]);
            let now = normal(place, ends[0], ends[1]);
            let (big, small) = (dot(&was, &was), dot(&now, &now));
            let square = self.longest * self.longest;
            // Within 60 degrees, and no needle.
            dot(&was, &now) > 0.5 * (big * small).sqrt() && small >= 1e-4 * (square * square)
        })
    }

    fn collapse(&mut self, merge: Merge, alive: &mut [bool], border: &mut [bool]) {
        for &side in merge.ring.sides() {
            self.triangles[side / 3][side % 3] = merge.kept;
        }
        let (gone, kept) = (merge.gone as usize, merge.kept as usize);
        self.points[kept] = merge.place;
        border[kept] |= border[gone];
        let beyond = usize::try_from(self.twin[merge.side]).ok();
        for side in [Some(merge.side), beyond].into_iter().flatten() {
            let [left, right] = [after(side), before(side)].map(|side| self.twin[side]);
            join(self.twin, left, right);
            alive[side / 3] = false;
        }
    }
}

/// An edge that is collapsed.
struct Merge {
    side: usize,
    gone: i32,
    kept: i32,
    /// The sides that leave the vertex that is gone.
    ring: Ring,
    /// Where the vertex goes that is kept.
    place: Point,
}

/// Return whether a line from a over b to c runs straight on at b.
fn is_straight(a: &Point, b: &Point, c: &Point) -> bool {
    let (one, two) = (subtract(b, a), subtract(c, b));
    dot(&one, &two) >= STRAIGHT * distance(a, b) * distance(b, c)
}

/// Flip edges where that brings valences nearer to 6, or 4 on the border.
pub fn flip_to_valence(
    points: &[Point],
    triangles: &mut [Triangle],
    twin: &mut [i32],
    border: &[bool],
) {
    // Of 3 triangles, a border's vertex counts as 6.
    let mut valence: Vec<i32> = border.iter().map(|&on| if on { 3 } else { 0 }).collect();
    for &v in triangles.as_flattened() {
        valence[v as usize] += 1;
    }
    for side in 0..twin.len() {
        let Ok(beyond) = usize::try_from(twin[side]) else {
            continue;
        };
        if beyond < side {
            continue;
        }
        let [a, b, c] = [0, 1, 2].map(|k| triangles[side / 3][(side + k) % 3]);
        let d = tail(triangles, before(beyond));
        if c == d {
            continue;
        }
        let amiss = |wanted: [i32; 4]| -> i32 {
            let corners = [a, b, c, d].into_iter().zip(wanted);
            corners.map(|(v, n)| (valence[v as usize] - n).abs()).sum()
        };
        let is_least = |v: i32| valence[v as usize] <= 4;
        if amiss([7, 7, 5, 5]) >= amiss([6; 4]) || is_least(a) || is_least(b) {
            continue;
        }
        let Some(ring) = Ring::around(before(side), twin) else {
            continue;
        };
        if ring.neighbours(triangles, twin).any(|v| v == d) {
            continue;
        }
        if !can_flip([a, b, c, d].map(|v| &points[v as usize])) {
            continue;
        }
        // (a, b, c) and (b, a, d) become (c, d, b) and (d, c, a).
        let [bc, ca] = [after(side), before(side)].map(|side| twin[side]);
        let [ad, db] = [after(beyond), before(beyond)].map(|side| twin[side]);
        let (f, k) = (side / 3, beyond / 3);
        triangles[f] = [c, d, b];
        triangles[k] = [d, c, a];
        let (f, k) = (3 * f as i32, 3 * k as i32);
        join(twin, f, k);
        join(twin, f + 1, db);
        join(twin, f + 2, bc);
        join(twin, k + 1, ca);
        join(twin, k + 2, ad);
        for (v, by) in [(a, -1), (b, -1), (c, 1), (d, 1)] {
            valence[v as usize] += by;
        }
    }
}

/// Return whether the edge of (a, b, c) and (b, a, d) may be flipped: no triangle turned from what
/// the two look towards by more than 60 degrees, and no needle.
fn can_flip([a, b, c, d]: [&Point; 4]) -> bool {
    let up = add(&normal(a, b, c), &normal(b, a, d));
    let size = length(&up);
    let low = 0.5 * size;
    [normal(c, d, b), normal(d, c, a)]
        .iter()
        .all(|made| dot(made, &up) >= low * length(made) && dot(made, made) >= 1e-3 * size * size)
}

/// Return where vertices are wanted along the surface, between their triangles, and their normals.
pub fn relax(
    points: &[Point],
    triangles: &[Triangle],
    border: &[bool],
) -> (Vec<Point>, Vec<Point>) {
    let mut middle = vec![[0.0; 3]; points.len()];
    let mut weight = vec![0.0; points.len()];
    let mut normals = vec![[0.0; 3]; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| &points[v as usize]);
        let up = normal(a, b, c);
        let area = length(&up);
        let share = add(&add(a, b), c).map(|x| area * x / 3.0);
        for v in triangle.map(|v| v as usize) {
            weight[v] += area;
            normals[v] = add(&normals[v], &up);
            middle[v] = add(&middle[v], &share);
        }
    }
    for (v, (middle, normal)) in middle.iter_mut().zip(&mut normals).enumerate() {
        let size = length(normal);
        if size == 0.0 || weight[v] == 0.0 || border[v] {
            *middle = points[v];
            continue;
        }
        *normal = normal.map(|x| x / size);
        *middle = subtract(&middle.map(|x| x / weight[v]), &points[v]);
        // Of three zeros, whatever their signs, the sum is 0, not -0.
        let off = 0.0 + dot(middle, normal);
        for ((x, at), up) in middle.iter_mut().zip(&points[v]).zip(&*normal) {
            *x += at - off * up;
        }
    }
    (middle, normals)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles, (0, 1, 2) and (0, 2, 3).
    fn square() -> Mesh {
        Mesh {
            points: vec![
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            twin: vec![-1, -1, 3, 2, -1, -1],
        }
    }

    fn check_twins(mesh: &Mesh) {
        for (side, &beyond) in mesh.twin.iter().enumerate() {
            if beyond >= 0 {
                let beyond = beyond as usize;
                assert_eq!(mesh.twin[beyond], side as i32);
                assert_eq!(tail(&mesh.triangles, side), head(&mesh.triangles, beyond));
                assert_eq!(head(&mesh.triangles, side), tail(&mesh.triangles, beyond));
            }
        }
    }

    #[test]
    fn no_long_edge_is_left() {
        let mut mesh = square();
        mesh.split_long(0.3);
        check_twins(&mesh);
        for side in 0..mesh.twin.len() {
            let ends = [tail(&mesh.triangles, side), head(&mesh.triangles, side)];
            let [a, b] = ends.map(|v| mesh.points[v as usize]);
            assert!(distance(&a, &b) <= 0.3);
        }
    }

    #[test]
    fn short_edges_are_collapsed_and_the_corners_stay() {
        let mut mesh = square();
        mesh.split_long(0.1);
        let n = mesh.triangles.len();
        let alive = Collapse {
            points: &mut mesh.points,
            triangles: &mut mesh.triangles,
            twin: &mut mesh.twin,
            shortest: 0.25,
            longest: 0.4,
        }
        .run();
        assert!(alive.iter().filter(|&&left| left).count() < n / 3);
        for corner in square().points {
            let mut left = mesh.triangles.iter().zip(&alive).filter(|(_, left)| **left);
            assert!(left.any(|(t, _)| t.iter().any(|&v| mesh.points[v as usize] == corner)));
        }
    }

    #[test]
    fn flips_keep_twins() {
        let mut mesh = square();
        mesh.split_long(0.1);
        let border = mark_border(mesh.points.len(), &mesh.triangles, &mesh.twin);
        let n = mesh.triangles.len();
        flip_to_valence(&mesh.points, &mut mesh.triangles, &mut mesh.twin, &border);
        check_twins(&mesh);
        assert_eq!(mesh.triangles.len(), n);
        let (moved, normals) = relax(&mesh.points, &mesh.triangles, &border);
        for v in 0..moved.len() {
            assert_eq!(moved[v][2], 0.0);
            assert!(normals[v][2] > 0.0);
        }
    }
}
