//! Everything about a pattern that follows from its code, for many patterns at once.

use std::cmp::Ordering;

use crate::code::{Reading, Sense, border_count, border_from, is_disk_code, rooted_code};
use crate::halfedge::{border_vertices, fans};
use crate::label::{Orientation, Sides};
use crate::polychord::{Polychords, trace};

/// Number of counts of a pattern, see [`Counts`].
pub const COLUMNS: usize = 13;

/// Number of lists of a pattern: the quads at each corner; the valences of the irregular vertices,
/// ascending; the label's word; the signature's word; the lengths of the signature's sides; for
/// every open polychord of the signature the two sides it joins.
pub const LISTS: usize = 6;

/// Descriptions of patterns, one row each.
pub struct Descriptions {
    /// Counts of each pattern, in the order of [`Counts::to_row`].
    pub counts: Vec<[i32; COLUMNS]>,
    /// List k of row i is `lists[ends[LISTS * i + k]..ends[LISTS * i + k + 1]]`.
    pub lists: Vec<u16>,
    /// Where each list ends, after a 0.
    pub ends: Vec<i64>,
    /// Row of the first code that is not the canonical code of a disk; rows from there on are not
    /// described.
    pub bad: Option<usize>,
}

/// What is counted of a pattern.
#[derive(Default)]
struct Counts {
    corners: i32,
    reflex: i32,
    irregular: i32,
    open_chords: i32,
    loops: i32,
    self_crossing: bool,
    rotations: i32,
    chiral: bool,
    perimeter: i32,
    /// The orientation in which the label is the signature.
    signature_rotation: i32,
    signature_reflected: bool,
    signature_symmetries: i32,
    quads: i32,
}

impl Counts {
    /// Return the columns as `patterndb.core.description` numbers them.
    fn to_row(&self) -> [i32; COLUMNS] {
        [
            self.corners,
            self.reflex,
            self.irregular,
            self.open_chords,
            self.loops,
            self.self_crossing.into(),
            self.rotations,
            self.chiral.into(),
            self.perimeter,
            self.signature_rotation,
            self.signature_reflected.into(),
            self.signature_symmetries,
            self.quads,
        ]
    }
}

/// Describe canonical codes: code i is `flat[offsets[i]..offsets[i + 1]]`.
pub fn describe(flat: &[u16], offsets: &[i64]) -> Descriptions {
    let n = offsets.len() - 1;
    let mut rows = Descriptions {
        counts: vec![[0; COLUMNS]; n],
        lists: Vec::with_capacity(2 * flat.len()),
        ends: vec![0; LISTS * n + 1],
        bad: None,
    };
    let codes = offsets
        .windows(2)
        .map(|at| &flat[at[0] as usize..at[1] as usize]);
    for (row, code) in codes.enumerate() {
        let mut lists = Lists {
            flat: &mut rows.lists,
            ends: &mut rows.ends[LISTS * row + 1..][..LISTS],
            written: 0,
        };
        let mut counts = Counts::default();
        let described = describe_one(code, &mut counts, &mut lists);
        rows.counts[row] = counts.to_row();
        if described.is_none() {
            rows.bad = Some(row);
            break;
        }
    }
    rows
}

/// The lists of one row while they are written.
struct Lists<'a> {
    flat: &'a mut Vec<u16>,
    ends: &'a mut [i64],
    written: usize,
}

impl Lists<'_> {
    fn push(&mut self, number: i32) {
        self.flat.push(number as u16);
    }

    /// End the list at hand.
    fn end(&mut self) {
        self.ends[self.written] = self.flat.len() as i64;
        self.written += 1;
    }

    /// Write a whole list.
    fn write(&mut self, numbers: impl IntoIterator<Item = i32>) {
        numbers.into_iter().for_each(|number| self.push(number));
        self.end();
    }
}

/// Describe a code; `None` if it is not the canonical code of a disk.
fn describe_one(code: &[u16], counts: &mut Counts, lists: &mut Lists) -> Option<()> {
    counts.quads = (code.len() / 4) as i32;
    let twin: Vec<i32> = code.iter().map(|&symbol| i32::from(symbol) - 1).collect();
    if !is_disk_code(&twin) {
        return None;
    }
    let border = border_from(&twin, 0);
    counts.perimeter = border.len() as i32;
    // Half-edges that leave corners, and their places on the border.
    let mut starts = Vec::new();
    let mut side_start = Vec::new();
    for (place, &h) in border.iter().enumerate() {
        let quads = border_count(&twin, h);
        if quads != 2 {
            starts.push(h);
            side_start.push(place as i32);
            counts.reflex += i32::from(quads > 2);
            lists.push(quads);
        }
    }
    counts.corners = starts.len() as i32;
    lists.end();

    let irregular = list_irregular(&twin);
    counts.irregular = irregular.len() as i32;
    lists.write(irregular);

    let has_corners = !starts.is_empty();
    count_symmetries(
        code,
        &twin,
        if has_corners { &starts } else { &border },
        counts,
    )?;

    let chords = trace(&twin);
    counts.open_chords = chords.n_open;
    counts.loops = chords.n - chords.n_open;
    counts.self_crossing = chords.has_self_crossing();
    if !has_corners {
        side_start.push(0);
    }
    let chord: Vec<i32> = border.iter().map(|&h| chords.of_edge[h as usize]).collect();
    let sides = Sides {
        chord: &chord,
        start: &side_start,
        has_corners,
    };
    describe_label(&sides, &chords, counts, lists);
    Some(())
}

