//! A strip of triangles rerouted round vertices until its shortest path is shortest all round.

use std::f64::consts::PI;

use patterndb_geometry::Point;
use patterndb_geometry::vector::{cross, dot, length, max, min, subtract};

use patterndb_geometry::adjacency::{Surface, Triangle, from_corner, side_corners};

/// A path that turns at a vertex by less than this angle, in radians, stays there: rerouting would
/// shorten it by the square of it at most.
const STRAIGHT: f64 = 1e-8;

/// A point with a smaller barycentric weight than this lies on the opposite edge.
const ON_EDGE: f64 = 1e-12;

/// Rounds that do not shorten the path before it counts as shortest.
const PATIENCE: usize = 4;

/// What a round must take off a path's length, as a part of it, to have shortened it: rounding.
const SHORTENED: f64 = 1e-15;

/// A place in the plane that a strip is laid flat in.
pub type Flat = [f64; 2];

/// Barycentric weights of a triangle's corners.
pub type Weights = [f64; 3];

/// A step from one triangle of a strip to the next: a gate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The side by which the one is left.
    pub out: i32,
    /// The side by which the next is entered.
    pub into: i32,
}

/// Triangles next to each other, and a point in the first and in the last of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// The first triangle, which is the only one if there are no steps.
    pub first: i32,
    /// The steps from triangle to triangle.
    pub steps: Vec<Step>,
    /// Weights of the path's start in the first triangle.
    pub start: Weights,
    /// Weights of its end in the last triangle.
    pub end: Weights,
}

/// The gates between the triangles of a strip, in one plane.
///
/// The first and the last row are no gates: both sides are the corner of the first and the last
/// triangle that is at none.
#[derive(Clone, Copy, Debug)]
pub struct Gates<'a> {
    /// The vertices at the left and the right of each gate.
    pub vertices: &'a [[i32; 2]],
    /// Their places.
    pub places: &'a [[Flat; 2]],
    /// The places of the path's start and end.
    pub ends: &'a [Flat; 2],
}

/// Owned [`Gates`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unfolded {
    /// See [`Gates::vertices`].
    pub vertices: Vec<[i32; 2]>,
    /// See [`Gates::places`].
    pub places: Vec<[Flat; 2]>,
    /// See [`Gates::ends`].
    pub ends: [Flat; 2],
}

/// A turn of a path at a vertex of a gate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Number of the gate, counted from 0.
    pub gate: usize,
    /// Its side: 0 left, 1 right.
    pub side: usize,
}

impl Unfolded {
    /// Borrow the gates.
    pub fn gates(&self) -> Gates<'_> {
        Gates {
            vertices: &self.vertices,
            places: &self.places,
            ends: &self.ends,
        }
    }
}

impl Gates<'_> {
    /// Return the number of gates.
    fn count(&self) -> usize {
        self.vertices.len() - 2
    }

    /// Return the vertex that a path turns at.
    fn vertex(&self, turn: Turn) -> i32 {
        self.vertices[turn.gate + 1][turn.side]
    }

    /// Return the place of the vertex that a path turns at.
    fn place(&self, turn: Turn) -> Flat {
        self.places[turn.gate + 1][turn.side]
    }
}

