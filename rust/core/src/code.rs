//! Canonical codes: one list of symbols for each pattern, wherever the reading starts.
//!
//! Quads are numbered breadth-first from a starting corner; the code lists each quad's neighbours
//! counter-clockwise from the edge by which the quad was reached. Symbol 0 is a border edge; symbol
//! `1 + 4 * j + e` is quad j, entered by its edge e, counted from the edge by which j itself was
//! reached. Among all starting corners (all border vertices where there is no corner) the
//! lexicographically smallest code wins; a mirror image is coded clockwise.
//!
//! Source: Marcias et al. 2015, section 3.3. Differs from the paper: the paper visits vertices and
//! names only the neighbouring face, which two faces sharing two edges make ambiguous; here the
//! visit is over quads and the symbol names the edge too.

use std::cmp::Ordering;

use crate::halfedge::{fans, next_border_edge, prev_edge};

/// Quads that a 16-bit symbol can name: 1 + 4 * j + 3 <= 65535.
pub const MAX_QUADS: usize = 16383;

/// The integer type of a code's symbols: `u16` for patterns, `i32` for larger disks.
pub trait Symbol: Copy {
    /// Return the symbol of a number, cut to the type's bits.
    fn from_number(number: i32) -> Self;
    /// Return the symbol's number.
    fn number(self) -> i32;
}

impl Symbol for u16 {
    fn from_number(number: i32) -> Self {
        number as u16
    }
    fn number(self) -> i32 {
        i32::from(self)
    }
}

impl Symbol for i32 {
    fn from_number(number: i32) -> Self {
        number
    }
    fn number(self) -> i32 {
        self
    }
}

/// The sense in which a disk is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sense {
    /// The sense of the half-edges.
    CounterClockwise,
    /// The sense of the half-edges of the mirror image.
    Clockwise,
}

impl Sense {
    /// Return the border half-edge where a reading in this sense starts, to start at the tail of
    /// border half-edge `h`.
    pub fn start(self, twin: &[i32], h: i32) -> i32 {
        match self {
            Self::CounterClockwise => h,
            Self::Clockwise => clockwise_start(twin, h),
        }
    }
}

/// Scratch of [`rooted_code`], each slice with at least as many places as the disk has quads.
///
/// After a reading `number` holds each quad's number, `order` the quad of each number, and `entry`
/// the edge by which that quad was reached.
pub struct Reading<'a> {
    /// Number of each quad, -1 before it is reached.
    pub number: &'a mut [i32],
    /// Edge by which each quad was reached, in the order of their numbers.
    pub entry: &'a mut [i32],
    /// Quads in the order of their numbers.
    pub order: &'a mut [i32],
}

/// Write the code of the first `n_quads` quads, read from half-edge `start`, into `code`.
///
/// With `best`, `code` holds a code already and only a smaller one replaces it. Returns `Less` where
/// the code was written, `Equal` where it equals what was there, `Greater` where it is larger
/// (nothing was written then).
pub fn rooted_code<S: Symbol>(
    twin: &[i32],
    n_quads: usize,
    start: i32,
    sense: Sense,
    code: &mut [S],
    reading: &mut Reading,
    best: bool,
) -> Ordering {
    let number = &mut reading.number[..n_quads];
    let entry = &mut reading.entry[..n_quads];
    let order = &mut reading.order[..n_quads];
    let code = &mut code[..4 * n_quads];
    number.fill(-1);
    let step = match sense {
        Sense::CounterClockwise => 1,
        Sense::Clockwise => 3,
    };
    number[(start >> 2) as usize] = 0;
    entry[0] = start & 3;
    order[0] = start >> 2;
    let mut count = 1;
    let mut state = if best {
        Ordering::Equal
    } else {
        Ordering::Less
    };
    for i in 0..n_quads {
        let base = 4 * order[i];
        let enter = entry[i];
        for (r, place) in code[4 * i..4 * i + 4].iter_mut().enumerate() {
            let t = twin[(base + ((enter + r as i32 * step) & 3)) as usize];
            let symbol = if t < 0 {
                0
            } else {
                let (quad, edge) = ((t >> 2) as usize, t & 3);
                let mut j = number[quad];
                if j < 0 {
                    j = count as i32;
                    number[quad] = j;
                    order[count] = t >> 2;
                    entry[count] = edge;
                    count += 1;
                }
                1 + 4 * j + (((edge - entry[j as usize]) * step) & 3)
            };
            if state == Ordering::Equal {
                state = symbol.cmp(&place.number());
                if state == Ordering::Greater {
                    return state;
                }
            }
            if state == Ordering::Less {
                *place = S::from_number(symbol);
            }
        }
    }
    state
}

/// Return the border half-edge that ends at the tail of border half-edge `h`.
///
/// Seen in a mirror, it is the one that starts there.
pub fn clockwise_start(twin: &[i32], h: i32) -> i32 {
    let mut h = prev_edge(h);
    while twin[h as usize] >= 0 {
        h = prev_edge(twin[h as usize]);
    }
    h
}

/// Write the smallest code over all starts into `code`; return the place of its first start and the
/// number of starts that reach it, which is the number of rotations that map the pattern onto
/// itself.
///
/// `starts` are border half-edges. Without any, nothing is written and the place is `None`.
pub fn smallest_code<S: Symbol>(
    twin: &[i32],
    n_quads: usize,
    starts: &[i32],
    sense: Sense,
    code: &mut [S],
    reading: &mut Reading,
) -> (Option<usize>, usize) {
    let mut winner = None;
    let mut ties = 0;
    for (place, &start) in starts.iter().enumerate() {
        let h = sense.start(twin, start);
        match rooted_code(twin, n_quads, h, sense, code, reading, place > 0) {
            Ordering::Less => (winner, ties) = (Some(place), 1),
            Ordering::Equal => ties += 1,
            Ordering::Greater => {}
        }
    }
    (winner, ties)
}

