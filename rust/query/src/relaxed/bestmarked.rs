//! The marked pattern that fills a boundary with the fewest irregular vertices.
//!
//! A look-up over a whole table, fast enough to be called for every part of a construction; the pattern
//! is not expanded.

use crate::solving::balance::Class;
use crate::solving::branch_and_bound::find_first_solution;
use crate::solving::fractional_matching::{Scratch, Square, Start, doubled, find_flow};
use crate::solving::systems::{OwnGraph, is_balanced, two_colour};

/// The classes of strands of the signatures of a table.
#[derive(Clone, Copy, Debug)]
pub struct ClassTable<'a> {
    /// Where the classes of each signature begin, and where those of the last end.
    pub start: &'a [i64],
    /// One side that each class joins.
    pub i: &'a [i32],
    /// The other side.
    pub j: &'a [i32],
}

impl<'a> ClassTable<'a> {
    /// Return the sides that each class of a signature joins.
    fn pairs(&self, signature: usize) -> impl Iterator<Item = (usize, usize)> + 'a {
        let range = self.start[signature] as usize..self.start[signature + 1] as usize;
        let pairs = self.i[range.clone()].iter().zip(&self.j[range]);
        pairs.map(|(&i, &j)| (i as usize, j as usize))
    }
}

/// Return the component and the colour of each side, see [`two_colour`], for every signature a row.
pub fn colours(classes: &ClassTable, n_sides: usize) -> [Vec<i16>; 2] {
    let n = classes.start.len() - 1;
    let mut component = vec![0; n * n_sides];
    let mut colour = vec![0; n * n_sides];
    for s in 0..n {
        let row = s * n_sides..(s + 1) * n_sides;
        let pairs: Vec<_> = classes.pairs(s).collect();
        two_colour(&pairs, &mut component[row.clone()], &mut colour[row]);
    }
    [component, colour]
}

/// The rows of a table that can come first, one of each kind.
#[derive(Clone, Copy, Debug)]
pub struct MarkedIndex<'a> {
    /// For each signature a row: the least length of every side.
    pub base: &'a [i32],
    /// Where the rows with 0, 1, ... interior irregular vertices begin, and where the last end.
    pub start: &'a [i64],
    /// Corners of each row without a mark.
    pub unmarked: &'a [i32],
    /// Signature of each row.
    pub signature: &'a [i32],
    /// For each row the quads at its marks, in the order of its signature.
    pub counts: &'a [u8],
    /// How many of these are 1.
    pub convex: &'a [i32],
    /// How many of these are 3.
    pub reflex: &'a [i32],
    /// Classes of every signature.
    pub classes: ClassTable<'a>,
    /// For each signature a row of [`colours`].
    pub component: &'a [i16],
    /// For each signature a row of [`colours`].
    pub colour: &'a [i16],
}

/// A boundary to be filled.
#[derive(Clone, Copy, Debug)]
pub struct Outline<'a> {
    /// Edges of each side.
    pub lengths: &'a [i32],
    /// Quads at each corner.
    pub asked: &'a [i32],
    /// Irregular vertices on the boundary at most.
    pub cap: i32,
    /// Irregular vertices in all at most; None for any number.
    pub most: Option<i32>,
}

/// The first row of an index that fits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BestRow {
    /// Row of the index.
    pub row: usize,
    /// Orientation of its signature; those from the number of sides on are mirrored.
    pub orientation: usize,
    /// Irregular vertices.
    pub n_irregular: i32,
    /// Those on the boundary.
    pub n_on_boundary: i32,
    /// Slack of every class of the signature.
    pub slack: Vec<i32>,
}

/// Return the row that fills an outline with the fewest irregular vertices, and among equals with the
/// fewest on the boundary.
pub fn find_best_row(outline: &Outline, index: &MarkedIndex) -> Option<BestRow> {
    let n = outline.lengths.len() as i32;
    let count = |kind: i32| outline.asked.iter().filter(|&&quads| quads == kind).count() as i32;
    let (n_convex, n_reflex) = (count(1), count(3));
    let mut fitting = Fitting::new(outline, index);
    let most_inside = index.start.len() as i32 - 2;
    let highest = (most_inside + outline.cap).min(outline.most.unwrap_or(i32::MAX));
    for n_irregular in 0..=highest {
        for n_on_boundary in 0..=outline.cap.min(n_irregular) {
            let inside = n_irregular - n_on_boundary;
            if inside > most_inside {
                continue;
            }
            let rows =
                index.start[inside as usize] as usize..index.start[inside as usize + 1] as usize;
            for row in rows {
                // So many marks must fall where another count is asked for.
                let off = n_on_boundary - index.unmarked[row];
                let alike = index.convex[row].min(n_convex) + index.reflex[row].min(n_reflex);
                if off < 0 || n - alike > off + (n - n_convex - n_reflex) {
                    continue;
                }
                if let Some((orientation, slack)) = fitting.fit(row, off as usize) {
                    return Some(BestRow {
                        row,
                        orientation,
                        n_irregular,
                        n_on_boundary,
                        slack,
                    });
                }
            }
        }
    }
    None
}