/// Lay the triangles of a strip of one step or more flat.
pub fn unfold_strip(
    surface: Surface<'_>,
    steps: &[Step],
    start: &Weights,
    end: &Weights,
) -> Unfolded {
    let triangles = surface.triangles;
    let first = steps[0].out;
    let [right, left, third] = side_corners(triangles, first);
    let width = apart(surface.vertices, right, left);
    // What is ahead lies at negative heights.
    let (x, y) = beyond(surface.vertices, right, left, third);
    let mut gate = [left, right];
    let mut places = [[width, 0.0], [0.0, 0.0]];
    let mut made = Unfolded {
        vertices: vec![[third; 2], gate],
        places: vec![[[x, y]; 2], places],
        ends: [[0.0; 2]; 2],
    };
    let [_, to_left, to_third] = from_corner(*start, first as usize % 3);
    made.ends[0] = [to_left * width + to_third * x, to_third * y];
    for (i, step) in steps.iter().enumerate() {
        let ([left, right], [at_left, at_right]) = (gate, places);
        let [_, _, third] = side_corners(triangles, step.into);
        let (x, y) = beyond(surface.vertices, right, left, third);
        let (ux, uy) = (at_left[0] - at_right[0], at_left[1] - at_right[1]);
        let size = (ux * ux + uy * uy).sqrt();
        let (ux, uy) = (ux / size, uy / size);
        let place = [at_right[0] + x * ux + y * uy, at_right[1] + x * uy - y * ux];
        if let Some(next) = steps.get(i + 1) {
            let [tail, head, _] = side_corners(triangles, next.out);
            let changed = usize::from(tail == left || head == left);
            gate[changed] = third;
            places[changed] = place;
        } else {
            for (corner, weight) in triangles[step.into as usize / 3].iter().zip(end) {
                let at = match *corner {
                    v if v == third => place,
                    v if v == left => at_left,
                    _ => at_right,
                };
                made.ends[1][0] += weight * at[0];
                made.ends[1][1] += weight * at[1];
            }
            (gate, places) = ([third; 2], [place; 2]);
        }
        made.vertices.push(gate);
        made.places.push(places);
    }
    made
}

/// Return how far apart two vertices are.
fn apart(vertices: &[Point], a: i32, b: i32) -> f64 {
    length(&subtract(&vertices[b as usize], &vertices[a as usize]))
}

/// Return how far c lies along the edge from a to b, and how far from it.
fn beyond(vertices: &[Point], a: i32, b: i32, c: i32) -> (f64, f64) {
    let [from, to, off] = [a, b, c].map(|v| &vertices[v as usize]);
    let edge = subtract(to, from);
    let size = length(&edge);
    let unit = edge.map(|x| x / size);
    let off = subtract(off, from);
    let along = dot(&off, &unit);
    let aside = [0, 1, 2].map(|k| off[k] - along * unit[k]);
    (along, length(&aside))
}

/// Return twice the area of a, b, c: above 0 if c is left of the line from a to b.
fn double_area(a: &Flat, b: &Flat, c: &Flat) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Return the turns of the shortest path through gates, and its length.
///
/// Source: Lee and Preparata 1984, "Euclidean shortest paths in the presence of rectilinear
/// barriers". The funnel is opened afresh behind every turn.
pub fn pull_tight(gates: Gates<'_>) -> (Vec<Turn>, f64) {
    let n = gates.count();
    let mut turns = Vec::new();
    let mut total = 0.0;
    let [mut apex, end] = *gates.ends;
    let mut first = 0;
    while first < n {
        let Some((turn, place)) = find_turn(gates, apex, first) else {
            break;
        };
        total += (place[0] - apex[0]).hypot(place[1] - apex[1]);
        apex = place;
        turns.push(turn);
        // The gates that end in the turn are over with it.
        let passed = &gates.vertices[turn.gate + 2..=n];
        first = turn.gate + 1;
        first += passed
            .iter()
            .take_while(|gate| gate[turn.side] == gates.vertex(turn))
            .count();
    }
    total += (end[0] - apex[0]).hypot(end[1] - apex[1]);
    (turns, total)
}

/// Return the first turn of the shortest path from an apex through the gates from one on, and its
/// place; None if the path is straight.
fn find_turn(gates: Gates<'_>, apex: Flat, first: usize) -> Option<(Turn, Flat)> {
    let n = gates.count();
    let mut bounds = gates.places[first + 1];
    let mut at = [first; 2];
    for j in first + 1..=n {
        for side in 0..2 {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let target = if j < n {
                gates.places[j + 1][side]
            } else {
                gates.ends[1]
            };
            if sign * double_area(&apex, &bounds[side], &target) > 0.0 {
                continue;
            }
            let other = 1 - side;
            if sign * double_area(&apex, &bounds[other], &target) < 0.0 {
                let turn = Turn {
                    gate: at[other],
                    side: other,
                };
                return Some((turn, bounds[other]));
            }
            bounds[side] = target;
            at[side] = j;
        }
    }
    None
}

