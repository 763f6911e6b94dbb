//! Corners of holes: traits of assignments of quads to the vertices of a loop, and the ensembles of
//! decision trees that score them (Friedman 2001, "Greedy function approximation: a gradient boosting
//! machine").

/// Traits of an assignment; `TRAITS` in query/holes/corners.py names them in the same order.
pub const N_TRAITS: usize = 22;

/// The logarithm of a probability of 1 to 4 quads at a loop vertex.
type Logs = [f64; 4];

/// What is counted along the loop.
#[derive(Default)]
struct Counts {
    /// Quarter turns to the left.
    turning: i32,
    irregular: i32,
    /// Vertices with two quads too few or fewer, one too few, one too many, two or more too many.
    off: [i32; 4],
    /// Corners with one, three and four quads.
    convex: i32,
    reflex: i32,
    full: i32,
    /// Neighbours that are both irregular; of these, one has too many quads and one too few.
    irregular_pairs: i32,
    dipoles: i32,
    /// Neighbours of which the second is a corner, and the first as well; both convex.
    corner_pairs: i32,
    convex_pairs: i32,
}

/// A loop vertex with an assigned number of quads.
#[derive(Clone, Copy)]
struct Vertex {
    quads: i32,
    /// The quads less those of a regular vertex.
    off: i32,
}

impl Vertex {
    fn is_corner(self) -> bool {
        self.quads != 2
    }
}

impl Counts {
    fn add(&mut self, before: Vertex, vertex: Vertex) {
        self.turning += 2 - vertex.quads;
        match vertex.quads {
            1 => self.convex += 1,
            3 => self.reflex += 1,
            4 => self.full += 1,
            _ => {}
        }
        match vertex.off {
            ..=-2 => self.off[0] += 1,
            -1 => self.off[1] += 1,
            0 => {}
            1 => self.off[2] += 1,
            2.. => self.off[3] += 1,
        }
        self.irregular += i32::from(vertex.off != 0);
        self.irregular_pairs += i32::from(vertex.off != 0 && before.off != 0);
        self.dipoles += i32::from(vertex.off * before.off < 0);
        self.corner_pairs += i32::from(vertex.is_corner() && before.is_corner());
        self.convex_pairs += i32::from(vertex.quads == 1 && before.quads == 1);
    }
}

/// Return whether four corners on a loop of `n` edges are those of a rectangle: opposite sides are
/// equally long.
fn is_rectangle(corners: &[usize; 4], n: usize) -> bool {
    let side = |i: usize| corners[i + 1] - corners[i];
    let (a, b) = (side(0), side(1));
    a == side(2) && 2 * b + 2 * a == n
}

/// Measure an assignment.
fn measure_assignment(
    logs: &[Logs],
    regular_valence: &[i32],
    quads: &[i32],
    best: f64,
    corners: &mut Vec<usize>,
) -> [f64; N_TRAITS] {
    let n = quads.len();
    let vertex = |i: usize| Vertex {
        quads: quads[i],
        off: quads[i] - regular_valence[i],
    };
    let mut counts = Counts::default();
    let mut log_corners = -best;
    let mut before = vertex(n - 1);
    corners.clear();
    for (i, logs) in logs.iter().enumerate() {
        let here = vertex(i);
        log_corners += logs[here.quads as usize - 1];
        counts.add(before, here);
        if here.is_corner() {
            corners.push(i);
        }
        before = here;
    }
    // A loop that turns once has four more quarters to the left than to the right.
    let more = counts.turning - 4;
    let four: Option<&[usize; 4]> = corners.as_slice().try_into().ok().filter(|_| more == 0);
    let is = |yes: bool| f64::from(u8::from(yes));
    [
        log_corners,
        is(more == 0),
        f64::from(more.abs()),
        f64::from(more * more) / 10.0,
        is(more > 0),
        is(counts.turning % 2 == 0),
        f64::from(counts.irregular),
        f64::from(counts.off[0]),
        f64::from(counts.off[1]),
        f64::from(counts.off[2]),
        f64::from(counts.off[3]),
        is(counts.irregular == 0),
        f64::from(counts.convex),
        f64::from(counts.reflex),
        f64::from(counts.full),
        f64::from(counts.irregular_pairs),
        f64::from(counts.dipoles),
        f64::from(counts.corner_pairs),
        f64::from(counts.convex_pairs),
        is(four.is_some_and(|corners| is_rectangle(corners, n))),
        is(four.is_some()),
        is(corners.is_empty()),
    ]
}