/// An outline in all orientations, and what is known of the signatures of an index.
struct Fitting<'a> {
    index: &'a MarkedIndex<'a>,
    n: usize,
    perimeter: i32,
    /// For each orientation the lengths of the sides.
    seen: Vec<i32>,
    /// For each orientation the quads at the corners.
    wanted: Vec<i32>,
    /// For each signature, bit o is set where it has been found not to fit in orientation o.
    failed: Vec<u64>,
    slack: Vec<i32>,
    sums: Vec<i32>,
    flow: Square,
    scratch: Scratch,
}

/// Return items of sides in all orientations, row by row: item s - r, then, mirrored, r + `shift` - s.
fn orient(items: &[i32], shift: usize) -> Vec<i32> {
    let n = items.len();
    let places = || (0..n).flat_map(|r| (0..n).map(move |s| (r, s)));
    let turned = places().map(|(r, s)| items[(n + s - r) % n]);
    let mirrored = places().map(|(r, s)| items[(n + r + shift - s) % n]);
    turned.chain(mirrored).collect()
}

impl<'a> Fitting<'a> {
    fn new(outline: &Outline, index: &'a MarkedIndex<'a>) -> Fitting<'a> {
        let n = outline.lengths.len();
        Fitting {
            index,
            n,
            perimeter: outline.lengths.iter().sum(),
            seen: orient(outline.lengths, 0),
            wanted: orient(outline.asked, 1),
            failed: vec![0; index.base.len() / n],
            slack: vec![0; n],
            sums: vec![0; n],
            flow: Square::new(n),
            scratch: Scratch::new(n),
        }
    }

    /// Return the first orientation in which a row fits, with `off` marks where another count is asked
    /// for, and the slack of its classes.
    fn fit(&mut self, row: usize, off: usize) -> Option<(usize, Vec<i32>)> {
        let n = self.n;
        let signature = self.index.signature[row] as usize;
        let base = &self.index.base[signature * n..][..n];
        if base.iter().sum::<i32>() > self.perimeter {
            return None;
        }
        let counts = &self.index.counts[row * n..][..n];
        for orientation in 0..2 * n {
            if self.failed[signature] >> orientation & 1 == 1 {
                continue;
            }
            let wanted = &self.wanted[orientation * n..][..n];
            let pairs = counts.iter().zip(wanted);
            if pairs
                .filter(|(count, wanted)| i32::from(**count) != **wanted)
                .count()
                != off
            {
                continue;
            }
            if let Some(slack) = self.meet(signature, base, orientation) {
                return Some((orientation, slack));
            }
            self.failed[signature] |= 1 << orientation;
        }
        None
    }

    /// Return the slack of the classes of a signature, if they can meet the lengths.
    fn meet(&mut self, signature: usize, base: &[i32], orientation: usize) -> Option<Vec<i32>> {
        let n = self.n;
        let lengths = &self.seen[orientation * n..][..n];
        for ((slack, length), base) in self.slack.iter_mut().zip(lengths).zip(base) {
            *slack = length - base;
            if *slack < 0 {
                return None;
            }
        }
        let component = &self.index.component[signature * n..][..n];
        let colour = &self.index.colour[signature * n..][..n];
        if !is_balanced(&self.slack, component, colour, &mut self.sums) {
            return None;
        }
        let pairs: Vec<_> = self.index.classes.pairs(signature).collect();
        // Most calls end here: a side asks for more than all its neighbours can give.
        self.sums.fill(0);
        for &(i, j) in &pairs {
            self.sums[i] += self.slack[j];
            self.sums[j] += self.slack[i];
        }
        if self
            .slack
            .iter()
            .zip(&self.sums)
            .any(|(slack, reach)| slack > reach)
        {
            return None;
        }
        let own = OwnGraph::new(n, pairs.iter().copied());
        let Fitting { flow, scratch, .. } = self;
        if !find_flow(&self.slack, &own.graph(), Start::Greedy, flow, scratch) {
            return None;
        }
        let twice: Vec<i32> = pairs.iter().map(|&(i, j)| doubled(flow, i, j)).collect();
        if twice.iter().all(|twice| twice % 2 == 0) {
            return Some(twice.into_iter().map(|twice| twice / 2).collect());
        }
        let class = |(i, j)| Class {
            i,
            j,
            n: 1,
            weight: 1,
        };
        let classes: Vec<Class> = pairs.into_iter().map(class).collect();
        find_first_solution(&self.slack, &classes)
    }
}

