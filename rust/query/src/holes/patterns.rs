//! The likeliest embeddings of patterns in a loop.
//!
//! A pattern is laid along its boundary edge by edge: a polychord that is met first may have any
//! width, and is as wide where it comes out. What is lost never shrinks, so that a way is left where
//! it has lost too much: a branch and bound.

use std::ops::Range;

use patterndb_geometry::sorting::argsort;
use patterndb_geometry::vector::max;

/// Patterns with more open polychords are not kept.
pub const MOST_CHORDS: usize = 40;

/// Steps after which the search in one pattern ends.
const MOST_LOOKED: usize = 20_000;

/// Steps between two looks at the cancel flag: some ten microseconds.
const STEPS_PER_LOOK: usize = 256;

/// Ways that are less likely than the best by a factor of exp(this) are not looked at to the end.
const REACH: f64 = 10.0;

/// Numbers of quads at a loop vertex, and 0.
const KINDS: usize = 5;

/// The number of quads at a loop vertex where no side begins.
const STRAIGHT: usize = 2;

/// The other numbers of quads that a corner may have.
const CORNERS: [usize; 3] = [1, 3, 4];

/// The boundaries of patterns.
#[derive(Clone, Copy, Debug)]
pub struct Tables<'a> {
    /// Where the sides of each pattern begin, and how many there are in all.
    pub first_side: &'a [i32],
    /// The quads at the corner where a side begins, 0 where there is none.
    pub corner: &'a [i32],
    /// Where the edges of each side begin, and how many there are in all.
    pub first_edge: &'a [i32],
    /// The polychord across each edge.
    pub chord: &'a [i32],
    /// The number of open polychords of each pattern.
    pub n_chords: &'a [i32],
    /// Whether a pattern differs from its mirror image.
    pub chiral: &'a [bool],
    /// What the score of each pattern is before anything is lost.
    pub prior: &'a [f64],
}

impl Tables<'_> {
    fn sides(&self, pattern: usize) -> Range<usize> {
        self.first_side[pattern] as usize..self.first_side[pattern + 1] as usize
    }
}

/// What quads lose at the vertices of a loop.
///
/// `items` has, for the loop and its mirror image, both twice around, how much less likely 0 to 4
/// quads are at each vertex than the likeliest number.
struct Loss<'a> {
    items: [&'a [[f64; KINDS]]; 2],
    /// What the vertices before each lose with two quads.
    passed: [Vec<f64>; 2],
    stretches: Stretches,
    /// The number of the loop's edges.
    n: usize,
}

impl Loss<'_> {
    fn new(items: &[[f64; KINDS]], n: usize) -> Loss<'_> {
        let (ahead, back) = items.split_at(2 * n);
        let pass = |items: &[[f64; KINDS]]| {
            let mut sum = 0.0;
            let mut passed = vec![sum];
            for loss in items {
                sum += loss[STRAIGHT];
                passed.push(sum);
            }
            passed
        };
        Loss {
            items: [ahead, back],
            passed: [pass(ahead), pass(back)],
            stretches: Stretches::new([ahead, back], n),
            n,
        }
    }
}

/// What corners lose at least somewhere on a stretch of the loop, beyond what two quads lose.
struct Stretches {
    /// By hand, first vertex, number of vertices, kind of corner and number of corners.
    rest: Vec<f64>,
    n: usize,
}

impl Stretches {
    fn new(items: [&[[f64; KINDS]]; 2], n: usize) -> Stretches {
        let mut rest = Vec::with_capacity(2 * n * n * CORNERS.len() * (n + 1));
        let mut ordered = [const { Vec::new() }; CORNERS.len()];
        for items in items {
            for i in 0..n {
                ordered.iter_mut().for_each(Vec::clear);
                for span in 0..n {
                    for (ordered, &quads) in ordered.iter_mut().zip(&CORNERS) {
                        if span > 0 {
                            let loss = &items[i + span - 1];
                            insert_sorted(ordered, loss[quads] - loss[STRAIGHT]);
                        }
                        let end = rest.len() + n + 1;
                        let mut least = 0.0;
                        rest.push(least);
                        for &gain in &*ordered {
                            least += gain;
                            rest.push(least);
                        }
                        rest.resize(end, f64::INFINITY);
                    }
                }
            }
        }
        Stretches { rest, n }
    }