/// Measure the traits of assignments of 1 to 4 quads to the vertices of a loop.
///
/// `logs` has the log probabilities of 1 to 4 quads at each vertex, `regular_valence` the quads that would make
/// each regular. `assignments` lists the quads of all vertices of the first assignment, then of the
/// next.
pub fn measure(
    logs: &[Logs],
    regular_valence: &[i32],
    assignments: &[i32],
) -> Vec<[f64; N_TRAITS]> {
    let greatest = |logs: &Logs| {
        logs[1..]
            .iter()
            .fold(logs[0], |a, &b| if b > a { b } else { a })
    };
    let best = logs.iter().fold(0.0, |sum, logs| sum + greatest(logs));
    let mut corners = Vec::with_capacity(regular_valence.len());
    assignments
        .chunks_exact(regular_valence.len().max(1))
        .map(|quads| measure_assignment(logs, regular_valence, quads, best, &mut corners))
        .collect()
}

/// Trees of which tree `t` adds to score `t % base.len()`.
#[derive(Clone, Copy, Debug)]
pub struct Trees<'a> {
    /// Where the nodes of each tree begin, and how many nodes there are in all.
    pub start: &'a [i32],
    /// The feature that a node compares, -1 at a leaf.
    pub feature: &'a [i16],
    /// The left child is taken where the feature is not above this.
    pub threshold: &'a [f32],
    /// The left child, counted from the tree's first node; the right one is the next.
    pub child: &'a [i16],
    /// What a leaf adds.
    pub value: &'a [f32],
    /// The scores without any tree.
    pub base: &'a [f64],
}

impl Trees<'_> {
    /// Return what the tree whose nodes begin at `first` adds for a row of features.
    fn evaluate(&self, first: usize, row: &[f64]) -> f32 {
        let mut at = first;
        while let Ok(feature) = usize::try_from(self.feature[at]) {
            let is_above = row[feature] > f64::from(self.threshold[at]);
            at = first + self.child[at] as usize + usize::from(is_above);
        }
        self.value[at]
    }

    /// Return the scores of rows of `n_features` features: all of the first row, then of the next.
    pub fn score(&self, rows: &[f64], n_features: usize) -> Vec<f64> {
        let kinds = self.base.len();
        let n_rows = rows.len().checked_div(n_features).unwrap_or(0);
        let mut scores = self.base.repeat(n_rows);
        let firsts = self
            .start
            .split_last()
            .map_or(&[][..], |(_, firsts)| firsts);
        let rows = rows.chunks_exact(n_features.max(1));
        for (row, scores) in rows.zip(scores.chunks_exact_mut(kinds.max(1))) {
            for (t, &first) in firsts.iter().enumerate() {
                scores[t % kinds] += f64::from(self.evaluate(first as usize, row));
            }
        }
        scores
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_turns_by_four_and_has_equal_sides() {
        let logs = [[-1.0, -0.5, -2.0, -3.0]; 6];
        let [traits] = measure(&logs, &[2; 6], &[1, 2, 1, 1, 2, 1])[..] else {
            panic!("one assignment");
        };
        assert_eq!(traits[0], 3.0 - 5.0);
        assert_eq!(traits[1..6], [1.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!((traits[6], traits[8], traits[11]), (4.0, 4.0, 0.0));
        assert_eq!(traits[17..], [2.0, 2.0, 1.0, 1.0, 0.0]);
        let [traits] = measure(&logs, &[2; 6], &[1, 2, 2, 1, 1, 1])[..] else {
            panic!("one assignment");
        };
        assert_eq!(traits[19..], [0.0, 1.0, 0.0]);
    }

    #[test]
    fn leaves_add_up() {
        let trees = Trees {
            start: &[0, 3, 4],
            feature: &[1, -1, -1, -1],
            threshold: &[0.5, 0.0, 0.0, 0.0],
            child: &[1, 0, 0, 0],
            value: &[0.0, 1.0, 2.0, 10.0],
            base: &[0.25],
        };
        let scores = trees.score(&[9.0, 0.5, -9.0, 0.75], 2);
        assert_eq!(scores, [11.25, 12.25]);
    }
}
