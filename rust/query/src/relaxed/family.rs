//! Growing patterns: glue a strip of quads onto a pattern's boundary, reduce, and go on.
//!
//! Peeling the strip off a side between two convex corners turns interior vertices of valence 3 into
//! convex corners and those of valence 5 into reflex ones: the number of irregular and reflex vertices
//! never grows. So from one quad, strips glued back reach every pattern with few of them, whoever made
//! it. A strip may end between two quads of one polychord, so polychords are made wider first. There is
//! no proof that none is missed; the tests in Python compare with patterns found otherwise.
//!
//! Source: own. The definitions are those of Marcias et al. 2015, section 3.

use std::collections::HashSet;

use patterndb_core::code::{Reading, Sense, border_count, border_from, smallest_code};
use patterndb_core::halfedge::{fans, next_edge};
use patterndb_core::reduction::{Disk, NEVER_FULL, ReductionWork, dissolve};

/// How a strip lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Strip {
    /// From one boundary vertex to another, or once round to itself.
    Open,
    /// All round.
    Ring,
    /// All round with a corner quad of its own.
    CornerRing,
}

/// Return the half-edges of a pattern with every polychord `width` wide.
fn widen_polychords(twin: &[i32], width: i32) -> Vec<i32> {
    let mut wide = Vec::with_capacity(twin.len() * (width * width) as usize);
    for cell in 0..twin.len() as i32 / 4 * width * width {
        let cell = 4 * cell;
        wide.extend([
            cell - 4 * width + 2,
            cell + 4 + 3,
            cell + 4 * width,
            cell - 4 + 1,
        ]);
    }
    for (h, &across) in twin.iter().enumerate() {
        for t in 0..width {
            let other = if across >= 0 {
                edge_of_cell(across, width - 1 - t, width)
            } else {
                -1
            };
            wide[edge_of_cell(h as i32, t, width) as usize] = other;
        }
    }
    wide
}

/// Return part t, counter-clockwise, of a pattern's half-edge.
fn edge_of_cell(h: i32, t: i32, width: i32) -> i32 {
    let last = width - 1;
    let (i, j) = match h & 3 {
        0 => (t, 0),
        1 => (last, t),
        2 => (last - t, last),
        _ => (0, last - t),
    };
    4 * ((h >> 2) * width * width + j * width + i) + (h & 3)
}

/// A disk onto which strips are glued.
struct Base {
    twin: Vec<i32>,
    /// The border half-edges in order.
    border: Vec<i32>,
    /// The quads at their tails.
    count: Vec<i32>,
}

impl Base {
    fn new(twin: Vec<i32>) -> Base {
        let first = twin.iter().position(|&t| t < 0);
        let first = first.expect("a disk has a border") as i32;
        let border = border_from(&twin, first);
        let count = border.iter().map(|&h| border_count(&twin, h)).collect();
        Base {
            twin,
            border,
            count,
        }
    }

    fn n_reflex(&self) -> i32 {
        self.count.iter().filter(|&&count| count > 2).count() as i32
    }

    fn perimeter(&self) -> usize {
        self.border.len()
    }

    /// Return the quads at a vertex of the border, counted on beyond its end.
    fn count_at(&self, vertex: usize) -> i32 {
        self.count[vertex % self.count.len()]
    }

    /// Let `look` see the disk with a strip of `length` quads on its border from vertex `first`.
    fn with_strip<T>(
        &mut self,
        first: usize,
        length: usize,
        strip: Strip,
        look: impl FnOnce(&[i32]) -> T,
    ) -> T {
        let size = self.twin.len();
        let perimeter = self.perimeter();
        let edge = |i: usize| self.border[(first + i) % perimeter];
        for i in 0..length {
            let new = self.twin.len() as i32;
            self.twin[edge(i) as usize] = new;
            self.twin.extend([edge(i), new - 4 + 3, -1, new + 4 + 1]);
        }
        let (start, end) = (size + 1, self.twin.len() - 1);
        match strip {
            Strip::Open => {
                self.twin[start] = -1;
                self.twin[end] = -1;
            }
            Strip::Ring => {
                self.twin[start] = end as i32;
                self.twin[end] = start as i32;
            }
            Strip::CornerRing => {
                let corner = self.twin.len() as i32;
                self.twin[start] = corner;
                self.twin[end] = corner + 1;
                self.twin.extend([start as i32, end as i32, -1, -1]);
            }
        }
        let seen = look(&self.twin);
        for i in 0..length {
            self.twin[edge(i) as usize] = -1;
        }
        self.twin.truncate(size);
        seen
    }