/// Return the half-edges that a code may start from, in border order.
///
/// They leave the corners (border vertices whose number of quads is not 2), or every border vertex
/// where there is no corner. A closed surface has none.
pub fn code_starts(twin: &[i32]) -> Vec<i32> {
    let Some(first) = twin.iter().position(|&t| t < 0) else {
        return Vec::new();
    };
    let border = border_from(twin, first as i32);
    let corners: Vec<i32> = border
        .iter()
        .copied()
        .filter(|&h| border_count(twin, h) != 2)
        .collect();
    if corners.is_empty() { border } else { corners }
}

/// Return the half-edges of the border from border half-edge `first` on, once round.
pub fn border_from(twin: &[i32], first: i32) -> Vec<i32> {
    let mut border = vec![first];
    let mut h = next_border_edge(twin, first);
    while h != first {
        border.push(h);
        h = next_border_edge(twin, h);
    }
    border
}

/// Return the number of quads at the tail of border half-edge `h`.
pub fn border_count(twin: &[i32], h: i32) -> i32 {
    let mut count = 1;
    let mut h = prev_edge(h);
    while twin[h as usize] >= 0 {
        count += 1;
        h = prev_edge(twin[h as usize]);
    }
    count
}

/// Return whether these are the half-edges that a code of a disk describes.
///
/// `twin` holds a code's symbols less one, from any source. They must pair up, number their quads
/// breadth-first from half-edge 0, which is on the border, and form a disk with one simple border.
pub fn is_disk_code(twin: &[i32]) -> bool {
    if !is_breadth_first(twin) {
        return false;
    }
    let n_border = twin.iter().filter(|&&t| t < 0).count();
    let (vertex, n_vertices) = fans(twin);
    let n_edges = (twin.len() + n_border) / 2;
    if n_vertices as usize + twin.len() / 4 != n_edges + 1 {
        return false;
    }
    // A border of several loops, or one that meets itself, has fewer steps from edge 0.
    let mut seen = vec![false; n_vertices as usize];
    let mut h = 0;
    let mut steps = 0;
    loop {
        let place = &mut seen[vertex[h as usize] as usize];
        if std::mem::replace(place, true) {
            return false;
        }
        steps += 1;
        h = next_border_edge(twin, h);
        if h == 0 {
            return steps == n_border;
        }
    }
}

/// Return whether half-edges pair up and number quads breadth-first from border half-edge 0.
fn is_breadth_first(twin: &[i32]) -> bool {
    let n = twin.len();
    if n == 0 || !n.is_multiple_of(4) || twin[0] != -1 {
        return false;
    }
    let mut reached = 1;
    for (h, &t) in twin.iter().enumerate() {
        if h == 4 * reached {
            return false;
        }
        if t == -1 {
            continue;
        }
        // A number below -1 becomes too large an index.
        let across = t as usize;
        if across >= n || across == h || twin[across] != h as i32 {
            return false;
        }
        if across >= 4 * reached {
            if across != 4 * reached {
                return false;
            }
            reached += 1;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two quads with one common edge: the second edge of the first, the fourth of the other.
    const PAIR: [i32; 8] = [-1, 7, -1, -1, -1, -1, -1, 1];

    fn read(twin: &[i32], start: i32, sense: Sense) -> Vec<u16> {
        let n = twin.len() / 4;
        let (mut number, mut entry, mut order) = (vec![0; n], vec![0; n], vec![0; n]);
        let mut reading = Reading {
            number: &mut number,
            entry: &mut entry,
            order: &mut order,
        };
        let mut code = vec![0; twin.len()];
        let state = rooted_code(twin, n, start, sense, &mut code, &mut reading, false);
        assert_eq!(state, Ordering::Less);
        let again = rooted_code(twin, n, start, sense, &mut code, &mut reading, true);
        assert_eq!(again, Ordering::Equal);
        code
    }

    #[test]
    fn a_code_describes_the_disk_from_its_start() {
        let code = read(&PAIR, 0, Sense::CounterClockwise);
        assert_eq!(code, [0, 5, 0, 0, 2, 0, 0, 0]);
        let twin: Vec<i32> = code.iter().map(|&s| i32::from(s) - 1).collect();
        assert!(is_disk_code(&twin));
    }

    #[test]
    fn a_pair_is_its_own_mirror_image() {
        let start = Sense::Clockwise.start(&PAIR, 0);
        assert_eq!(start, 3);
        let codes: Vec<_> = (0..8)
            .filter(|&h| PAIR[h as usize] < 0)
            .map(|h| read(&PAIR, h, Sense::CounterClockwise))
            .collect();
        assert!(codes.contains(&read(&PAIR, start, Sense::Clockwise)));
    }

    #[test]
    fn codes_start_at_the_four_corners() {
        assert_eq!(code_starts(&PAIR), [0, 5, 6, 3]);
        assert!([0, 5, 6, 3].iter().all(|&h| border_count(&PAIR, h) == 1));
        assert!(code_starts(&[1, 0, 3, 2]).is_empty());
    }

    #[test]
    fn half_edges_that_do_not_pair_up_are_refused() {
        for twin in [
            &[-1, 4, -1, -1][..],
            &[-1, 1, -1, -1],
            &[-1, -5, -1, -1],
            &[-1; 8],
            &[-1; 3],
            &[],
        ] {
            assert!(!is_disk_code(twin));
        }
        assert!(is_disk_code(&[-1; 4]));
    }
}