    /// Return what corners lose at least on `span` vertices from `i` on, added to `lost`; `corners`
    /// has the numbers of corners by their quads.
    fn add_least(&self, lost: f64, hand: usize, i: usize, span: usize, corners: &Corners) -> f64 {
        let n = self.n;
        let first = ((hand * n + i) * n + span) * CORNERS.len() * (n + 1);
        let least = &self.rest[first..][..CORNERS.len() * (n + 1)];
        let [convex, reflex, full] = corners.map(usize::from);
        lost + least[convex] + least[n + 1 + reflex] + least[2 * (n + 1) + full]
    }
}

/// Insert a number behind all that are not greater.
fn insert_sorted(ordered: &mut Vec<f64>, number: f64) {
    let mut at = ordered.len();
    while at > 0 && ordered[at - 1] > number {
        at -= 1;
    }
    ordered.insert(at, number);
}

/// Return what the score of each pattern cannot exceed, however it lies.
///
/// Where it has m corners of k quads, all but m of the loop's vertices get another number.
fn bound_patterns(loss: &[[f64; KINDS]], tables: &Tables) -> Vec<f64> {
    let n = loss.len();
    let least = loss.iter().fold(0.0, |sum, loss| sum + loss[STRAIGHT]);
    // What the m cheapest of all vertices lose with another number than two.
    let saved = CORNERS.map(|quads| {
        let gains: Vec<f64> = loss
            .iter()
            .map(|loss| loss[quads] - loss[STRAIGHT])
            .collect();
        let order = argsort(&gains);
        let mut sums = vec![0.0];
        sums.extend(order.iter().scan(0.0, |sum, &i| {
            *sum += gains[i];
            Some(*sum)
        }));
        sums
    });
    let bound = |(pattern, &prior): (usize, &f64)| {
        let mut numbers = [0; KINDS];
        for &quads in &tables.corner[tables.sides(pattern)] {
            if quads > 0 {
                match numbers.get_mut(quads as usize) {
                    Some(number) => *number += 1,
                    None => return f64::NEG_INFINITY,
                }
            }
        }
        if numbers[1..].iter().any(|&number| number > n) {
            return f64::NEG_INFINITY;
        }
        let saved = saved
            .iter()
            .zip(CORNERS)
            .map(|(sums, quads)| sums[numbers[quads]]);
        prior - max(saved.fold(least, |total, saved| total + saved), 0.0)
    };
    tables.prior.iter().enumerate().map(bound).collect()
}

/// Numbers of corners, by their quads as in [`CORNERS`].
type Corners = [u8; CORNERS.len()];

/// The boundary of a pattern.
struct Outline {
    edges: Vec<Edge>,
    /// The quads at the vertex where the first edge begins.
    first: usize,
    /// The number of polychords.
    n_chords: usize,
}

/// An edge of a pattern's boundary.
struct Edge {
    /// The polychord across it.
    chord: usize,
    /// Whether the polychord was not met before; whether it is the last of those.
    is_first_met: bool,
    is_last_met: bool,
    /// The vertex where the edge ends; None where that is the first vertex of the boundary.
    end: Option<End>,
}

/// The vertex where an edge of a pattern's boundary ends.
#[derive(Clone, Copy)]
struct End {
    quads: usize,
    /// Corners beyond it.
    beyond: Corners,
}

