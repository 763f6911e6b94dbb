//! Where the corners of a boundary may fall on a pattern: every choice of marks within bounds.
//!
//! A mark lies on a boundary vertex, or at a *slot* inside a boundary edge, where it parts the
//! polychord that crosses the edge into *strands*. The slots of a polychord are ordered across it;
//! its two ends see the same order, reversed. On one polychord with m marks, any sequence of slots
//! is a choice, each with a mark at the one end, the other, or both: no other sites matter.

use std::cmp::Ordering;

use patterndb_core::code::{Reading, Sense, border_count, border_from, rooted_code};
use patterndb_core::polychord::trace;

/// The boundary of a pattern, from corner 0 on.
pub struct Rim {
    /// Number of quads at each boundary vertex.
    pub quads: Vec<i32>,
    /// Polychord that crosses each boundary edge, in label order.
    pub chord: Vec<usize>,
    /// The first and the other edge that each polychord ends on.
    pub ends: Vec<[usize; 2]>,
    /// The symmetries of the pattern.
    pub symmetries: Vec<Symmetry>,
}

/// A symmetry of a pattern: vertex i looks like vertex `shift + i` and edge i like edge `shift + i`,
/// or, reflected, like vertex `shift - i` and edge `shift - i - 1`.
#[derive(Clone, Copy)]
pub struct Symmetry {
    shift: usize,
    reflected: bool,
}

impl Symmetry {
    /// Return the vertex and the edge that vertex and edge `i` of `perimeter` look like.
    fn image(self, i: usize, perimeter: usize) -> (usize, usize) {
        if self.reflected {
            let turned = self.shift + perimeter - i;
            (turned % perimeter, (turned + perimeter - 1) % perimeter)
        } else {
            let turned = (self.shift + i) % perimeter;
            (turned, turned)
        }
    }
}

impl Rim {
    /// Trace the boundary of the pattern of a canonical code.
    pub fn of_code(code: &[u16]) -> Self {
        let twin: Vec<i32> = code.iter().map(|&symbol| i32::from(symbol) - 1).collect();
        let border = border_from(&twin, 0);
        let quads: Vec<i32> = border.iter().map(|&h| border_count(&twin, h)).collect();
        let polychords = trace(&twin);
        let mut name = vec![None; polychords.n as usize];
        let mut ends: Vec<[usize; 2]> = Vec::with_capacity(polychords.n_open as usize);
        let mut chord = Vec::with_capacity(border.len());
        for (i, &h) in border.iter().enumerate() {
            let name = &mut name[polychords.of_edge[h as usize] as usize];
            match *name {
                Some(c) => {
                    let ends: &mut [usize; 2] = &mut ends[c];
                    ends[1] = i;
                }
                None => {
                    *name = Some(ends.len());
                    ends.push([i, i]);
                }
            }
            chord.extend(*name);
        }
        let symmetries = list_symmetries(code, &twin, &border, &quads);
        Self {
            quads,
            chord,
            ends,
            symmetries,
        }
    }

    /// Does no symmetry of the pattern take the marks to a smaller image? Of all images of a choice
    /// exactly one passes.
    fn is_first_image(&self, marks: &Marks) -> bool {
        let perimeter = self.quads.len();
        self.symmetries.iter().all(|symmetry| {
            (0..perimeter)
                .map(|i| {
                    let (v, e) = symmetry.image(i, perimeter);
                    let bits = if symmetry.reflected {
                        mirror_bits(marks.bits[e], marks.slots[e])
                    } else {
                        marks.bits[e]
                    };
                    let mine = (marks.at_vertex[i], marks.slots[i], marks.bits[i]);
                    (marks.at_vertex[v], marks.slots[e], bits).cmp(&mine)
                })
                .find(|order| order.is_ne())
                != Some(Ordering::Less)
        })
    }
}

fn list_symmetries(code: &[u16], twin: &[i32], border: &[i32], quads: &[i32]) -> Vec<Symmetry> {
    let q = code.len() / 4;
    let (mut number, mut entry, mut order) = (vec![0; q], vec![0; q], vec![0; q]);
    let mut seen = code.to_vec();
    let mut found = Vec::new();
    for shift in (0..border.len()).filter(|&i| quads[i] == quads[0]) {
        for sense in [Sense::CounterClockwise, Sense::Clockwise] {
            seen.copy_from_slice(code);
            let start = sense.start(twin, border[shift]);
            let mut reading = Reading {
                number: &mut number,
                entry: &mut entry,
                order: &mut order,
            };
            if rooted_code(twin, q, start, sense, &mut seen, &mut reading, true).is_eq() {
                found.push(Symmetry {
                    shift,
                    reflected: sense == Sense::Clockwise,
                });
            }
        }
    }
    found
}

