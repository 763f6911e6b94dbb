//! The sub-cycles that chords can cut out of a cycle: counted and numbered without a search.
//!
//! Every chord on the boundary of a sub-cycle stands for a stretch of the cycle that was cut off,
//! and no two such stretches overlap. Conversely, every set of chords with stretches that do not
//! overlap bounds a sub-cycle that some order of cuts reaches. Take as ends the vertices where
//! chords end, 0 to k - 1 around the cycle, and end 0 once more as end k. Call a chord (i, j), i < j,
//! a wrap if the stretch cut off is the one that contains the arc from end k - 1 to end 0, else a
//! jump. At most one chord of a sub-cycle is its wrap. So a sub-cycle is
//!
//! - a path from 0 to k (no wrap), or from i to j (its wrap is (i, j), which is not the whole path),
//! - whose steps are arcs from an end to the next, and jumps.
//!
//! Paths are counted by a small table. They are numbered, within those of one wrap, in the order in
//! which, at the first step where two differ, the longer jump comes first and the arc last. A number
//! is the sum of its steps' offsets. To cut a sub-cycle replaces a part of the path by a jump: the
//! number becomes smaller, by an amount that follows from the part alone. So the sub-cycles evaluated
//! in the order of their numbers meet their parts evaluated, and the number replaces a hash table.
//!
//! Differs from the paper (Abbasinejad et al. 2013, section 3.2): its hash key, the chords on the
//! boundary, cannot tell the two sides of a chord apart. Here they are the path beyond the jump and
//! the path under the wrap. The number of ends is not limited.

use std::cmp::Reverse;

/// Counts stop here: exact below, "this many or more" at it (MOST_COUNTED in
/// patterndb_sketch.surfacing.chords.subcycles). Twice this is still an i64.
pub const MOST_COUNTED: i64 = 1 << 61;

/// A chord by the ends that it joins.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// The chord's place among the chords.
    pub chord: usize,
    /// Its end that comes first.
    pub first: usize,
    /// Its other end.
    pub last: usize,
}

/// Chords in an order by one of their ends.
#[derive(Clone, Debug)]
pub struct Grouped {
    /// The chords.
    pub spans: Vec<Span>,
    /// Where those of every end begin, and their number.
    pub at: Vec<usize>,
}

impl Grouped {
    /// Group chords that are sorted by an end, of the ends from 0 to `last`.
    fn new(spans: Vec<Span>, last: usize, end: fn(&Span) -> usize) -> Grouped {
        let at = (0..last + 2).map(|v| spans.partition_point(|span| end(span) < v));
        let at = at.collect();
        Grouped { spans, at }
    }

    fn of_end(&self, end: usize) -> &[Span] {
        &self.spans[self.at[end]..self.at[end + 1]]
    }
}

/// The numbering of the sub-cycles of a cycle.
#[derive(Clone, Debug)]
pub struct Subcycles {
    /// The positions in the loop where chords end, ascending.
    pub ends: Vec<usize>,
    /// The chords by the ends that they join.
    pub spans: Vec<Span>,
    /// Where the paths under each wrap begin, and those without one.
    pub base: Vec<i64>,
    /// The number of sub-cycles, the cycle itself among them; at most MOST_COUNTED.
    pub n_all: i64,
    /// The chords by their first end, those of one end the longest first.
    starting: Grouped,
    /// The chords by their last end, those of one end the shortest first.
    ending: Grouped,
    paths: Vec<i64>,
    offsets: Vec<i64>,
}