    /// Return what the ends of a strip add, or None where they are not within bounds.
    fn count_added(
        &self,
        first: usize,
        length: usize,
        strip: Strip,
        valence: i32,
    ) -> Option<Added> {
        let a = self.count[first];
        let (fits, n_irregular, n_reflex) = match strip {
            Strip::Open if length < self.perimeter() => {
                let b = self.count_at(first + length);
                (
                    a.max(b) < valence - 2,
                    0,
                    i32::from(a == 2) + i32::from(b == 2),
                )
            }
            Strip::Open => (a + 2 <= valence - 2, 0, i32::from(a <= 2)),
            Strip::Ring | Strip::CornerRing => {
                let now = if strip == Strip::Ring { a + 2 } else { a + 3 };
                (now <= valence, i32::from(now != 4), -i32::from(a > 2))
            }
        };
        fits.then_some(Added {
            n_irregular,
            n_reflex,
        })
    }
}

/// Irregular vertices and reflex corners at the ends of a strip.
struct Added {
    n_irregular: i32,
    n_reflex: i32,
}

/// Widest that polychords are made before a strip is glued on. A strip may end between two quads of one
/// polychord at either end of it, hence three wide.
const WIDEST: i32 = 3;

/// Scratch of [`Coder::write_code`].
struct Coder {
    gone: Vec<i64>,
    seen: Vec<i64>,
    stamp: [i64; 2],
    border: Vec<i32>,
    block: Vec<i32>,
    head: Vec<i32>,
    reduced: Vec<i32>,
    starts: Vec<i32>,
    number: Vec<i32>,
    entry: Vec<i32>,
    order: Vec<i32>,
    code: Vec<u16>,
    mirrored: Vec<u16>,
    max_quads: usize,
}

impl Coder {
    /// Make scratch for disks of `room` quads and patterns of `max_quads`.
    fn new(room: usize, max_quads: usize) -> Coder {
        let sides = || vec![0; 4 * room];
        Coder {
            gone: vec![0; 4 * room],
            seen: vec![0; 4 * room],
            stamp: [0; 2],
            border: sides(),
            block: vec![-1; 4 * room],
            head: sides(),
            reduced: sides(),
            starts: sides(),
            number: vec![0; max_quads],
            entry: vec![0; max_quads],
            order: vec![0; max_quads],
            code: vec![0; 4 * max_quads],
            mirrored: vec![0; 4 * max_quads],
            max_quads,
        }
    }

    /// Return the canonical code of the pattern of a disk, or None where it is too large.
    fn write_code(&mut self, twin: &[i32]) -> Option<&[u16]> {
        let (vertex, n_vertices) = fans(twin);
        let mut count = vec![0; n_vertices as usize];
        for &v in &vertex {
            count[v as usize] += 1;
        }
        let mut full = count.clone();
        for h in (0..twin.len()).filter(|&h| twin[h] < 0) {
            full[vertex[h] as usize] = NEVER_FULL;
            full[vertex[next_edge(h as i32) as usize] as usize] = NEVER_FULL;
        }
        let disk = Disk {
            twin,
            vertex: &vertex,
            count: &count,
            full: &full,
        };
        let mut work = ReductionWork {
            gone: &mut self.gone,
            seen: &mut self.seen,
            stamp: &mut self.stamp,
            border: &mut self.border,
            block: &mut self.block,
            head: &mut self.head,
            reduced: &mut self.reduced,
            starts: &mut self.starts,
        };
        let (m, n_starts) = dissolve(disk, &mut work);
        if m > self.max_quads {
            return None;
        }
        let mut reading = Reading {
            number: &mut self.number,
            entry: &mut self.entry,
            order: &mut self.order,
        };
        let starts = &self.starts[..n_starts];
        for (sense, code) in [
            (Sense::CounterClockwise, &mut self.code),
            (Sense::Clockwise, &mut self.mirrored),
        ] {
            smallest_code(&self.reduced, m, starts, sense, code, &mut reading);
        }
        Some((&self.code[..4 * m]).min(&self.mirrored[..4 * m]))
    }
}