/// Return the lowest `n` bits in reverse order.
fn mirror_bits(bits: i32, n: i32) -> i32 {
    (0..n).fold(0, |mirrored, s| mirrored | ((bits >> s & 1) << (n - 1 - s)))
}

/// A choice of marks, vertex by vertex and edge by edge of a rim.
struct Marks {
    at_vertex: Vec<bool>,
    /// Slots of every edge.
    slots: Vec<i32>,
    /// Bit s is set where slot s of an edge has a mark, counter-clockwise.
    bits: Vec<i32>,
}

impl Marks {
    fn new(perimeter: usize) -> Self {
        Self {
            at_vertex: vec![false; perimeter],
            slots: vec![0; perimeter],
            bits: vec![0; perimeter],
        }
    }

    /// Is there a mark where a strand of an edge begins?
    fn is_marked(&self, edge: usize, strand: i32) -> bool {
        if strand == 0 {
            self.at_vertex[edge]
        } else {
            self.bits[edge] >> (strand - 1) & 1 == 1
        }
    }
}

/// A way to set marks into the slots of one polychord.
#[derive(Clone, Copy)]
pub struct CornerSites {
    /// Number of marks.
    pub marks: i32,
    /// Number of slots; there is one strand more.
    pub slots: i32,
    /// Bit s is set where slot s has a mark at the polychord's first end. Slots are counted across
    /// it as that end sees them.
    pub near: i32,
    /// The same at its other end.
    pub far: i32,
}

/// Columns of a record's head. The counts at its N marks follow, then the upper triangle of the
/// strands that join its sides, row by row, in the order of its system.
#[derive(Clone, Copy)]
enum Column {
    Pattern,
    Cost,
    /// Corners of the pattern without a mark.
    Unmarked,
    /// 0 where the marks are the pattern's corners.
    Relaxed,
    /// Strand ends.
    Perimeter,
    StartEdge,
    StartStrand,
    Rotation,
    Reflected,
    Strands,
}

/// Number of columns of a record's head before the counts at its marks.
const HEAD: usize = 10;

/// Records as they are found.
#[derive(Default)]
pub struct Records {
    /// `HEAD + N + N (N + 1) / 2` numbers for each record.
    pub head: Vec<i32>,
    /// For each record the number of strands on side 0, their numbers, and so on.
    pub label: Vec<i16>,
    /// For each record the polychord of each strand.
    pub chord: Vec<i16>,
}

impl Records {
    /// Return the number of columns of `head` for `n_marks` marks.
    pub fn width(n_marks: usize) -> usize {
        HEAD + n_marks + n_marks * (n_marks + 1) / 2
    }
}

/// What marks may cost.
#[derive(Clone, Copy)]
pub struct Bounds {
    /// Number of marks.
    pub n_marks: usize,
    /// Irregular vertices at most, those inside included.
    pub most: i32,
    /// Are the marks of a free table, where each is as good as any other?
    pub free: bool,
}

/// A pattern to be marked.
pub struct Unmarked<'a> {
    /// Its canonical code.
    pub code: &'a [u16],
    /// Its irregular vertices inside.
    pub n_irregular: i32,
    /// Its reflex corners.
    pub n_reflex: i32,
}

/// List every way to set marks on each of the patterns, up to symmetry.
///
/// Once `is_cancelled`, those of the last patterns are missing.
pub fn list_records<'a>(
    patterns: impl IntoIterator<Item = Unmarked<'a>>,
    bounds: Bounds,
    sites: &[CornerSites],
    is_cancelled: &impl Fn() -> bool,
) -> Records {
    let mut records = Records::default();
    for (number, pattern) in patterns.into_iter().enumerate() {
        if is_cancelled() {
            break;
        }
        let rim = Rim::of_code(pattern.code);
        if let Some(search) = Search::new(&rim, &pattern, bounds, sites) {
            search.run(|marks| {
                write_record(
                    &rim,
                    marks,
                    number,
                    pattern.n_irregular,
                    bounds,
                    &mut records,
                );
            });
        }
    }
    records
}

/// The search for all choices of marks on one pattern.
///
/// Vertex by vertex, then polychord by polychord: which option is taken, and what the options before
/// it cost and set.
struct Search<'a> {
    rim: &'a Rim,
    sites: &'a [CornerSites],
    n_marks: i32,
    free: bool,
    budget: i32,
    /// Corners from each vertex on that can still get a mark at no cost.
    corners: Vec<i32>,
}