/// List the numbers of quads of the irregular vertices, ascending.
fn list_irregular(twin: &[i32]) -> Vec<i32> {
    let (vertex, n_vertices) = fans(twin);
    let mut valence = vec![0; n_vertices as usize];
    for &v in &vertex {
        valence[v as usize] += 1;
    }
    let border = border_vertices(twin, &vertex, n_vertices as usize);
    let inner = valence.iter().zip(border).filter(|(_, border)| !border);
    let mut irregular: Vec<i32> = inner.map(|(&n, _)| n).filter(|&n| n != 4).collect();
    irregular.sort_unstable();
    irregular
}

/// Count the rotations that give the same code, and note whether the mirror image does not; `None`
/// if another start gives a smaller code.
fn count_symmetries(code: &[u16], twin: &[i32], starts: &[i32], counts: &mut Counts) -> Option<()> {
    let n = twin.len() / 4;
    let (mut number, mut entry, mut order) = (vec![0; n], vec![0; n], vec![0; n]);
    let mut reading = Reading {
        number: &mut number,
        entry: &mut entry,
        order: &mut order,
    };
    let mut code = code.to_vec();
    counts.chiral = true;
    for &start in starts {
        for sense in [Sense::CounterClockwise, Sense::Clockwise] {
            let h = sense.start(twin, start);
            match rooted_code(twin, n, h, sense, &mut code, &mut reading, true) {
                Ordering::Less => return None,
                Ordering::Equal if sense == Sense::Clockwise => counts.chiral = false,
                Ordering::Equal => counts.rotations += 1,
                Ordering::Greater => {}
            }
        }
    }
    Some(())
}

/// Write label and signature, the lengths of the signature's sides, and the sides that it joins.
fn describe_label(sides: &Sides, chords: &Polychords, counts: &mut Counts, lists: &mut Lists) {
    let mut names = vec![0; chords.n as usize];
    let mut label = Vec::new();
    let as_it_is = Orientation {
        rotation: 0,
        reflected: false,
    };
    sides.write_label(as_it_is, &mut label, &mut names);
    lists.write(label);
    let signature = sides.signature(&mut names);
    counts.signature_rotation = signature.orientation.rotation as i32;
    counts.signature_reflected = signature.orientation.reflected;
    counts.signature_symmetries = signature.symmetries as i32;

    let mut joined = vec![[-1; 2]; chords.n_open as usize];
    let mut lengths = Vec::with_capacity(sides.start.len());
    let mut rest = &signature.word[..];
    while let Some((&length, numbers)) = rest.split_first() {
        let (numbers, after) = numbers.split_at(length as usize);
        for &chord in numbers {
            let [first, last] = &mut joined[chord as usize];
            let end = if *first < 0 { first } else { last };
            *end = lengths.len() as i32;
        }
        lengths.push(length);
        rest = after;
    }
    lists.write(signature.word);
    lists.write(lengths);
    lists.write(joined.into_iter().flatten());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_is_described() {
        let rows = describe(&[0; 4], &[0, 4]);
        assert_eq!(rows.bad, None);
        assert_eq!(rows.counts, [[4, 0, 0, 2, 0, 0, 4, 0, 4, 0, 0, 8, 1]]);
        let list = |k: usize| &rows.lists[rows.ends[k] as usize..rows.ends[k + 1] as usize];
        assert_eq!(list(0), [1, 1, 1, 1]);
        assert!(list(1).is_empty());
        assert_eq!(list(2), [1, 0, 1, 1, 1, 0, 1, 1]);
        assert_eq!(list(4), [1, 1, 1, 1]);
        assert_eq!(list(5), [0, 2, 1, 3]);
    }

    #[test]
    fn the_first_bad_code_is_named() {
        let pair = [0, 5, 0, 0, 2, 0, 0, 0];
        let flat: Vec<u16> = [&[0; 4][..], &pair, &[0, 1, 0, 0]].concat();
        assert_eq!(describe(&flat, &[0, 4, 12, 16]).bad, Some(1));
    }
}