/// Return the strip whose shortest path is shorter than all near it; it may be of no steps.
///
/// steps: one or more; start, end: weights of the path's ends. Every round pulls the path tight and
/// looks at each vertex where it turns: if the angle on the side away from the strip is less than a
/// straight one, the strip goes round there.
pub fn shorten_strip(
    surface: Surface<'_>,
    across: &[i32],
    steps: Vec<Step>,
    start: Weights,
    end: Weights,
) -> Strip {
    let mut seen = vec![-1; surface.triangles.len()];
    let mut shortest = f64::INFINITY;
    let mut waited = 0;
    let mut strip = Strip {
        first: steps[0].out / 3,
        steps,
        start,
        end,
    };
    let mut best = strip.clone();
    loop {
        remove_loops(&mut strip.steps, &mut seen);
        trim_ends(surface.triangles, &mut strip);
        if strip.steps.is_empty() {
            return strip;
        }
        let unfolded = unfold_strip(surface, &strip.steps, &strip.start, &strip.end);
        let (turns, total) = pull_tight(unfolded.gates());
        if total < shortest * (1.0 - SHORTENED) {
            shortest = total;
            waited = 0;
            best.clone_from(&strip);
        } else {
            waited += 1;
            if waited > PATIENCE {
                break;
            }
        }
        match reroute(surface, across, &strip.steps, unfolded.gates(), &turns) {
            Some(steps) => strip.steps = steps,
            None => break,
        }
    }
    best.first = best.steps[0].out / 3;
    best
}

/// Leave out what lies between two passes of a strip through one triangle.
///
/// seen: -1 for each triangle, and so again afterwards.
fn remove_loops(steps: &mut Vec<Step>, seen: &mut [i32]) {
    let Some(first) = steps.first().map(|step| step.out as usize / 3) else {
        return;
    };
    let mut kept: Vec<Step> = Vec::with_capacity(steps.len());
    seen[first] = 0;
    for &step in &*steps {
        kept.push(step);
        let triangle = step.into as usize / 3;
        if let Ok(before) = usize::try_from(seen[triangle]) {
            for step in &kept[before..kept.len() - 1] {
                seen[step.into as usize / 3] = -1;
            }
            kept.truncate(before);
        }
        seen[triangle] = kept.len() as i32;
    }
    seen[first] = -1;
    for step in &kept {
        seen[step.into as usize / 3] = -1;
    }
    *steps = kept;
}

/// Leave out triangles at the ends of a strip that the path only touches: the point lies on the
/// side by which they are left or entered.
fn trim_ends(triangles: &[Triangle], strip: &mut Strip) {
    let is_on = |weights: &Weights, side: i32| weights[(side as usize % 3 + 2) % 3] <= ON_EDGE;
    let mut low = 0;
    let mut high = strip.steps.len();
    while low < high && is_on(&strip.start, strip.steps[low].out) {
        let step = strip.steps[low];
        strip.start = carry_weights(triangles, step.out, step.into, &strip.start);
        strip.first = step.into / 3;
        low += 1;
    }
    while low < high && is_on(&strip.end, strip.steps[high - 1].into) {
        let step = strip.steps[high - 1];
        strip.end = carry_weights(triangles, step.into, step.out, &strip.end);
        high -= 1;
    }
    strip.steps.truncate(high);
    strip.steps.drain(..low);
}

/// Return the weights in the triangle of the side `other` of a point on `side`, the same edge.
fn carry_weights(triangles: &[Triangle], side: i32, other: i32, weights: &Weights) -> Weights {
    let (from, to) = (triangles[side as usize / 3], triangles[other as usize / 3]);
    let mut carried = [0.0; 3];
    for (vertex, &weight) in from.iter().zip(weights) {
        for k in 0..2 {
            let corner = (other as usize % 3 + k) % 3;
            if *vertex == to[corner] {
                carried[corner] = weight;
            }
        }
    }
    let total = carried[0] + carried[1] + carried[2];
    carried.map(|weight| weight / total)
}

/// Return the angle at a place between two others, in 0..pi.
fn angle_between(at: &Flat, a: &Flat, b: &Flat) -> f64 {
    let (ux, uy) = (a[0] - at[0], a[1] - at[1]);
    let (vx, vy) = (b[0] - at[0], b[1] - at[1]);
    (ux * vy - uy * vx).abs().atan2(ux * vx + uy * vy)
}