impl<'a> Search<'a> {
    /// None where no choice is within the bounds.
    fn new(
        rim: &'a Rim,
        pattern: &Unmarked,
        bounds: Bounds,
        sites: &'a [CornerSites],
    ) -> Option<Self> {
        let perimeter = rim.quads.len();
        let mut corners = vec![0; perimeter + rim.ends.len() + 1];
        for i in (0..perimeter).rev() {
            corners[i] = corners[i + 1] + i32::from(rim.quads[i] != 2);
        }
        let n_marks = bounds.n_marks as i32;
        let mut budget = bounds.most - pattern.n_irregular - pattern.n_reflex;
        if bounds.free {
            // Every corner is irregular, marked or not.
            budget -= corners[0] - pattern.n_reflex;
        }
        let reachable = bounds.free || (corners[0] - n_marks).abs() <= budget + pattern.n_reflex;
        (budget >= 0 && reachable).then_some(Self {
            rim,
            sites,
            n_marks,
            free: bounds.free,
            budget,
            corners,
        })
    }

    fn run(&self, mut found: impl FnMut(&Marks)) {
        self.choose(0, 0, 0, &mut Marks::new(self.rim.quads.len()), &mut found);
    }

    /// Choose for the vertex or polychord `item` and all after it.
    fn choose(
        &self,
        item: usize,
        spent: i32,
        placed: i32,
        marks: &mut Marks,
        found: &mut impl FnMut(&Marks),
    ) {
        let perimeter = self.rim.quads.len();
        if item == perimeter + self.rim.ends.len() {
            if placed == self.n_marks && self.rim.is_first_image(marks) {
                found(marks);
            }
        } else if item < perimeter {
            for more in [0, 1] {
                let cost = match self.rim.quads[item] {
                    _ if self.free => 0,
                    1 => 1 - more,
                    2 => more,
                    _ => 0,
                };
                if self.allows(item, spent + cost, placed + more) {
                    marks.at_vertex[item] = more == 1;
                    self.choose(item + 1, spent + cost, placed + more, marks, found);
                }
            }
        } else {
            let [near, far] = self.rim.ends[item - perimeter];
            for site in self.sites {
                let cost = if self.free { 0 } else { site.marks };
                // Those with fewer marks come first.
                if placed + site.marks > self.n_marks || spent + cost > self.budget {
                    break;
                }
                if self.allows(item, spent + cost, placed + site.marks) {
                    marks.slots[near] = site.slots;
                    marks.slots[far] = site.slots;
                    marks.bits[near] = site.near;
                    marks.bits[far] = mirror_bits(site.far, site.slots);
                    self.choose(item + 1, spent + cost, placed + site.marks, marks, found);
                }
            }
        }
    }

    /// Can a choice be completed within the bounds?
    fn allows(&self, item: usize, spent: i32, placed: i32) -> bool {
        spent <= self.budget
            && placed <= self.n_marks
            && (self.free || placed + self.corners[item + 1] + self.budget - spent >= self.n_marks)
    }
}

fn write_record(
    rim: &Rim,
    marks: &Marks,
    pattern: usize,
    n_irregular: i32,
    bounds: Bounds,
    records: &mut Records,
) {
    let n = bounds.n_marks;
    let begin = records.head.len();
    records.head.resize(begin + Records::width(n), 0);
    let (columns, rest) = records.head[begin..].split_at_mut(HEAD);
    let (counts, system) = rest.split_at_mut(n);
    let mut joins = Joins {
        n,
        of: vec![0; n * n],
    };
    let label = write_label(
        rim,
        marks,
        counts,
        &mut records.label,
        &mut records.chord,
        &mut joins,
    );
    let (rotation, reflected) = joins.write_canonical_system(system);
    let corners = rim.quads.iter().filter(|&&quads| quads != 2).count();
    let unmarked = (0..rim.quads.len())
        .filter(|&i| rim.quads[i] != 2 && !marks.at_vertex[i])
        .count();
    let mut set = |column: Column, value: usize| columns[column as usize] = value as i32;
    set(Column::Pattern, pattern);
    set(Column::Cost, n_irregular as usize + unmarked);
    set(Column::Unmarked, unmarked);
    set(Column::Relaxed, usize::from(unmarked > 0 || corners != n));
    set(Column::Perimeter, 2 * label.n_strands);
    set(Column::StartEdge, label.start_edge);
    set(Column::StartStrand, label.start_strand);
    set(Column::Rotation, rotation);
    set(Column::Reflected, usize::from(reflected));
    set(Column::Strands, label.n_strands);
}