/// A row of a table of marked patterns, in its signature.
#[derive(Clone, Copy, Debug)]
pub struct MarkedRow<'a> {
    /// For every side its number of strands, then these.
    pub label: &'a [i16],
    /// The side that is the signature's first.
    pub rotation: usize,
    /// Whether the signature runs the other way round.
    pub reflected: bool,
    /// Number of sides.
    pub n_sides: usize,
}

/// Return the width of every strand of a row, the slack of each class spread evenly.
///
/// `classes` are those of the row's signature.
pub fn spread_strand_widths(row: &MarkedRow, classes: &[Class], slack: &[i32]) -> Vec<i32> {
    let n = row.n_sides;
    let mut ends: Vec<Vec<usize>> = vec![Vec::with_capacity(2); (row.label.len() - n) / 2];
    let mut rest = row.label;
    let mut side = 0;
    while let [size, others @ ..] = rest {
        let (strands, others) = others.split_at(*size as usize);
        let turned = if row.reflected {
            row.rotation + n - side
        } else {
            side + n - row.rotation
        };
        for &strand in strands {
            ends[strand as usize].push(turned % n);
        }
        rest = others;
        side += 1;
    }
    let mut left = slack.to_vec();
    let mut open: Vec<i32> = classes.iter().map(|class| class.n).collect();
    let width = |ends: Vec<usize>| {
        let (i, j) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let k = classes
            .iter()
            .position(|class| (class.i, class.j) == (i, j));
        let k = k.expect("the signature has a class for every strand");
        let share = (left[k] + open[k] - 1) / open[k];
        left[k] -= share;
        open[k] -= 1;
        1 + share
    };
    ends.into_iter().map(width).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quad: its sides are joined across.
    const CLASSES: ClassTable = ClassTable {
        start: &[0, 2],
        i: &[0, 1],
        j: &[2, 3],
    };

    fn find(lengths: [i32; 4], asked: [i32; 4]) -> Option<BestRow> {
        let [component, colour] = colours(&CLASSES, 4);
        assert_eq!(component, [0, 1, 0, 1]);
        assert_eq!(colour, [1, 1, -1, -1]);
        let index = MarkedIndex {
            base: &[1; 4],
            start: &[0, 1],
            unmarked: &[0],
            signature: &[0],
            counts: &[1; 4],
            convex: &[4],
            reflex: &[0],
            classes: CLASSES,
            component: &component,
            colour: &colour,
        };
        let outline = Outline {
            lengths: &lengths,
            asked: &asked,
            cap: 1,
            most: None,
        };
        find_best_row(&outline, &index)
    }

    #[test]
    fn a_quad_fills_a_rectangle() {
        let found = find([3, 2, 3, 2], [1; 4]).expect("it fits");
        assert_eq!((found.row, found.orientation, found.n_irregular), (0, 0, 0));
        assert_eq!(found.slack, [2, 1]);
        assert_eq!(find([3, 2, 3, 3], [1; 4]), None);
        let found = find([3, 2, 3, 2], [1, 3, 1, 1]).expect("a corner may be irregular");
        assert_eq!((found.n_irregular, found.n_on_boundary), (1, 1));
        assert_eq!(find([3, 2, 3, 2], [1, 3, 1, 3]), None);
    }

    #[test]
    fn slack_is_spread_among_the_strands_of_a_class() {
        let row = MarkedRow {
            label: &[2, 0, 1, 2, 1, 0],
            rotation: 1,
            reflected: false,
            n_sides: 2,
        };
        let classes = [Class {
            i: 0,
            j: 1,
            n: 2,
            weight: 1,
        }];
        assert_eq!(spread_strand_widths(&row, &classes, &[3]), [3, 2]);
    }
}
