//! Where polylines meet: the places at which two of them come together.
//!
//! Take a pair of curves, A and B, and all pairs of places (a on A, b on B) that are within the
//! tolerance of each other: the lesser reach of the two curves. The connected parts of this set are
//! the meetings: one for each crossing, touching end or common stretch. For one curve with itself,
//! the part around a = b is none.
//!
//! Points of all curves stand in one list; edge i runs from point i to point i + 1.

use patterndb_geometry::vector::{Point, dot, length, max, min, subtract};

/// A meeting longer than this many tolerances may be a common stretch: edges that cross at 30
/// degrees are within the tolerance of each other for 4 of them.
const LONG: f64 = 4.0;

/// A long meeting is a common stretch if the median distance within it exceeds the least by less
/// than this share of the tolerance. Crossing lines have 0.5, touching arcs 0.25.
const FLAT: f64 = 0.1;

/// A long meeting also is a common stretch if the distance goes up and down by this share of the
/// tolerance more than once.
const WAVERING: f64 = 0.25;

/// Where neither curve ends, curves may touch, or cross twice because they were drawn a little too
/// near: they run along each other if this share of the distances exceeds the least by less than
/// FLAT ...
const MOST_FLAT: f64 = 0.75;

/// ... or if they waver by this many tolerances.
const MOST_WAVERING: f64 = 1.0;

/// The end of a common stretch is sought up to this many tolerances inwards of its last pair of
/// places.
const INWARDS: f64 = 4.0;

/// A crossing within edges must be closer than their ends by this share of the tolerance: otherwise
/// the curves are cut at a point that they have.
const BETTER: f64 = 1e-3;

/// The points of all curves, those of a curve in a row.
#[derive(Clone, Copy, Debug)]
pub struct Polylines<'a> {
    /// The points.
    pub points: &'a [Point],
    /// The arc length of every point from the beginning of its curve.
    pub along: &'a [f64],
    /// The curve of every point.
    pub curve_of: &'a [i64],
}

/// Edges and boxes around them, sorted by the first coordinate of the boxes' lower corners.
#[derive(Clone, Copy, Debug)]
pub struct Boxes<'a> {
    /// The first point of every edge.
    pub edges: &'a [i64],
    /// The lower corners.
    pub low: &'a [Point],
    /// The upper corners.
    pub high: &'a [Point],
}

/// Two edges within reach of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The edges, the lower number first.
    pub edges: [i64; 2],
    /// The nearest places on them, 0 to 1.
    pub places: [f64; 2],
    /// How far these are apart.
    pub distance: f64,
}

/// Pairs of places on curves that are, or may be, one node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Joins {
    /// The two curves of every pair.
    pub curves: Vec<[i64; 2]>,
    /// The arc lengths of the places along them.
    pub lengths: Vec<[f64; 2]>,
    /// How far the places are apart.
    pub gaps: Vec<f64>,
    /// The number of the meeting that each pair is of.
    pub meetings: Vec<i64>,
}

/// An edge of a polyline, by its ends.
#[derive(Clone, Copy, Debug)]
pub struct Edge<'a> {
    from: &'a Point,
    to: &'a Point,
}

