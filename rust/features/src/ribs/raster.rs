//! The picture of a slice, one bit to the pixel: dilation, erosion that keeps its topology, and the
//! outer contours, of which one passes the backbone.

use super::{Place, edge, length, vector};

/// A pixel: column and row, from the lower left one.
pub type Pixel = [i32; 2];

/// Bits of the first column of a cell, and of the last.
const FIRST: u64 = 0x0101_0101_0101_0101;
const LAST: u64 = FIRST << 7;

/// Bits from one row of a cell to the next, and from its first to its last.
const ROW: u32 = 8;
const ROWS: u32 = 56;

/// Steps to the eight neighbours, counter-clockwise from the right.
const STEPS: [Pixel; 8] = [
    [1, 0],
    [1, 1],
    [0, 1],
    [-1, 1],
    [-1, 0],
    [-1, -1],
    [0, -1],
    [1, -1],
];

/// Pixels to either side over which a contour's direction is measured.
const SPAN: usize = 4;

/// Cosine between a contour's outward direction and the wanted one from which they agree.
const AGREE: f64 = 0.2;

/// Pixels that a place on the wrong side counts as being farther off: more than any picture has.
const WRONG_SIDE: f64 = 1e4;

/// Whether a pixel may go whose neighbours, counter-clockwise from the right, are these bits: if the
/// ring switches once each way, and one of the four that share a side is background.
///
/// Differs from the paper: it has "at most one switch" alone, which lets interior pixels go (no
/// switch at all); and a pixel whose one background neighbour is across a corner would become a
/// hole. Sides, not corners, join background; corners join foreground. `MAY_GO` in
/// `patterndb_sketch.features.ribs.raster` is the same table.
const MAY_GO: [bool; 256] = {
    let mut rules = [false; 256];
    let mut ring = 0;
    while ring < 256 {
        let bits = ring as u8;
        let switches = (bits ^ bits.rotate_right(1)).count_ones();
        rules[ring] = switches == 2 && bits & 0b0101_0101 != 0b0101_0101;
        ring += 1;
    }
    rules
};

/// A picture, in cells of 8 x 8 pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Rows of cells.
    pub n_rows: usize,
    /// Cells in a row.
    pub n_columns: usize,
    /// The cells, row by row: bit 8 y + x of one is the pixel at x, y in it.
    pub cells: Vec<u64>,
}

/// Return the bit of a pixel in its cell.
#[inline(always)]
fn bit_of([x, y]: Pixel) -> u32 {
    (8 * (y & 7) + (x & 7)) as u32
}

impl Picture {
    /// Return a picture without any pixel set.
    pub fn new(n_rows: usize, n_columns: usize) -> Self {
        Self {
            n_rows,
            n_columns,
            cells: vec![0; n_rows * n_columns],
        }
    }

    /// Return the number of a pixel's cell.
    #[inline(always)]
    pub(super) fn cell(&self, [x, y]: Pixel) -> usize {
        (y >> 3) as usize * self.n_columns + (x >> 3) as usize
    }

    /// Return whether a pixel is set. Those outside the picture are not.
    #[inline(always)]
    pub(super) fn is_set(&self, [x, y]: Pixel) -> bool {
        if x < 0 || y < 0 || (x >> 3) as usize >= self.n_columns || (y >> 3) as usize >= self.n_rows
        {
            return false;
        }
        self.cells[self.cell([x, y])] >> bit_of([x, y]) & 1 != 0
    }

    /// Set a pixel of the picture.
    #[inline(always)]
    fn set(&mut self, pixel: Pixel) {
        let cell = self.cell(pixel);
        self.cells[cell] |= 1 << bit_of(pixel);
    }

    /// Return the eight neighbours of a pixel as bits, counter-clockwise from the right (y up).
    #[inline(always)]
    pub fn read_ring(&self, [x, y]: Pixel) -> u8 {
        if (1..7).contains(&(x & 7)) && (1..7).contains(&(y & 7)) {
            // All within one cell: the rows below, of the pixel, and above.
            let word = self.cells[self.cell([x, y])];
            let at = bit_of([x, y]);
            let [low, middle, high] = [at - 9, at - 1, at + 7].map(|k| (word >> k & 7) as u8);
            return middle >> 2
                | (high & 4) >> 1
                | (high & 2) << 1
                | (high & 1) << 3
                | (middle & 1) << 4
                | (low & 1) << 5
                | (low & 2) << 5
                | (low & 4) << 5;
        }
        let ring = STEPS.iter().enumerate();
        ring.fold(0, |bits, (k, [dx, dy])| {
            bits | u8::from(self.is_set([x + dx, y + dy])) << k
        })
    }