/// Return the angle at the first corner of a triangle.
fn corner_angle(vertices: &[Point], corners: Triangle) -> f64 {
    let [at, a, b] = corners.map(|v| &vertices[v as usize]);
    let (u, v) = (subtract(a, at), subtract(b, at));
    length(&cross(&u, &v)).atan2(dot(&u, &v))
}

/// Return the other of the two sides at a vertex of the triangle of a side there.
fn other_side(triangles: &[Triangle], side: i32, vertex: i32) -> i32 {
    let (f, e) = (side / 3, side % 3);
    // A side that begins at the vertex is preceded by one that ends there, and the other way about.
    let step = if triangles[f as usize][e as usize] == vertex {
        2
    } else {
        1
    };
    3 * f + (e + step) % 3
}

/// Return the steps of a strip led round the other side of the vertices where that is shorter; None
/// if it is so nowhere.
///
/// Of turns whose fans share more than a triangle only the first is taken.
fn reroute(
    surface: Surface<'_>,
    across: &[i32],
    steps: &[Step],
    gates: Gates<'_>,
    turns: &[Turn],
) -> Option<Vec<Step>> {
    let n = steps.len();
    let mut rerouted = Vec::with_capacity(2 * n);
    let mut copied = 0;
    for (k, &turn) in turns.iter().enumerate() {
        let side = turn.side;
        let (vertex, at) = (gates.vertex(turn), gates.place(turn));
        let is_there = |row: usize| gates.vertices[row][side] == vertex;
        let mut i = turn.gate;
        while i > 0 && is_there(i) {
            i -= 1;
        }
        let mut j = turn.gate + 1;
        while j < n && is_there(j + 1) {
            j += 1;
        }
        if i < copied {
            continue;
        }
        let came = match k.checked_sub(1) {
            Some(before) => gates.place(turns[before]),
            None => gates.ends[0],
        };
        let goes = match turns.get(k + 1) {
            Some(&next) => gates.place(next),
            None => gates.ends[1],
        };
        // Row i + 1 is gate i: row i, and behind the fan row j + 1, hold its outer corners.
        let before = angle_between(&at, &came, &gates.places[i][side]);
        let behind = angle_between(&at, &goes, &gates.places[j + 1][side]);
        let room = (PI - STRAIGHT) - (before + behind);
        let last = steps[j - 1].into / 3;
        if let Some(fan) = walk_round(surface, across, steps[i].out, vertex, last, room) {
            rerouted.extend(&steps[copied..i]);
            rerouted.extend(fan);
            copied = j;
        }
    }
    if copied == 0 {
        return None;
    }
    rerouted.extend(&steps[copied..]);
    Some(rerouted)
}

/// Return the steps round a vertex on the side away from a strip, to its triangle `last`; None if
/// the angles there are more than `room`, or there is a border.
///
/// out: the side at the vertex by which the strip leaves the triangle in which it comes there.
fn walk_round(
    surface: Surface<'_>,
    across: &[i32],
    out: i32,
    vertex: i32,
    last: i32,
    mut room: f64,
) -> Option<Vec<Step>> {
    let triangles = surface.triangles;
    let mut fan = Vec::new();
    let mut side = out;
    loop {
        side = other_side(triangles, side, vertex);
        let entered = across[side as usize];
        let goes_on = room > 0.0 && entered >= 0;
        if !goes_on {
            return None;
        }
        fan.push(Step {
            out: side,
            into: entered,
        });
        if entered / 3 == last {
            return Some(fan);
        }
        let corners = side_corners(triangles, entered);
        let turned = from_corner(corners, usize::from(corners[0] != vertex));
        room -= corner_angle(surface.vertices, turned);
        side = entered;
    }
}

/// Return where the path with these turns passes each of the gates.
pub fn cross_gates(vertices: &[Point], gates: Gates<'_>, turns: &[Turn]) -> Vec<Point> {
    let end = |at: Flat| (at, None);
    let turned = |turn: &Turn| (gates.place(*turn), Some(gates.vertex(*turn)));
    let mut ahead = turns.iter().peekable();
    let mut came = end(gates.ends[0]);
    (0..gates.count())
        .map(|i| {
            while let Some(turn) = ahead.next_if(|turn| turn.gate < i) {
                came = turned(turn);
            }
            let goes = ahead.peek().map_or(end(gates.ends[1]), |turn| turned(turn));
            let [left, right] = gates.vertices[i + 1];
            let is_turn = |vertex| [came.1, goes.1].contains(&Some(vertex));
            let t = if is_turn(left) {
                0.0
            } else if is_turn(right) {
                1.0
            } else {
                cross_gate(&gates.places[i + 1], &came.0, &goes.0)
            };
            let [a, b] = [left, right].map(|v| &vertices[v as usize]);
            [0, 1, 2].map(|c| (1.0 - t) * a[c] + t * b[c])
        })
        .collect()
}