impl Subcycles {
    /// Number the sub-cycles of a loop of n vertices with chords, positions i < j, no two alike.
    ///
    /// If there are MOST_COUNTED sub-cycles or more, only the count is of use.
    pub fn new(n: usize, chords: &[[i64; 2]]) -> Subcycles {
        let m = chords.len();
        let mut is_end = vec![false; n];
        for &end in chords.as_flattened() {
            is_end[end as usize] = true;
        }
        let ends: Vec<usize> = (0..n).filter(|&v| is_end[v]).collect();
        let k = ends.len();
        let mut end_of = vec![0; n];
        for (i, &v) in ends.iter().enumerate() {
            end_of[v] = i;
        }
        let span = |(chord, ends): (usize, &[i64; 2])| {
            let [first, last] = ends.map(|v| end_of[v as usize]);
            Span { chord, first, last }
        };
        let spans: Vec<Span> = chords.iter().enumerate().map(span).collect();
        let mut starting = spans.clone();
        starting.sort_by_key(|span| (span.first, Reverse(span.last)));
        let mut ending = spans.clone();
        ending.sort_by_key(|span| (span.last, Reverse(span.first)));
        let mut made = Subcycles {
            starting: Grouped::new(starting, k, |span| span.first),
            ending: Grouped::new(ending, k, |span| span.last),
            ends,
            spans,
            base: Vec::with_capacity(m + 1),
            n_all: 0,
            paths: vec![0; (k + 1) * (k + 1)],
            offsets: vec![0; (k + 1) * m],
        };
        made.count_paths();
        made.count_subcycles();
        made
    }

    fn count_paths(&mut self) {
        let (k, m) = (self.ends.len(), self.spans.len());
        for b in 0..=k {
            let paths = &mut self.paths[b * (k + 1)..][..k + 1];
            let offsets = &mut self.offsets[b * m..][..m];
            paths[b] = 1;
            for a in (0..b).rev() {
                let mut found = 0;
                for span in self.starting.of_end(a) {
                    offsets[span.chord] = found;
                    if span.last <= b {
                        found = MOST_COUNTED.min(found + paths[span.last]);
                    }
                }
                paths[a] = MOST_COUNTED.min(found + paths[a + 1]);
            }
        }
    }

    fn count_subcycles(&mut self) {
        let (mut count, mut at) = (0, 0);
        for span in &self.spans {
            self.base.push(at);
            let inside = self.paths_to(span.last)[span.first];
            at = MOST_COUNTED.min(at + inside);
            // The path that is the wrap itself, number 0, does not count.
            count = MOST_COUNTED.min(count + inside - 1);
        }
        self.base.push(at);
        self.n_all = MOST_COUNTED.min(count + self.n_paths());
    }

    /// Return how many paths there are from every end to one.
    #[inline(always)]
    pub fn paths_to(&self, end: usize) -> &[i64] {
        let width = self.ends.len() + 1;
        &self.paths[end * width..][..width]
    }

    /// Return what every chord adds, as a jump, to the number of a path to an end.
    #[inline(always)]
    pub fn offsets_to(&self, end: usize) -> &[i64] {
        let width = self.spans.len();
        &self.offsets[end * width..][..width]
    }

    /// Return how many paths there are without a wrap.
    pub fn n_paths(&self) -> i64 {
        self.paths_to(self.ends.len())[0]
    }

    /// Return how many numbers there are, those of no sub-cycle included.
    pub fn n_numbers(&self) -> i64 {
        self.base[self.spans.len()] + self.n_paths()
    }

    /// Return the chords that can be wraps, those before the ones that their sub-cycles need.
    ///
    /// Wraps are inside others that end later, or that end with them and begin earlier.
    pub fn wraps(&self) -> impl Iterator<Item = Span> {
        self.ending.spans.iter().copied()
    }

    /// Return where paths with a wrap begin and end.
    pub fn range(&self, wrap: Option<usize>) -> (usize, usize) {
        wrap.map_or((0, self.ends.len()), |c| {
            (self.spans[c].first, self.spans[c].last)
        })
    }

    /// Return where the numbers of the paths with a wrap begin.
    pub fn base_of(&self, wrap: Option<usize>) -> i64 {
        self.base[wrap.unwrap_or(self.spans.len())]
    }

