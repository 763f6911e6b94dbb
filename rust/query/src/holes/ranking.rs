//! How regular a candidate is, and how its strands join the loop's edges.

use patterndb_geometry::Point;
use patterndb_geometry::sorting::argsort;
use patterndb_geometry::vector::max;

use super::{REGULAR, edge_key, sum_products};

/// The numbers of a candidate that [`measure_quads`] returns; see `FACTS` in query/holes/ranking.py:
/// inner_irregular to asked_corners, regular_inside to dipoles, least_side.
pub const N_FOUND: usize = 16;

/// A loop, vertex by vertex.
#[derive(Clone, Copy, Debug)]
pub struct Loop<'a> {
    /// The quads that would make each vertex regular.
    pub regular_valence: &'a [i32],
    /// The same, from 1 to 4.
    pub clamped_valence: &'a [i32],
    /// Unit vectors along the edges.
    pub ahead: &'a [Point],
    /// Logarithms of the edges' lengths.
    pub logs: &'a [f64],
}

/// What is counted at the vertices of a candidate.
#[derive(Default)]
struct Counts {
    inner_irregular: i32,
    loop_irregular: i32,
    valence_3: i32,
    valence_5: i32,
    /// Quads too many or too few beyond one.
    valence_far: i32,
    /// Loop vertices with other numbers of quads than are asked for.
    otherwise: i32,
    convex: i32,
    /// Corners with three quads or more.
    others: i32,
}

/// Measure a candidate's quads, of which the first vertices are the loop's.
pub fn measure_quads(quads: &[[i32; 4]], n_vertices: usize, of_loop: &Loop) -> [f64; N_FOUND] {
    let n = of_loop.regular_valence.len();
    let mut valence = vec![0; n_vertices];
    for &v in quads.as_flattened() {
        valence[v as usize] += 1;
    }
    let mut off = valence.clone();
    let mut counts = Counts::default();
    for (v, off) in off.iter_mut().enumerate() {
        *off -= of_loop.regular_valence.get(v).copied().unwrap_or(REGULAR);
        if v < n {
            counts.loop_irregular += i32::from(*off != 0);
        } else {
            counts.inner_irregular += i32::from(*off != 0);
        }
        counts.valence_3 += i32::from(*off == -1);
        counts.valence_5 += i32::from(*off == 1);
        counts.valence_far += (off.abs() - 1).max(0);
    }
    for (&valence, &clamped) in valence.iter().zip(of_loop.clamped_valence) {
        counts.otherwise += i32::from(valence != clamped);
        counts.convex += i32::from(valence == 1);
        counts.others += i32::from(valence != 1 && valence != 2);
    }
    let strands = follow_strands(quads, n, &off);
    let ends = measure_ends(of_loop, &strands.ends);
    let is = |yes: bool| f64::from(u8::from(yes));
    let all_regular = counts.inner_irregular == 0;
    [
        f64::from(counts.inner_irregular),
        f64::from(counts.loop_irregular),
        f64::from(counts.valence_3),
        f64::from(counts.valence_5),
        f64::from(counts.valence_far),
        (quads.len() as f64).ln(),
        f64::from(counts.otherwise),
        is(all_regular),
        is(all_regular && counts.convex == 4 && counts.others == 0),
        ends.ratio,
        ends.worst_ratio,
        ends.turn,
        f64::from(counts.loop_irregular) / n as f64,
        f64::from(strands.touching) / 2.0,
        f64::from(strands.dipoles) / 2.0,
        find_least_side(&valence[..n]) as f64,
    ]
}

/// Return the least number of edges between two corners that follow each other on the loop, the
/// loop's length where it has one or none.
fn find_least_side(valence: &[i32]) -> usize {
    let n = valence.len();
    let corners = || (0..n).filter(|&v| valence[v] != 2);
    let Some(first) = corners().next() else {
        return n;
    };
    let around = corners().skip(1).chain([first + n]);
    let sides = corners().zip(around).map(|(from, to)| to - from);
    sides.min().unwrap_or(n)
}

/// How the loop's edges are to those where their strands end.
struct Ends {
    /// The logarithms of their lengths' ratios: the mean, and the greatest.
    ratio: f64,
    worst_ratio: f64,
    /// 1 and the mean cosine between them; 0 where all run against each other.
    turn: f64,
}