/// Return the part of a gate, from its left, at which the line between two places crosses it.
fn cross_gate([a, b]: &[Flat; 2], came: &Flat, goes: &Flat) -> f64 {
    let (dx, dy) = (goes[0] - came[0], goes[1] - came[1]);
    let over = (b[0] - a[0]) * dy - (b[1] - a[1]) * dx;
    let t = (came[0] - a[0]) * dy - (came[1] - a[1]) * dx;
    if over != 0.0 {
        min(max(t / over, 0.0), 1.0)
    } else {
        0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six triangles around a vertex, in a plane.
    fn fan() -> (Vec<Point>, Vec<Triangle>, Vec<i32>) {
        let around = (0..6).map(|k| f64::from(k) * PI / 3.0);
        let mut vertices: Vec<Point> = around.map(|a| [a.cos(), a.sin(), 0.0]).collect();
        vertices.push([0.0; 3]);
        let triangles: Vec<Triangle> = (0..6).map(|k| [6, k, (k + 1) % 6]).collect();
        let mut across = vec![-1; 18];
        for k in 0..6 {
            // Side 2 of a triangle leads back to the middle, side 0 of the next away from it.
            across[3 * k + 2] = (3 * (k as i32 + 1)) % 18;
            across[3 * ((k + 1) % 6)] = 3 * k as i32 + 2;
        }
        (vertices, triangles, across)
    }

    fn steps(sides: &[(i32, i32)]) -> Vec<Step> {
        let step = |&(out, into)| Step { out, into };
        sides.iter().map(step).collect()
    }

    #[test]
    fn a_long_way_round_a_vertex_becomes_the_short_one() {
        let (vertices, triangles, across) = fan();
        let surface = Surface {
            vertices: &vertices,
            triangles: &triangles,
        };
        // From triangle 0 backwards to triangle 2, by 5, 4 and 3.
        let long = steps(&[(0, 17), (15, 14), (12, 11), (9, 8)]);
        let middle = [1.0 / 3.0; 3];
        let found = shorten_strip(surface, &across, long, middle, middle);
        assert_eq!(found.steps, steps(&[(2, 3), (5, 6)]));
        assert_eq!(found.first, 0);
        let flat = unfold_strip(surface, &found.steps, &found.start, &found.end);
        let (turns, total) = pull_tight(flat.gates());
        assert!(turns.is_empty());
        assert!((total - 1.0).abs() < 1e-12);
        let points = cross_gates(&vertices, flat.gates(), &turns);
        assert_eq!(points.len(), 2);
        let height = 0.5 / 3.0_f64.sqrt();
        assert!(points.iter().all(|p| (p[1] - height).abs() < 1e-12));
    }

    #[test]
    fn triangles_that_are_only_touched_are_left_out() {
        let (vertices, triangles, across) = fan();
        let surface = Surface {
            vertices: &vertices,
            triangles: &triangles,
        };
        // The start lies on the side from triangle 0 to triangle 1.
        let on_side = [0.5, 0.0, 0.5];
        let found = shorten_strip(surface, &across, steps(&[(2, 3)]), on_side, [0.2, 0.4, 0.4]);
        assert_eq!((found.first, found.steps.len()), (1, 0));
        assert_eq!(found.start, [0.5, 0.5, 0.0]);
    }

    #[test]
    fn a_strip_that_comes_back_loses_its_loop() {
        let mut seen = vec![-1; 6];
        let mut walked = steps(&[(2, 3), (5, 6), (6, 5), (3, 2)]);
        remove_loops(&mut walked, &mut seen);
        assert!(walked.is_empty());
        assert_eq!(seen, [-1; 6]);
    }
}