    /// Return the chords between the ends of paths with a wrap, without the wrap.
    pub fn inside(&self, wrap: Option<usize>) -> Inside {
        let (start, stop) = self.range(wrap);
        let pick = |grouped: &Grouped, end: fn(&Span) -> usize| {
            let spans = &grouped.spans[grouped.at[start]..grouped.at[stop + 1]];
            let between = spans.iter().filter(|span| {
                span.first >= start && span.last <= stop && Some(span.chord) != wrap
            });
            Grouped::new(between.copied().collect(), stop, end)
        };
        Inside {
            by_first: pick(&self.starting, |span| span.first),
            by_last: pick(&self.ending, |span| span.last),
        }
    }

    /// Return the path of a number, among those with a wrap.
    pub fn path_of(&self, wrap: Option<usize>, mut number: i64) -> Path {
        let (start, stop) = self.range(wrap);
        let paths = self.paths_to(stop);
        let (mut ends, mut jumps) = (vec![start], Vec::new());
        let mut at = start;
        while at < stop {
            let mut step = (None, at + 1);
            for span in self.starting.of_end(at) {
                if span.last <= stop {
                    let inside = paths[span.last];
                    if number < inside {
                        step = (Some(span.chord), span.last);
                        break;
                    }
                    number -= inside;
                }
            }
            at = step.1;
            ends.push(at);
            jumps.push(step.0);
        }
        Path { ends, jumps }
    }

    /// Return the number of a part of a path, from its end `from` to its end `to`, among the paths
    /// that go on to an end.
    pub fn sum_offsets(&self, path: &Path, from: usize, to: usize, end: usize) -> i64 {
        let (paths, offsets) = (self.paths_to(end), self.offsets_to(end));
        let steps = path.ends[from..to].iter().zip(&path.jumps[from..to]);
        let added = steps.map(|(&at, jump)| match *jump {
            Some(chord) => offsets[chord],
            None => paths[at] - paths[at + 1],
        });
        added.sum()
    }
}

/// The chords between two ends.
#[derive(Clone, Debug)]
pub struct Inside {
    /// The chords by their first end, those of one end the longest first.
    pub by_first: Grouped,
    /// The chords by their last end, those of one end the shortest first.
    pub by_last: Grouped,
}

/// The boundary of a sub-cycle, without its wrap.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// The ends that it passes.
    pub ends: Vec<usize>,
    /// The chord of each step, None for an arc.
    pub jumps: Vec<Option<usize>>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chord_makes_two_subcycles_more() {
        assert_eq!(Subcycles::new(6, &[]).n_all, 1);
        assert_eq!(Subcycles::new(6, &[[0, 3]]).n_all, 3);
        // Crossing, they cannot be on one boundary.
        assert_eq!(Subcycles::new(6, &[[0, 3], [1, 4]]).n_all, 5);
        // The piece between both is one more.
        assert_eq!(Subcycles::new(6, &[[0, 2], [3, 5]]).n_all, 6);
    }

    #[test]
    fn many_chords_are_counted_to_the_limit() {
        let chords: Vec<[i64; 2]> = (0..200).map(|i| [3 * i, 3 * i + 2]).collect();
        assert_eq!(Subcycles::new(600, &chords).n_all, MOST_COUNTED);
    }

    #[test]
    fn numbers_and_paths_are_each_other() {
        let chords = [[0, 4], [2, 5], [1, 3], [0, 6], [3, 6], [4, 7]];
        let numbering = Subcycles::new(8, &chords);
        for wrap in (0..6).map(Some).chain([None]) {
            let (start, stop) = numbering.range(wrap);
            let n = numbering.paths_to(stop)[start];
            for number in 0..n {
                let path = numbering.path_of(wrap, number);
                let steps = path.jumps.len();
                assert_eq!(numbering.sum_offsets(&path, 0, steps, stop), number);
                assert_eq!(path.ends[steps], stop);
            }
        }
    }
}