/// Patterns that were grown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grown {
    /// Their canonical codes, one after the other.
    pub flat: Vec<u16>,
    /// Where each code begins, and where the last ends.
    pub offsets: Vec<i64>,
}

/// Bounds of what is grown.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// The most irregular interior vertices and reflex corners together.
    pub most: i32,
    /// The greatest valence of an interior vertex, two less at the boundary.
    pub valence: i32,
    /// Quads; larger patterns are neither kept nor grown.
    pub max_quads: usize,
}

/// Grow all patterns that strips make of one quad. Once `is_cancelled`, some are missing.
pub fn grow_patterns(bounds: Bounds, is_cancelled: &impl Fn() -> bool) -> Grown {
    let mut growth = Growth::new(bounds);
    let mut row = 0;
    while row < growth.interior.len() && !is_cancelled() {
        growth.grow(row);
        row += 1;
    }
    growth.grown
}

struct Growth {
    bounds: Bounds,
    coder: Coder,
    grown: Grown,
    known: HashSet<Vec<u16>>,
    /// Irregular interior vertices of each pattern.
    interior: Vec<i32>,
}

impl Growth {
    fn new(bounds: Bounds) -> Growth {
        // A pattern's border has at most 2 edges a quad and 2 more; a strip has a quad for each.
        let (widest, max_quads) = (WIDEST as usize, bounds.max_quads);
        let room = widest * widest * max_quads + 2 * widest * (max_quads + 1) + 1;
        let quad = vec![0; 4];
        Growth {
            bounds,
            coder: Coder::new(room, max_quads),
            grown: Grown {
                flat: quad.clone(),
                offsets: vec![0, 4],
            },
            known: HashSet::from([quad]),
            interior: vec![0],
        }
    }

    /// Glue all strips onto a pattern and keep what is new.
    fn grow(&mut self, row: usize) {
        let Bounds { most, valence, .. } = self.bounds;
        let [begin, end] = [row, row + 1].map(|row| self.grown.offsets[row] as usize);
        let code = &self.grown.flat[begin..end];
        let twin: Vec<i32> = code.iter().map(|&symbol| i32::from(symbol) - 1).collect();
        let inside = self.interior[row];
        let n_reflex = Base::new(twin.clone()).n_reflex();
        let width = 1 + (WIDEST - 1).min(most - inside - n_reflex);
        let mut base = Base::new(widen_polychords(&twin, width));
        let perimeter = base.perimeter();
        for first in 0..perimeter {
            // The strip's inner vertices become interior ones.
            let (mut fresh, mut buried) = (0, 0);
            for length in 1..=perimeter {
                if length > 1 {
                    let count = base.count_at(first + length - 1);
                    fresh += i32::from(count != 2);
                    buried += i32::from(count > 2);
                    // Neither falls again as the strip gets longer.
                    if count + 2 > valence || inside + n_reflex + fresh - buried > most {
                        break;
                    }
                }
                // A ring goes once round, and is the same from wherever it begins.
                let strips: &[Strip] = match (length == perimeter, first == 0) {
                    (false, _) => &[Strip::Open],
                    (true, true) => &[Strip::Open, Strip::Ring, Strip::CornerRing],
                    (true, false) => &[Strip::Open, Strip::CornerRing],
                };
                for &strip in strips {
                    let Some(added) = base.count_added(first, length, strip, valence) else {
                        continue;
                    };
                    let inner = inside + fresh + added.n_irregular;
                    if inner + n_reflex - buried + added.n_reflex <= most {
                        self.keep(&mut base, first, length, strip, inner);
                    }
                }
            }
        }
    }