impl<'a> Edge<'a> {
    /// Return an edge by the number of its first point.
    pub fn new(points: &'a [Point], edge: usize) -> Edge<'a> {
        Edge {
            from: &points[edge],
            to: &points[edge + 1],
        }
    }

    fn place(&self, share: f64) -> Point {
        [0, 1, 2].map(|d| self.from[d] + share * (self.to[d] - self.from[d]))
    }

    /// Return where on the edge, 0 to 1, is nearest to a place.
    fn project(&self, place: &Point) -> f64 {
        let along = subtract(self.to, self.from);
        let square = dot(&along, &along);
        if square > 0.0 {
            let share = dot(&along, &subtract(place, self.from)) / square;
            min(1.0, max(0.0, share))
        } else {
            0.0
        }
    }

    /// Return where on the edge, 0 to 1, is nearest to a place, and how far it is.
    pub fn find_nearest(&self, place: &Point) -> (f64, f64) {
        let share = self.project(place);
        let at = if share == 1.0 {
            *self.to
        } else {
            self.place(share)
        };
        (share, length(&subtract(place, &at)))
    }

    /// Return how far a place is from the edge.
    pub fn measure_distance(&self, place: &Point) -> f64 {
        let at = self.place(self.project(place));
        length(&subtract(place, &at))
    }
}

/// Return the places on two edges, 0 to 1, nearest to each other, and the distance.
///
/// Ends are taken unless places within both edges are closer by more than the margin.
pub fn find_nearest_of_edges(first: Edge, second: Edge, margin: f64) -> ([f64; 2], f64) {
    let (share, gap) = second.find_nearest(first.from);
    let mut best = ([0.0, share], gap);
    let mut offer = |places, gap| {
        if gap < best.1 {
            best = (places, gap);
        }
    };
    let (share, gap) = second.find_nearest(first.to);
    offer([1.0, share], gap);
    let (share, gap) = first.find_nearest(second.from);
    offer([share, 0.0], gap);
    let (share, gap) = first.find_nearest(second.to);
    offer([share, 1.0], gap);
    let along_first = subtract(first.to, first.from);
    let along_second = subtract(second.to, second.from);
    let between = subtract(first.from, second.from);
    let a = dot(&along_first, &along_first);
    let b = dot(&along_first, &along_second);
    let c = dot(&along_second, &along_second);
    let d = dot(&along_first, &between);
    let e = dot(&along_second, &between);
    let determinant = a * c - b * b;
    // Nearly parallel lines come nearest somewhere far off, or anywhere.
    if determinant > 1e-14 * a * c {
        let s = (b * e - c * d) / determinant;
        let u = (a * e - b * d) / determinant;
        if 0.0 < s && s < 1.0 && 0.0 < u && u < 1.0 {
            let gap = length(&subtract(&first.place(s), &second.place(u)));
            if gap < best.1 - margin {
                best = ([s, u], gap);
            }
        }
    }
    best
}

/// Return how far a point of one polyline lies at most from another.
pub fn measure_deviation(points: &[Point], other: &[Point]) -> f64 {
    let measure = |point| {
        (1..other.len()).fold(f64::INFINITY, |nearest, end| {
            let (_, distance) = Edge::new(other, end - 1).find_nearest(point);
            min(nearest, distance)
        })
    };
    points
        .iter()
        .fold(0.0, |greatest, point| max(greatest, measure(point)))
}

/// Return the pairs of edges within reach; as soon as they are more than the limit, no further ones.
///
/// Two curves meet within the lesser of their `reaches`. Curves that are `settled` are not compared
/// with each other. Pairs of edges of one curve that lie within its reach along it are left out.
pub fn find_contacts(
    lines: Polylines,
    boxes: Boxes,
    reaches: &[f64],
    settled: &[bool],
    limit: usize,
) -> Vec<Contact> {
    let Boxes { edges, low, high } = boxes;
    let mut found = Vec::new();
    for i in 0..edges.len() {
        let of_i = lines.curve_of[edges[i] as usize] as usize;
        let (low_i, high_i) = (&low[i], &high[i]);
        for k in i..edges.len() {
            let (low_k, high_k) = (&low[k], &high[k]);
            if low_k[0] > high_i[0] {
                break;
            }
            if (1..3).any(|d| low_k[d] > high_i[d] || low_i[d] > high_k[d]) {
                continue;
            }
            let of_k = lines.curve_of[edges[k] as usize] as usize;
            let tolerance = min(reaches[of_i], reaches[of_k]);
            let pair = [edges[i].min(edges[k]), edges[i].max(edges[k])];
            let [first, second] = pair.map(|edge| edge as usize);
            let is_left_out = if of_i == of_k {
                lines.along[second + 1] - lines.along[first] <= tolerance
            } else {
                settled[of_i] && settled[of_k]
            };
            if is_left_out {
                continue;
            }
            let (places, distance) = find_nearest_of_edges(
                Edge::new(lines.points, first),
                Edge::new(lines.points, second),
                BETTER * tolerance,
            );
            if distance > tolerance {
                continue;
            }
            found.push(Contact {
                edges: pair,
                places,
                distance,
            });
            if found.len() > limit {
                return found;
            }
        }
    }
    found
}

/// Return for every contact the first contact of its connected part.
///
/// Contacts are given by their two edges, and sorted by their keys: the number of the first edge
/// times the number of points, and the second. The pairs of places of two edges are a convex set; it
/// continues in the next edge if the vertex between them is within reach.
pub fn find_components(
    points: &[Point],
    curve_of: &[i64],
    keys: &[i64],
    pairs: &[[i64; 2]],
    reaches: &[f64],
) -> Vec<i64> {
    let mut parent: Vec<usize> = (0..pairs.len()).collect();
    for (contact, pair) in pairs.iter().enumerate() {
        let [one, other] = pair.map(|edge| reaches[curve_of[edge as usize] as usize]);
        let tolerance = min(one, other);
        for (edge, other) in [(pair[0], pair[1]), (pair[1], pair[0])] {
            let vertex = edge as usize + 1;
            if curve_of.get(vertex + 1) != Some(&curve_of[vertex]) {
                continue;
            }
            let (_, distance) = Edge::new(points, other as usize).find_nearest(&points[vertex]);
            if distance > tolerance {
                continue;
            }
            let vertex = vertex as i64;
            let next = vertex.min(other) * points.len() as i64 + vertex.max(other);
            if let Ok(at) = keys.binary_search(&next) {
                let (a, b) = (find_root(&mut parent, contact), find_root(&mut parent, at));
                parent[a.max(b)] = a.min(b);
            }
        }
    }
    (0..parent.len())
        .map(|contact| find_root(&mut parent, contact) as i64)
        .collect()
}

/// Return the root of an item, and halve the way there.
fn find_root(parent: &mut [usize], mut item: usize) -> usize {
    while parent[item] != item {
        parent[item] = parent[parent[item]];
        item = parent[item];
    }
    item
}

/// Return the joins of all meetings: a crossing joins at the closest pair of places, ends within
/// reach of each other at the ends, a common stretch at its two extremes.
///
/// Meeting m has the contacts from `bounds[m]` to `bounds[m + 1]`. `lasts` are the lengths of the
/// curves; `closed` are those that end where they begin.
pub fn choose_joins(
    lines: Polylines,
    lasts: &[f64],
    closed: &[bool],
    contacts: &[Contact],
    bounds: &[i64],
    reaches: &[f64],
) -> Joins {
    let mut joins = Joins::default();
    let mut places = Vec::new();
    for (number, range) in bounds.windows(2).enumerate() {
        let contacts = &contacts[range[0] as usize..range[1] as usize];
        let Some(contact) = contacts.first() else {
            continue;
        };
        let curves = contact.edges.map(|edge| lines.curve_of[edge as usize]);
        let [a, b] = curves.map(|curve| curve as usize);
        let tolerance = min(reaches[a], reaches[b]);
        list_places(lines, contacts, tolerance, &mut places);
        let meeting = Meeting {
            places: &places,
            lasts: [lasts[a], lasts[b]],
            tolerance,
            closed: closed[a] && closed[b],
        };
        for chosen in meeting.choose_places() {
            let place = &places[chosen];
            joins.curves.push(curves);
            joins.lengths.push(place.lengths);
            joins.gaps.push(place.gap);
            joins.meetings.push(number as i64);
        }
    }
    joins
}

/// The vertex that a pair of places is taken at.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Vertex {
    Neither,
    OfA(usize),
    OfB(usize),
}