impl Outline {
    /// Return the boundary of a pattern with 1 to `MOST_CHORDS` polychords.
    fn new(tables: &Tables, pattern: usize, n_chords: usize) -> Outline {
        let sides = tables.sides(pattern);
        let begin = tables.first_edge[sides.start] as usize;
        let chords = &tables.chord[begin..][..2 * n_chords];
        let mut quads = vec![STRAIGHT; chords.len()];
        for side in sides {
            if tables.corner[side] > 0 {
                quads[tables.first_edge[side] as usize - begin] = tables.corner[side] as usize;
            }
        }
        let is_first_met = |e: usize| !chords[..e].contains(&chords[e]);
        let last_met = (0..chords.len()).rfind(|&e| is_first_met(e));
        let mut edges = Vec::with_capacity(chords.len());
        let mut end = None;
        for e in (0..chords.len()).rev() {
            edges.push(Edge {
                chord: chords[e] as usize,
                is_first_met: is_first_met(e),
                is_last_met: last_met == Some(e),
                end,
            });
            end = Some(End {
                quads: quads[e],
                beyond: end.map_or([0; CORNERS.len()], End::add_to_beyond),
            });
        }
        edges.reverse();
        Outline {
            edges,
            first: quads[0],
            n_chords,
        }
    }
}

impl End {
    /// Return the corners from this vertex on.
    fn add_to_beyond(self) -> Corners {
        let mut corners = self.beyond;
        if let Some(corner) = CORNERS.iter().position(|&quads| quads == self.quads) {
            corners[corner] += 1;
        }
        corners
    }
}

/// An embedding of a pattern in a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Embedding {
    /// How likely it is.
    pub score: f64,
    /// The row of the pattern.
    pub pattern: i32,
    /// The loop's vertex at which the pattern's corner 0 lies.
    pub turn: i32,
    /// Whether the pattern runs backwards along the loop.
    pub is_mirrored: bool,
    /// The widths of its polychords, the rest 0.
    pub widths: [i32; MOST_CHORDS],
}

/// The likeliest ways so far.
struct Likeliest {
    kept: Vec<Embedding>,
    most: usize,
    /// The least likely of those kept, once there are as many as may be.
    worst: usize,
    /// What is not likelier is not looked at to the end.
    floor: f64,
}

impl Likeliest {
    fn add(&mut self, embedding: Embedding) {
        if self.kept.len() < self.most {
            self.kept.push(embedding);
        } else {
            self.kept[self.worst] = embedding;
        }
        if self.kept.len() == self.most {
            self.worst = 0;
            for (i, kept) in self.kept.iter().enumerate() {
                if kept.score < self.kept[self.worst].score {
                    self.worst = i;
                }
            }
            self.floor = max(self.floor, self.kept[self.worst].score);
        }
        self.floor = max(self.floor, embedding.score - REACH);
    }
}

/// Where an edge of a pattern begins.
#[derive(Clone, Copy)]
struct Step {
    /// The loop vertex, from the search's first on.
    at: usize,
    /// By how much polychords can still be widened.
    spare: usize,
    /// What was lost up to this vertex.
    lost: f64,
}

/// What follows after an edge was laid.
enum Laid {
    /// It loses too much, but a wider polychord may not.
    Wider,
    /// It loses too much, and so do all that are wider.
    Back,
    /// The next edge.
    Ahead(Step),
    /// The last edge is laid. What is lost in all, and by how much polychords can still be widened.
    Whole { lost: f64, spare: usize },
}

/// The search for the ways in which a pattern lies with its corner 0 at one vertex of the loop.
struct Search<'a> {
    loss: &'a Loss<'a>,
    outline: &'a Outline,
    /// The pattern's row and prior score.
    pattern: i32,
    prior: f64,
    /// 0 for the loop, 1 for its mirror image, and the vertex where the pattern begins.
    hand: usize,
    start: usize,
    /// The edges that are laid, and the next.
    steps: Vec<Step>,
    /// The widths of polychords, 0 before the first.
    widths: [usize; MOST_CHORDS],
    /// Whether an edge was laid across a polychord that comes out.
    laid: [bool; MOST_CHORDS],
}