    /// Return a picture of which every cell is made of one here, and of the cells to its left and
    /// right, 0 outside.
    fn combine_columns(&self, combine: impl Fn(u64, u64, u64) -> u64) -> Picture {
        let mut cells = Vec::with_capacity(self.cells.len());
        for row in self.cells.chunks_exact(self.n_columns.max(1)) {
            for (c, &word) in row.iter().enumerate() {
                let left = if c > 0 { row[c - 1] } else { 0 };
                let right = row.get(c + 1).copied().unwrap_or(0);
                cells.push(combine(left, word, right));
            }
        }
        Picture { cells, ..*self }
    }

    /// Return a picture of which every cell is made of one here, and of the cells below and above,
    /// 0 outside.
    fn combine_rows(&self, combine: impl Fn(u64, u64, u64) -> u64) -> Picture {
        let n = self.n_columns;
        let made = self.cells.iter().enumerate().map(|(k, &word)| {
            let below = if k >= n { self.cells[k - n] } else { 0 };
            combine(below, word, self.cells.get(k + n).copied().unwrap_or(0))
        });
        Picture {
            cells: made.collect(),
            ..*self
        }
    }

    /// Return every pixel that is set, or touches one that is, by a side or a corner.
    pub fn dilate(&self) -> Picture {
        self.combine_columns(|left, word, right| {
            word | shift_right(left, word) | shift_left(word, right)
        })
        .combine_rows(|below, word, above| word | shift_up(below, word) | shift_down(word, above))
    }

    /// Return every pixel that is set as are all its neighbours, by sides and corners.
    fn inner(&self) -> Picture {
        self.combine_columns(|left, word, right| {
            word & shift_right(left, word) & shift_left(word, right)
        })
        .combine_rows(|below, word, above| word & shift_up(below, word) & shift_down(word, above))
    }

    /// Take one layer off the picture, but no pixel of `first`, and no part or hole comes, goes or
    /// changes.
    ///
    /// The layer is what touches background at the beginning, by a side or a corner, just as
    /// dilation adds it. Pixels are looked at one by one, since two of a bridge may not go at once,
    /// and twice, since those at corners can go only after those at sides.
    pub fn erode(&mut self, first: &Picture) {
        let mut layer = self.inner();
        let both = self.cells.iter().zip(&first.cells);
        for (cell, (word, kept)) in layer.cells.iter_mut().zip(both) {
            *cell = word & !kept & !*cell;
        }
        for _ in 0..2 {
            for k in 0..layer.cells.len() {
                let (row, column) = (k / self.n_columns, k % self.n_columns);
                let mut rest = layer.cells[k];
                while rest != 0 {
                    let b = rest.trailing_zeros() as i32;
                    rest &= rest - 1;
                    let pixel = [8 * column as i32 + (b & 7), 8 * row as i32 + (b >> 3)];
                    if MAY_GO[self.read_ring(pixel) as usize] {
                        self.cells[k] &= !(1 << b);
                        layer.cells[k] &= !(1 << b);
                    }
                }
            }
        }
    }

    /// Return the picture after some dilations, then as many erosions.
    pub fn close_gaps(&self, rounds: usize) -> Picture {
        let mut result = self.clone();
        for _ in 0..rounds {
            result = result.dilate();
        }
        for _ in 0..rounds {
            result.erode(self);
        }
        result
    }

    /// Return the pixels of the outer contour nearest to a place, counter-clockwise.
    ///
    /// Source: feature curve recovery paper, section 4.3.2. Differs from the paper: it steps from
    /// cell to cell, to the next pixel that is set on the cell's border. That takes two parts in
    /// one cell for one, so the contour is followed through the cells, and cells only speed it up.
    pub fn find_outer_contour(&self, place: Place) -> Vec<Pixel> {
        let mut seen = Picture::new(self.n_rows, self.n_columns);
        let mut best = Vec::new();
        let mut least = f64::INFINITY;
        for y in 0..8 * self.n_rows as i32 {
            for column in 0..self.n_columns as i32 {
                let word = self.cells[self.cell([8 * column, y])];
                let mut bits = word >> (ROW * (y & 7) as u32) & 0xff;
                while bits != 0 {
                    let x = 8 * column + bits.trailing_zeros() as i32;
                    bits &= bits - 1;
                    let before = [[x - 1, y], [x - 1, y - 1], [x, y - 1], [x + 1, y - 1]];
                    if seen.is_set([x, y]) || before.into_iter().any(|p| self.is_set(p)) {
                        continue;
                    }
                    let border = self.trace_border([x, y], &mut seen);
                    if double_area(&border) < 0 {
                        continue;
                    }
                    let away = measure_to_border(&border, place);
                    if away < least {
                        least = away;
                        best = border;
                    }
                }
            }
        }
        best
    }