    /// Keep the pattern of a disk with a strip, if it is new.
    fn keep(&mut self, base: &mut Base, first: usize, length: usize, strip: Strip, inner: i32) {
        let Self {
            coder,
            known,
            grown,
            interior,
            ..
        } = self;
        base.with_strip(first, length, strip, |twin| {
            let Some(code) = coder.write_code(twin) else {
                return;
            };
            if !known.contains(code) {
                known.insert(code.to_vec());
                grown.flat.extend(code);
                grown.offsets.push(grown.flat.len() as i64);
                interior.push(inner);
            }
        });
    }
}

/// Return for each pattern whether no two edges join the same two vertices when every polychord is 1
/// wide.
///
/// Pattern i has the code `flat[offsets[i]..offsets[i + 1]]`.
pub fn meshes(flat: &[u16], offsets: &[i64]) -> Vec<bool> {
    let codes = offsets.windows(2);
    codes
        .map(|ends| is_mesh(&flat[ends[0] as usize..ends[1] as usize]))
        .collect()
}

fn is_mesh(code: &[u16]) -> bool {
    let twin: Vec<i32> = code.iter().map(|&symbol| i32::from(symbol) - 1).collect();
    let (vertex, n_vertices) = fans(&twin);
    let vertex_of = |h: i32| vertex[h as usize];
    // The half-edges so far, by their tails; few leave one vertex.
    let mut leaving: Vec<Option<usize>> = vec![None; n_vertices as usize];
    let mut after = vec![None; twin.len()];
    for (h, &tail) in vertex.iter().enumerate() {
        let ahead = next_edge(h as i32);
        let head = vertex_of(ahead);
        if head == tail || vertex_of(next_edge(ahead)) == tail {
            return false;
        }
        let first = &mut leaving[tail as usize];
        let mut others = std::iter::successors(*first, |&other| after[other]);
        if others.any(|other| vertex_of(next_edge(other as i32)) == head) {
            return false;
        }
        after[h] = *first;
        *first = Some(h);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_quad_is_a_grid() {
        let base = Base::new(widen_polychords(&[-1; 4], 3));
        assert_eq!(base.perimeter(), 12);
        assert_eq!(base.count.iter().filter(|&&count| count == 1).count(), 4);
        assert_eq!(base.n_reflex(), 0);
    }

    #[test]
    fn a_strip_is_taken_off_again() {
        let mut base = Base::new(vec![-1; 4]);
        for strip in [Strip::Open, Strip::Ring, Strip::CornerRing] {
            let n = base.with_strip(0, 4, strip, |twin| {
                let inner = (0..twin.len()).filter(|&h| twin[h] >= 0);
                for h in inner {
                    assert_eq!(twin[twin[h] as usize], h as i32);
                }
                twin.len() / 4
            });
            assert_eq!(n, if strip == Strip::CornerRing { 6 } else { 5 });
            assert_eq!(base.twin, [-1; 4]);
        }
    }

    #[test]
    fn families_begin_with_one_quad() {
        let bounds = Bounds {
            most: 0,
            valence: 5,
            max_quads: 20,
        };
        assert_eq!(grow_patterns(bounds, &|| false).flat, [0; 4]);
        let more = grow_patterns(Bounds { most: 1, ..bounds }, &|| false);
        assert!(more.offsets.len() > 3);
    }

    #[test]
    fn a_quad_joined_to_itself_is_no_mesh() {
        let flat = [0, 0, 0, 0, 0, 4, 0, 2];
        assert_eq!(meshes(&flat, &[0, 4, 8]), [true, false]);
    }
}