impl Search<'_> {
    /// Look at all ways, and keep the likeliest. `looked` counts the steps.
    fn run(
        &mut self,
        looked: &mut usize,
        likeliest: &mut Likeliest,
        is_cancelled: &impl Fn() -> bool,
    ) {
        let first = Step {
            at: self.start,
            spare: self.loss.n / 2 - self.outline.n_chords,
            lost: self.loss.items[self.hand][self.start][self.outline.first],
        };
        if self.prior - first.lost <= likeliest.floor {
            return;
        }
        self.begin_edge(first);
        while let Some(&step) = self.steps.last() {
            *looked += 1;
            if *looked >= MOST_LOOKED || (looked.is_multiple_of(STEPS_PER_LOOK) && is_cancelled()) {
                break;
            }
            let edge = &self.outline.edges[self.steps.len() - 1];
            let Some(width) = self.choose_width(edge, step) else {
                self.steps.pop();
                continue;
            };
            match self.lay_edge(edge, step, width, likeliest.floor) {
                Laid::Wider => {}
                Laid::Back => {
                    self.steps.pop();
                }
                Laid::Ahead(next) => self.begin_edge(next),
                Laid::Whole { lost, spare: 0 } => likeliest.add(self.make_embedding(lost)),
                Laid::Whole { .. } => {}
            }
        }
    }

    fn begin_edge(&mut self, step: Step) {
        let edge = &self.outline.edges[self.steps.len()];
        if edge.is_first_met {
            self.widths[edge.chord] = 0;
        }
        self.steps.push(step);
    }

    /// Return the next width of the polychord across an edge; None where there is none.
    fn choose_width(&mut self, edge: &Edge, step: Step) -> Option<usize> {
        let width = &mut self.widths[edge.chord];
        if edge.is_first_met {
            *width = match *width {
                // The last polychord to be met takes all that is spare.
                0 if edge.is_last_met => step.spare + 1,
                width => width + 1,
            };
            if *width > step.spare + 1 {
                return None;
            }
        } else if self.laid[edge.chord] {
            self.laid[edge.chord] = false;
            return None;
        }
        Some(*width)
    }

    /// Lay an edge across a polychord of this width.
    fn lay_edge(&mut self, edge: &Edge, step: Step, width: usize, floor: f64) -> Laid {
        let passed = &self.loss.passed[self.hand];
        let there = step.at + width;
        let (before, after) = (passed[step.at + 1], passed[there]);
        let mut lost = step.lost + after - before;
        let mut least = lost;
        if let Some(end) = &edge.end {
            lost += self.loss.items[self.hand][there][end.quads];
            least = self.add_rest(lost, there, &end.beyond);
        }
        if self.prior - least <= floor {
            // Wider still loses more only where the vertices that are passed do.
            let gone = after - before;
            let is_hopeless = !edge.is_first_met || self.prior - step.lost - gone <= floor;
            return if is_hopeless { Laid::Back } else { Laid::Wider };
        }
        let spare = if edge.is_first_met {
            step.spare + 1 - width
        } else {
            self.laid[edge.chord] = true;
            step.spare
        };
        match edge.end {
            Some(_) => Laid::Ahead(Step {
                at: there,
                spare,
                lost,
            }),
            None => Laid::Whole { lost, spare },
        }
    }

    /// Return what is lost at least in the end, where so much was lost up to a vertex, and corners
    /// follow.
    fn add_rest(&self, lost: f64, there: usize, corners: &Corners) -> f64 {
        let n = self.loss.n;
        let end = self.start + n;
        let passed = &self.loss.passed[self.hand];
        let next = there + 1;
        let place = if next < n { next } else { next - n };
        let span = end - next;
        let stretches = &self.loss.stretches;
        let least = stretches.add_least(lost, self.hand, place, span, corners);
        least + (passed[end] - passed[next])
    }

    fn make_embedding(&self, lost: f64) -> Embedding {
        let n = self.loss.n;
        let is_mirrored = self.hand == 1;
        let turn = if is_mirrored {
            (n - self.start) % n
        } else {
            self.start
        };
        let mut widths = self.widths.map(|width| width as i32);
        widths[self.outline.n_chords..].fill(0);
        Embedding {
            score: self.prior - lost,
            pattern: self.pattern,
            turn: turn as i32,
            is_mirrored,
            widths,
        }
    }
}