    /// Return the pixels of the border that begins at one whose left neighbour and lower three are
    /// background; each a step from the one before, background on the right. Set them in `seen`.
    ///
    /// Ends where the first step would be made again; a pixel may come more than once.
    fn trace_border(&self, begin: Pixel, seen: &mut Picture) -> Vec<Pixel> {
        let mut border = vec![begin];
        seen.set(begin);
        let mut at = begin;
        let mut way = 7;
        loop {
            // The first neighbour counter-clockwise from the background on the right.
            way = (way + if way % 2 == 0 { 7 } else { 6 }) % 8;
            let step = |way: usize| [at[0] + STEPS[way][0], at[1] + STEPS[way][1]];
            let turns = (0..8).map(|turn| (way + turn) % 8);
            let Some(found) = { turns }.find(|&way| self.is_set(step(way))) else {
                border.truncate(1);
                return border;
            };
            let next = step(found);
            if at == begin && border.get(1) == Some(&next) {
                border.pop();
                return border;
            }
            border.push(next);
            seen.set(next);
            (way, at) = (found, next);
        }
    }
}

/// Return the pixels of a row, or of a cell, moved by one column to the right.
#[inline(always)]
fn shift_right(left: u64, word: u64) -> u64 {
    word << 1 & !FIRST | left >> 7 & FIRST
}

/// Return the pixels of a cell moved by one column to the left.
#[inline(always)]
fn shift_left(word: u64, right: u64) -> u64 {
    word >> 1 & !LAST | right << 7 & LAST
}

/// Return the pixels of a cell moved up by one row.
#[inline(always)]
fn shift_up(below: u64, word: u64) -> u64 {
    word << ROW | below >> ROWS
}

/// Return the pixels of a cell moved down by one row.
#[inline(always)]
fn shift_down(word: u64, above: u64) -> u64 {
    word >> ROW | above << ROWS
}

/// Return twice the area that a border runs around, negative for those of holes.
fn double_area(border: &[Pixel]) -> i64 {
    let next = border.iter().cycle().skip(1);
    let cross = |(a, b): (&Pixel, &Pixel)| {
        i64::from(a[0]) * i64::from(b[1]) - i64::from(a[1]) * i64::from(b[0])
    };
    border.iter().zip(next).map(cross).sum()
}

/// Return the vector from a place to the middle of a pixel.
#[inline(always)]
fn to_middle(place: Place, [x, y]: Pixel) -> Place {
    vector(place, [f64::from(x) + 0.5, f64::from(y) + 0.5])
}

/// Return the squared distance of a place to the middles of pixels.
fn measure_to_border(border: &[Pixel], place: Place) -> f64 {
    border.iter().fold(f64::INFINITY, |least, &pixel| {
        let [dx, dy] = to_middle(place, pixel);
        let away = dx * dx + dy * dy;
        if away < least { away } else { least }
    })
}

/// Return the number of a contour's pixel that is nearest to a place, of those set in `first` where
/// the contour's outside is that of the unit direction; if there is none, on either side.
pub(super) fn find_passing_pixel(
    border: &[Pixel],
    first: &Picture,
    place: Place,
    outward: Place,
) -> Option<usize> {
    let n = border.len();
    let mut result = None;
    let mut least = f64::INFINITY;
    for (i, &pixel) in border.iter().enumerate() {
        if !first.is_set(pixel) {
            continue;
        }
        let mut away = length(to_middle(place, pixel));
        if away >= least {
            continue;
        }
        let (ahead, behind) = (border[(i + SPAN) % n], border[(i + n * SPAN - SPAN) % n]);
        // Background is on the right.
        let right = [
            f64::from(ahead[1] - behind[1]),
            f64::from(behind[0] - ahead[0]),
        ];
        let size = length(right);
        if right[0] * outward[0] + right[1] * outward[1] < AGREE * size || size == 0.0 {
            away += WRONG_SIDE;
            if away >= least {
                continue;
            }
        }
        least = away;
        result = Some(i);
    }
    result
}

/// The edges in each cell of a picture, as lists.
#[derive(Clone, Debug)]
pub struct Cells {
    /// The first entry of each cell's list, or -1.
    pub head: Vec<i32>,
    /// The number of each entry's edge.
    pub edge: Vec<i32>,
    /// The next entry of the same cell, or -1.
    pub link: Vec<i32>,
}