/// A pair of places of a meeting.
#[derive(Clone, Copy, Debug)]
struct Places {
    /// Arc lengths on A and on B.
    lengths: [f64; 2],
    /// How far the places are apart.
    gap: f64,
    vertex: Vertex,
}

/// List pairs of places that show what a meeting is like: the closest, and all vertices.
fn list_places(lines: Polylines, contacts: &[Contact], tolerance: f64, places: &mut Vec<Places>) {
    let Polylines { points, along, .. } = lines;
    let length_at = |edge: usize, share: f64| {
        if share == 1.0 {
            along[edge + 1]
        } else {
            along[edge] + share * (along[edge + 1] - along[edge])
        }
    };
    places.clear();
    for contact in contacts {
        let [first, second] = contact.edges.map(|edge| edge as usize);
        let [a, b] = contact.places;
        places.push(Places {
            lengths: [length_at(first, a), length_at(second, b)],
            gap: contact.distance,
            vertex: Vertex::Neither,
        });
        for end in 0..2 {
            let vertex = first + end;
            let (share, gap) = Edge::new(points, second).find_nearest(&points[vertex]);
            if gap <= tolerance {
                places.push(Places {
                    lengths: [along[vertex], length_at(second, share)],
                    gap,
                    vertex: Vertex::OfA(vertex),
                });
            }
            let vertex = second + end;
            let (share, gap) = Edge::new(points, first).find_nearest(&points[vertex]);
            if gap <= tolerance {
                places.push(Places {
                    lengths: [length_at(first, share), along[vertex]],
                    gap,
                    vertex: Vertex::OfB(vertex),
                });
            }
        }
    }
}