fn measure_ends(of_loop: &Loop, ends: &[usize]) -> Ends {
    let n = ends.len() as f64;
    let (mut ratio, mut worst_ratio, mut turn) = (0.0, 0.0, 0.0);
    for (i, &end) in ends.iter().enumerate() {
        let here = (of_loop.logs[i] - of_loop.logs[end]).abs();
        ratio += here / n;
        worst_ratio = max(worst_ratio, here);
        turn += sum_products(&of_loop.ahead[i], &of_loop.ahead[end]) / n;
    }
    Ends {
        ratio,
        worst_ratio,
        turn: turn + 1.0,
    }
}

/// Where strands end, and what irregular vertices they join.
struct Strands {
    /// For each loop edge, that where its strand ends.
    ends: Vec<usize>,
    /// Half-edges with two irregular ends, and those of which one has too many quads and one too
    /// few. Inner edges count twice.
    touching: i32,
    dipoles: i32,
}

/// Follow the strands from the edges of a loop of `n` edges; `off` has the quads at each vertex, less
/// those of a regular one.
fn follow_strands(quads: &[[i32; 4]], n: usize, off: &[i32]) -> Strands {
    let tail = quads.as_flattened();
    let ends = |h: usize| (tail[h], tail[(h & !3) | ((h + 1) & 3)]);
    let (mut touching, mut dipoles) = (0, 0);
    for h in 0..tail.len() {
        let (a, b) = ends(h);
        let product = off[a as usize] * off[b as usize];
        touching += i32::from(product != 0);
        dipoles += i32::from(product < 0);
    }
    let twin = pair_half_edges(tail.len(), off.len(), ends);
    let mut out = vec![0; n];
    for h in (0..tail.len()).filter(|&h| twin[h].is_none()) {
        let mut g = h;
        for _ in 0..tail.len() {
            g = (g & !3) | ((g + 2) & 3);
            match twin[g] {
                Some(across) => g = across,
                None => break,
            }
        }
        out[tail[h] as usize] = tail[g] as usize;
    }
    Strands {
        ends: out,
        touching,
        dipoles,
    }
}

/// Return the other half-edge with the same ends for each; None on the border.
fn pair_half_edges(
    n: usize,
    n_vertices: usize,
    ends: impl Fn(usize) -> (i32, i32),
) -> Vec<Option<usize>> {
    let key = |h| {
        let (a, b) = ends(h);
        edge_key(a.into(), b.into(), n_vertices)
    };
    let keys: Vec<f64> = (0..n).map(key).collect();
    let mut twin = vec![None; n];
    for pair in argsort(&keys).windows(2) {
        if keys[pair[0]] == keys[pair[1]] {
            twin[pair[0]] = Some(pair[1]);
            twin[pair[1]] = Some(pair[0]);
        }
    }
    twin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_is_regular_and_its_strands_join_opposite_edges() {
        let quads = [[0, 1, 8, 7], [1, 2, 3, 8], [7, 8, 5, 6], [8, 3, 4, 5]];
        let of_loop = Loop {
            regular_valence: &[1, 2, 1, 2, 1, 2, 1, 3],
            clamped_valence: &[1, 2, 1, 2, 1, 2, 1, 3],
            ahead: &[[1.0, 0.0, 0.0]; 8],
            logs: &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        };
        let found = measure_quads(&quads, 9, &of_loop);
        assert_eq!(found[..5], [0.0, 1.0, 1.0, 0.0, 0.0]);
        assert_eq!(found[6..12], [1.0, 1.0, 1.0, 0.25, 1.0, 2.0]);
        assert_eq!(found[12..], [0.125, 0.0, 0.0, 2.0]);
        let strands = follow_strands(&quads, 8, &[0; 9]);
        assert_eq!(strands.ends, [5, 4, 7, 6, 1, 0, 3, 2]);
    }

    #[test]
    fn irregular_vertices_that_touch_are_counted_from_both_quads() {
        let quads = [[0, 1, 2, 3], [1, 4, 5, 2]];
        let strands = follow_strands(&quads, 6, &[0, 1, -1, 0, 0, 0]);
        assert_eq!((strands.touching, strands.dipoles), (2, 2));
    }
}