impl Cells {
    /// Return the edges in a cell by number.
    pub(super) fn edges(&self, cell: usize) -> impl Iterator<Item = usize> {
        let entries = std::iter::successors(Some(self.head[cell]), |&k| {
            (k >= 0).then(|| self.link[k as usize])
        });
        let valid = entries.take_while(|&k| k >= 0);
        valid.map(|k| self.edge[k as usize] as usize)
    }
}

/// Draw the edges that begin at some points, in pixels.
///
/// All pixels that an edge passes through are set.
pub fn render_edges(
    points: &[Place],
    first: impl Iterator<Item = usize>,
    n_rows: usize,
    n_columns: usize,
) -> (Picture, Cells) {
    let mut picture = Picture::new(n_rows, n_columns);
    let mut cells = Cells {
        head: vec![-1; n_rows * n_columns],
        edge: Vec::new(),
        link: Vec::new(),
    };
    for (i, k) in first.enumerate() {
        let [p, q] = edge(points, k);
        let d = vector(p, q);
        let [mut at, last] = [p, q].map(|place| place.map(|x| x.floor() as i32));
        let step = d.map(|d| if d > 0.0 { 1 } else { -1 });
        // Where along the edge the next column and the next row begin.
        let mut next = [0, 1].map(|c| {
            if at[c] == last[c] {
                return f64::INFINITY;
            }
            let border = at[c] + i32::from(d[c] > 0.0);
            (f64::from(border) - p[c]) / d[c]
        });
        let mut drawn = None;
        for left in (0..=at[0].abs_diff(last[0]) + at[1].abs_diff(last[1])).rev() {
            picture.set(at);
            let cell = picture.cell(at);
            if drawn != Some(cell) {
                drawn = Some(cell);
                cells.edge.push(i as i32);
                cells.link.push(cells.head[cell]);
                cells.head[cell] = cells.link.len() as i32 - 1;
            }
            if left == 0 {
                break;
            }
            let c = usize::from(at[1] != last[1] && (at[0] == last[0] || next[0] >= next[1]));
            at[c] += step[c];
            next[c] += 1.0 / d[c].abs();
        }
    }
    (picture, cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of the pixels for which a rule holds.
    fn picture(n_rows: usize, n_columns: usize, is_set: impl Fn(Pixel) -> bool) -> Picture {
        let mut made = Picture::new(n_rows, n_columns);
        for y in 0..8 * n_rows as i32 {
            for x in 0..8 * n_columns as i32 {
                if is_set([x, y]) {
                    made.set([x, y]);
                }
            }
        }
        made
    }

    fn is_in(low: i32, high: i32, [x, y]: Pixel) -> bool {
        (low..high).contains(&x) && (low..high).contains(&y)
    }

    #[test]
    fn rings_are_the_eight_neighbours() {
        let made = picture(3, 3, |[x, y]| (7 * x + 3 * y * y + x * y) % 5 < 2);
        for y in 0..24 {
            for x in 0..24 {
                let ring = made.read_ring([x, y]);
                for (k, [dx, dy]) in STEPS.into_iter().enumerate() {
                    assert_eq!(ring >> k & 1 == 1, made.is_set([x + dx, y + dy]));
                }
            }
        }
    }

    #[test]
    fn erosion_takes_off_what_dilation_adds_to_a_square() {
        let square = picture(5, 5, |p| is_in(15, 25, p));
        assert_eq!(square.dilate(), picture(5, 5, |p| is_in(14, 26, p)));
        assert_eq!(square.close_gaps(3), square);
    }

    #[test]
    fn the_contour_of_a_square_runs_counter_clockwise() {
        let square = picture(5, 5, |p| is_in(10, 20, p));
        let border = square.find_outer_contour([15.0, 9.0]);
        assert_eq!(border.len(), 36);
        assert!(double_area(&border) > 0);
    }

    #[test]
    fn a_lone_pixel_is_its_own_contour() {
        let dot = picture(2, 2, |p| p == [9, 5]);
        assert_eq!(dot.find_outer_contour([0.0, 0.0]), [[9, 5]]);
    }

    #[test]
    fn every_cell_lists_the_edges_drawn_in_it() {
        let points = [[2.5, 2.5], [20.5, 2.5], [20.5, 13.5]];
        let (drawn, cells) = render_edges(&points, 0..2, 2, 3);
        let row = |[x, y]: Pixel| y == 2 && (2..=20).contains(&x);
        let column = |[x, y]: Pixel| x == 20 && (2..=13).contains(&y);
        assert_eq!(drawn, picture(2, 3, |p| row(p) || column(p)));
        let listed: Vec<Vec<usize>> = (0..6).map(|cell| cells.edges(cell).collect()).collect();
        assert_eq!(
            listed,
            [vec![0], vec![0], vec![1, 0], vec![], vec![], vec![1]]
        );
    }
}