/// A meeting of two curves A and B.
struct Meeting<'a> {
    /// Pairs of places of it, at least one.
    places: &'a [Places],
    /// The lengths of the curves.
    lasts: [f64; 2],
    tolerance: f64,
    /// Whether both curves are closed.
    closed: bool,
}

impl Meeting<'_> {
    /// Return which pairs of places are joined: one for a crossing, two for a stretch, and those of
    /// two ends.
    fn choose_places(&self) -> Vec<usize> {
        let ends = self.find_ends();
        let extents = [0, 1].map(|side| {
            let lengths = || self.places.iter().map(|place| place.lengths[side]);
            greatest(lengths()) - least(lengths())
        });
        let is_long = max(extents[0], extents[1]) > LONG * self.tolerance;
        let inner = self.closed || !self.places.iter().any(|place| self.is_at_end(place));
        if ends.len() < 2 && !(is_long && self.runs_alongside(inner)) {
            if ends.is_empty() {
                return vec![self.find_closest()];
            }
            return ends;
        }
        // A common stretch: B runs along A in the same sense, or against it.
        let sense = if self.measure_covariance() >= 0.0 {
            1.0
        } else {
            -1.0
        };
        let run = |place: &Places| {
            let [a, b] = place.lengths;
            a + sense * b
        };
        let first = self.find_extreme(run);
        let second = self.find_extreme(|place| -run(place));
        [ends, vec![first, second]].concat()
    }

    fn is_end(&self, place: &Places, side: usize) -> bool {
        place.lengths[side] == 0.0 || place.lengths[side] == self.lasts[side]
    }

    /// Return whether one of the curves ends at a pair of places.
    fn is_at_end(&self, place: &Places) -> bool {
        self.is_end(place, 0) || self.is_end(place, 1)
    }

    /// Return the closest pair of places of each two ends.
    fn find_ends(&self) -> Vec<usize> {
        let mut ends: [Option<usize>; 4] = [None; 4];
        for (number, place) in self.places.iter().enumerate() {
            if self.is_end(place, 0) && self.is_end(place, 1) {
                let [a, b] = place.lengths.map(|length| usize::from(length != 0.0));
                let closest = &mut ends[2 * a + b];
                if closest.is_none_or(|best| place.gap < self.places[best].gap) {
                    *closest = Some(number);
                }
            }
        }
        ends.into_iter().flatten().collect()
    }

    /// Return the closest pair of places, of equal ones the first along A, then B.
    fn find_closest(&self) -> usize {
        let key = |place: &Places| (place.gap, place.lengths[0], place.lengths[1]);
        (1..self.places.len()).fold(0, |best, number| {
            if key(&self.places[number]) < key(&self.places[best]) {
                number
            } else {
                best
            }
        })
    }

    /// Return the covariance of the arc lengths on A and B, times the number of places.
    fn measure_covariance(&self) -> f64 {
        let sum = |value: &dyn Fn(&Places) -> f64| {
            self.places
                .iter()
                .fold(0.0, |total, place| total + value(place))
        };
        let n = self.places.len() as f64;
        let means = [0, 1].map(|side| sum(&|place| place.lengths[side]) / n);
        sum(&|place| (place.lengths[0] - means[0]) * (place.lengths[1] - means[1]))
    }

    /// Return where a common stretch begins, where `run` is least: at an end of A or B if one is
    /// there, else nearby.
    fn find_extreme(&self, run: impl Fn(&Places) -> f64) -> usize {
        let Meeting {
            places, tolerance, ..
        } = *self;
        let least = least(places.iter().map(&run));
        let near = places
            .iter()
            .enumerate()
            .filter(|(_, place)| run(place) <= least + INWARDS * tolerance);
        let keys = near.map(|(number, place)| {
            // Distances that differ by rounding count as one: then the outermost is taken.
            let step = if tolerance > 0.0 {
                (place.gap / (BETTER * tolerance)).floor()
            } else {
                0.0
            };
            (!self.is_at_end(place), step, run(place), number)
        });
        let best = keys.reduce(|best, key| if key < best { key } else { best });
        best.expect("the least is near itself").3
    }

    /// Return whether the distance stays flat or wavers, rather than fall to one place and rise
    /// again. `inner`: neither curve ends there.
    fn runs_alongside(&self, inner: bool) -> bool {
        let of_b = self.profile(|vertex| match vertex {
            Vertex::OfB(number) => Some(number),
            _ => None,
        });
        let of_a = self.profile(|vertex| match vertex {
            Vertex::OfA(number) => Some(number),
            _ => None,
        });
        let profile = if of_a.len() >= of_b.len() { of_a } else { of_b };
        let (Some(first), Some(last)) = (profile.first(), profile.last()) else {
            return false;
        };
        let there_and_back = first + last - 2.0 * least(profile.iter().copied());
        let up_and_down = profile
            .windows(2)
            .fold(0.0, |total, pair| total + (pair[1] - pair[0]).abs());
        let wavering = up_and_down - there_and_back;
        let nearest = least(self.places.iter().map(|place| place.gap));
        let (share, most) = if inner {
            (MOST_FLAT, MOST_WAVERING)
        } else {
            (0.5, WAVERING)
        };
        let usual = find_quantile(profile, share);
        usual - nearest < FLAT * self.tolerance || wavering > most * self.tolerance
    }

    /// Return the least distance at every chosen vertex, in the order along the curve.
    fn profile(&self, choose: impl Fn(Vertex) -> Option<usize>) -> Vec<f64> {
        let mut at: Vec<(usize, f64)> = self
            .places
            .iter()
            .filter_map(|place| Some((choose(place.vertex)?, place.gap)))
            .collect();
        at.sort_unstable_by_key(|&(vertex, _)| vertex);
        at.chunk_by(|one, other| one.0 == other.0)
            .map(|same| least(same.iter().map(|&(_, gap)| gap)))
            .collect()
    }
}