/// Return the likeliest embeddings of patterns in a loop, at most as many as given, in no order. Once
/// `is_cancelled`, those that were found until then.
///
/// `loss` has, for the loop of `n` edges and its mirror image, both twice around, how much less
/// likely 0 to 4 quads are at each vertex than the likeliest number.
pub fn enumerate_embeddings(
    loss: &[[f64; KINDS]],
    n: usize,
    tables: &Tables,
    most: usize,
    is_cancelled: &impl Fn() -> bool,
) -> Vec<Embedding> {
    let mut likeliest = Likeliest {
        kept: Vec::new(),
        most,
        worst: 0,
        floor: f64::NEG_INFINITY,
    };
    let bound = bound_patterns(&loss[..n], tables);
    let loss = Loss::new(loss, n);
    let falling: Vec<f64> = bound.iter().map(|bound| -bound).collect();
    for pattern in argsort(&falling) {
        if bound[pattern] <= likeliest.floor || is_cancelled() {
            break;
        }
        let n_chords = tables.n_chords[pattern] as usize;
        if (1..=MOST_CHORDS.min(n / 2)).contains(&n_chords) {
            look_at_pattern(&loss, tables, pattern, &mut likeliest, is_cancelled);
        }
    }
    likeliest.kept
}

/// Look at the ways in which a pattern with 1 to `MOST_CHORDS` polychords lies in a loop.
fn look_at_pattern(
    loss: &Loss,
    tables: &Tables,
    pattern: usize,
    likeliest: &mut Likeliest,
    is_cancelled: &impl Fn() -> bool,
) {
    let outline = Outline::new(tables, pattern, tables.n_chords[pattern] as usize);
    let mut looked = 0;
    for hand in 0..if tables.chiral[pattern] { 2 } else { 1 } {
        for start in 0..loss.n {
            if looked >= MOST_LOOKED || is_cancelled() {
                return;
            }
            let mut search = Search {
                loss,
                outline: &outline,
                prior: tables.prior[pattern],
                pattern: pattern as i32,
                hand,
                start,
                steps: Vec::with_capacity(outline.edges.len()),
                widths: [0; MOST_CHORDS],
                laid: [false; MOST_CHORDS],
            };
            search.run(&mut looked, likeliest, is_cancelled);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid: four corners, two polychords.
    const GRID: Tables = Tables {
        first_side: &[0, 4],
        corner: &[1, 1, 1, 1],
        first_edge: &[0, 1, 2, 3, 4],
        chord: &[0, 1, 0, 1],
        n_chords: &[2],
        chiral: &[false],
        prior: &[0.0],
    };

    /// A loop, corners of one quad at the vertices given, whose other numbers lose as much.
    fn make_loss(n: usize, corners: &[usize], lost: f64) -> Vec<[f64; KINDS]> {
        let of_loop = (0..n).map(|i| {
            let quads = if corners.contains(&i) { 1 } else { 2 };
            std::array::from_fn(|k| if k == quads { 0.0 } else { lost })
        });
        let of_loop: Vec<_> = of_loop.collect();
        let mut mirrored = of_loop.clone();
        mirrored[1..].reverse();
        [&of_loop[..], &of_loop, &mirrored, &mirrored].concat()
    }

    #[test]
    fn a_grid_lies_at_its_corners() {
        let loss = make_loss(10, &[1, 3, 6, 8], 3.0);
        let embeddings = enumerate_embeddings(&loss, 10, &GRID, 5, &|| false);
        let (best, others): (Vec<Embedding>, Vec<Embedding>) = embeddings
            .iter()
            .partition(|embedding| embedding.score == 0.0);
        assert!(others.iter().all(|embedding| embedding.score <= -3.0));
        let mut best: Vec<_> = best
            .iter()
            .map(|embedding| (embedding.turn, &embedding.widths[..3]))
            .collect();
        best.sort_unstable();
        let (wide, high) = (&[2, 3, 0][..], &[3, 2, 0][..]);
        assert_eq!(best, [(1, wide), (3, high), (6, wide), (8, high)]);
    }

    #[test]
    fn no_way_is_better_than_its_bound() {
        let loss = make_loss(8, &[0, 1, 4], 2.0);
        let bound = bound_patterns(&loss[..8], &GRID)[0];
        let embeddings = enumerate_embeddings(&loss, 8, &GRID, 100, &|| false);
        let best = embeddings
            .iter()
            .map(|embedding| embedding.score)
            .fold(f64::NEG_INFINITY, f64::max);
        assert!(best <= bound && best == -2.0);
    }
}