/// Where a record's label begins, and how many strands it has.
struct Label {
    start_edge: usize,
    start_strand: usize,
    n_strands: usize,
}

/// Append a record's label and the polychords of its strands, from the first mark on.
///
/// `counts` gets the quads at the marks; `joins` how many strands join two sides, where a strand
/// with both ends on a side counts once.
fn write_label(
    rim: &Rim,
    marks: &Marks,
    counts: &mut [i32],
    label: &mut Vec<i16>,
    chord: &mut Vec<i16>,
    joins: &mut Joins,
) -> Label {
    let perimeter = marks.slots.len();
    // Strands of all polychords in one list, each polychord's as its near end sees them.
    let mut base = vec![0];
    for ends in &rim.ends {
        base.push(base[base.len() - 1] + marks.slots[ends[0]] as usize + 1);
    }
    let mut known: Vec<Option<(i16, usize)>> = vec![None; base[rim.ends.len()]];
    let step = |edge: usize, strand: i32| {
        if strand < marks.slots[edge] {
            (edge, strand + 1)
        } else {
            ((edge + 1) % perimeter, 0)
        }
    };
    let mut at = (0, 0);
    while !marks.is_marked(at.0, at.1) {
        at = step(at.0, at.1);
    }
    let start = at;
    let mut n_strands = 0;
    let mut side = 0;
    let mut size_at = label.len();
    let mut n_sides = 0;
    loop {
        let (edge, strand) = at;
        if marks.is_marked(edge, strand) {
            side = n_sides;
            n_sides += 1;
            counts[side] = if strand == 0 { rim.quads[edge] } else { 2 };
            size_at = label.len();
            label.push(0);
        }
        let c = rim.chord[edge];
        let is_near = rim.ends[c][0] == edge;
        let across = if is_near {
            strand
        } else {
            marks.slots[edge] - strand
        };
        let (name, _) = match &mut known[base[c] + across as usize] {
            Some(first) => {
                joins.add(first.1, side);
                *first
            }
            unknown => {
                chord.push(c as i16);
                n_strands += 1;
                *unknown.insert((n_strands as i16 - 1, side))
            }
        };
        label.push(name);
        label[size_at] += 1;
        at = step(edge, strand);
        if at == start {
            let (start_edge, start_strand) = (start.0, start.1 as usize);
            return Label {
                start_edge,
                start_strand,
                n_strands,
            };
        }
    }
}

/// How many strands join each two of `n` sides; symmetric.
struct Joins {
    n: usize,
    of: Vec<i32>,
}

impl Joins {
    fn add(&mut self, i: usize, j: usize) {
        self.of[i * self.n + j] += 1;
        if i != j {
            self.of[j * self.n + i] += 1;
        }
    }

    /// Write the smallest image over all rotations and reflections, its upper triangle row by row.
    ///
    /// Returns (rotation, reflected): side i of the system is side rotation + i, or rotation - i.
    fn write_canonical_system(&self, system: &mut [i32]) -> (usize, bool) {
        let n = self.n;
        let mut best = None;
        for reflected in [false, true] {
            for rotation in 0..n {
                let turn = |i: usize| {
                    if reflected {
                        (rotation + n - i) % n
                    } else {
                        (rotation + i) % n
                    }
                };
                let image = (0..n)
                    .flat_map(|i| (i..n).map(move |j| (i, j)))
                    .map(|(i, j)| self.of[turn(i) * n + turn(j)]);
                if best.is_none() || image.clone().lt(system.iter().copied()) {
                    for (place, value) in system.iter_mut().zip(image) {
                        *place = value;
                    }
                    best = Some((rotation, reflected));
                }
            }
        }
        best.unwrap_or((0, false))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_has_eight_symmetries_and_one_choice_of_its_corners() {
        let code = [0; 4];
        assert_eq!(Rim::of_code(&code).symmetries.len(), 8);
        let pattern = Unmarked {
            code: &code,
            n_irregular: 0,
            n_reflex: 0,
        };
        let none = CornerSites {
            marks: 0,
            slots: 0,
            near: 0,
            far: 0,
        };
        let bounds = Bounds {
            n_marks: 4,
            most: 0,
            free: false,
        };
        let records = list_records([pattern], bounds, &[none], &|| false);
        assert_eq!(records.head.len(), Records::width(4));
        assert_eq!(records.label, [1, 0, 1, 1, 1, 0, 1, 1]);
        assert_eq!(records.chord, [0, 1]);
    }

    #[test]
    fn bits_are_mirrored() {
        assert_eq!(mirror_bits(0b0011, 4), 0b1100);
        assert_eq!(mirror_bits(0b001, 3), 0b100);
    }
}