fn least(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, min)
}

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, max)
}

/// Return a quantile below 1 of some values, at least one, linear between two of them.
fn find_quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    if values.len() == 1 {
        return values[0];
    }
    let rank = 1.0 + (values.len() - 1) as f64 * share;
    let floor = rank.floor();
    let part = rank - floor;
    let below = floor as usize - 1;
    values[below] * (1.0 - part) + values[below + 1] * part
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two curves of straight edges of length 1: their points, and where the second begins.
    fn curves(first: &[Point], second: &[Point]) -> (Vec<Point>, Vec<f64>, Vec<i64>) {
        let points = [first, second].concat();
        let along = (0..first.len()).chain(0..second.len()).map(|k| k as f64);
        let curve_of = (0..points.len()).map(|k| i64::from(k >= first.len()));
        (points.clone(), along.collect(), curve_of.collect())
    }

    fn join(first: &[Point], second: &[Point], reach: f64) -> Joins {
        let (points, along, curve_of) = curves(first, second);
        let lines = Polylines {
            points: &points,
            along: &along,
            curve_of: &curve_of,
        };
        let mut edges: Vec<i64> = (0..points.len() as i64 - 1)
            .filter(|&edge| edge as usize != first.len() - 1)
            .collect();
        let bound = |edge: i64, choose: fn(f64, f64) -> f64, by: f64| {
            let Edge { from, to } = Edge::new(&points, edge as usize);
            [0, 1, 2].map(|d| choose(from[d], to[d]) + by)
        };
        let low = |edge: i64| bound(edge, min, -reach / 2.0);
        edges.sort_by(|&a, &b| low(a)[0].total_cmp(&low(b)[0]));
        let lows: Vec<Point> = edges.iter().map(|&edge| low(edge)).collect();
        let highs: Vec<Point> = edges
            .iter()
            .map(|&edge| bound(edge, max, reach / 2.0))
            .collect();
        let boxes = Boxes {
            edges: &edges,
            low: &lows,
            high: &highs,
        };
        let reaches = [reach; 2];
        let mut contacts = find_contacts(lines, boxes, &reaches, &[false; 2], 1000);
        contacts.retain(|contact| {
            let [a, b] = contact.edges.map(|edge| curve_of[edge as usize]);
            a != b
        });
        let key = |contact: &Contact| contact.edges[0] * points.len() as i64 + contact.edges[1];
        contacts.sort_by_key(key);
        let keys: Vec<i64> = contacts.iter().map(key).collect();
        let pairs: Vec<[i64; 2]> = contacts.iter().map(|contact| contact.edges).collect();
        let roots = find_components(&points, &curve_of, &keys, &pairs, &reaches);
        assert!(roots.iter().all(|&root| root == 0));
        let lasts = [first.len() as f64 - 1.0, second.len() as f64 - 1.0];
        let bounds = [0, contacts.len() as i64];
        choose_joins(lines, &lasts, &[false; 2], &contacts, &bounds, &reaches)
    }

    #[test]
    fn a_crossing_joins_once_where_it_is() {
        let across = [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [1.5, 0.0, 0.0]];
        let up = [[0.25, -0.5, 0.0], [0.25, 0.5, 0.0], [0.25, 1.5, 0.0]];
        let joins = join(&across, &up, 0.01);
        assert_eq!(joins.curves, [[0, 1]]);
        assert_eq!(joins.lengths, [[0.75, 0.5]]);
        assert_eq!(joins.gaps, [0.0]);
    }

    #[test]
    fn a_common_stretch_joins_at_both_its_ends() {
        let line = |from: f64, y: f64| [0.0, 1.0, 2.0, 3.0, 4.0].map(|x| [from + x, y, 0.0]);
        let joins = join(&line(0.0, 0.0), &line(2.0, 0.1), 0.2);
        let mut lengths = joins.lengths;
        lengths.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(lengths, [[2.0, 0.0], [4.0, 2.0]]);
    }

    #[test]
    fn edges_that_cross_are_nearest_where_they_cross() {
        let points = [
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [1.0, -1.0, 1.0],
            [1.0, 3.0, 1.0],
        ];
        let (first, second) = (Edge::new(&points, 0), Edge::new(&points, 2));
        assert_eq!(
            find_nearest_of_edges(first, second, 0.0),
            ([0.5, 0.25], 1.0)
        );
        // The margin is not reached: an end is taken.
        assert_eq!(find_nearest_of_edges(first, second, 1.0).0, [0.0, 0.25]);
    }

    #[test]
    fn the_deviation_is_that_of_the_farthest_point() {
        let line = [[0.0; 3], [4.0, 0.0, 0.0]];
        let other = [[1.0, 2.0, 0.0], [7.0, 4.0, 0.0]];
        assert_eq!(measure_deviation(&other, &line), 5.0);
        assert_eq!(find_quantile(vec![3.0, 1.0, 2.0], 0.75), 2.5);
        assert_eq!(find_quantile(vec![3.0], 0.5), 3.0);
    }
}
