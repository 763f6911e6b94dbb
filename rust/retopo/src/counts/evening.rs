//! Strips of chains that are tied to one count.

use std::iter;

/// The patches of a network, their sides, and the chains of these.
#[derive(Clone, Copy, Debug)]
pub struct Sides<'a> {
    /// The sides of patch f are `first_side[f]` to `first_side[f + 1]`.
    pub first_side: &'a [i32],
    /// The chains of side k are `chains[first_chain[k]]` to `chains[first_chain[k + 1]]`.
    pub first_chain: &'a [i32],
    /// The chains of all sides.
    pub chains: &'a [i32],
}

impl<'a> Sides<'a> {
    /// Return the sides of each patch that has four.
    fn quads(self) -> impl Iterator<Item = [usize; 4]> + 'a {
        let ends = self.first_side.windows(2);
        ends.filter(|ends| ends[1] - ends[0] == 4)
            .map(|ends| [0, 1, 2, 3].map(|k| ends[0] as usize + k))
    }

    /// Return the only chain of a side; None where there are others.
    fn only_chain(self, side: usize) -> Option<usize> {
        let (low, high) = (self.first_chain[side], self.first_chain[side + 1]);
        (high - low == 1).then(|| self.chains[low as usize] as usize)
    }
}

/// A strip, by the smallest of its chains.
#[derive(Clone, Copy)]
struct Strip {
    /// A smaller chain of the strip, or the chain itself.
    name: usize,
    /// The count that a chain of the strip is pinned to, or 0.
    pinned: i32,
    /// The fewest edges that a chain of the strip may get.
    least: i32,
}

/// Label every chain by the smallest chain of its strip.
///
/// Opposite sides of a patch of four are tied where each is a single chain; not where chains are
/// pinned to different counts, or one to fewer edges than the other needs.
///
/// `pinned`: the count of each chain that the user chose, or 0. `least`: the fewest edges of each.
pub fn tie_sides(sides: Sides, pinned: &[i32], least: &[i32]) -> Vec<i32> {
    let given = iter::zip(pinned, least).enumerate();
    let mut strips: Vec<Strip> = given
        .map(|(name, (&pinned, &least))| Strip {
            name,
            pinned,
            least,
        })
        .collect();
    for [a, b, c, d] in sides.quads() {
        for (one, other) in [(a, c), (b, d)] {
            let (Some(one), Some(other)) = (sides.only_chain(one), sides.only_chain(other)) else {
                continue;
            };
            let one = find_name(&mut strips, one);
            let other = find_name(&mut strips, other);
            tie(&mut strips, one, other);
        }
    }
    // Names are smaller than the chains that they stand for, and done before.
    for chain in 0..strips.len() {
        strips[chain].name = strips[strips[chain].name].name;
    }
    strips.iter().map(|strip| strip.name as i32).collect()
}

/// Return the smallest chain of a chain's strip; ways to it are halved (Tarjan and van Leeuwen 1984).
fn find_name(strips: &mut [Strip], mut chain: usize) -> usize {
    while strips[chain].name != chain {
        let above = strips[strips[chain].name].name;
        strips[chain].name = above;
        chain = above;
    }
    chain
}

/// Make two strips one, if their pinned counts allow it.
fn tie(strips: &mut [Strip], one: usize, other: usize) {
    let (a, b) = (strips[one], strips[other]);
    if a.pinned != 0 && b.pinned != 0 && a.pinned != b.pinned {
        return;
    }
    let pinned = a.pinned.max(b.pinned);
    let least = a.least.max(b.least);
    if pinned != 0 && pinned < least {
        return;
    }
    let name = one.min(other);
    strips[one.max(other)].name = name;
    strips[name] = Strip {
        name,
        pinned,
        least,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two patches of four sides; chain 1 is between them.
    const PAIR: Sides = Sides {
        first_side: &[0, 4, 8],
        first_chain: &[0, 1, 2, 3, 4, 5, 6, 7, 8],
        chains: &[0, 1, 2, 3, 4, 5, 6, 1],
    };

    #[test]
    fn opposite_sides_are_tied() {
        assert_eq!(tie_sides(PAIR, &[0; 7], &[1; 7]), [0, 1, 0, 1, 4, 1, 4]);
    }

    #[test]
    fn chains_of_different_pinned_counts_are_not() {
        let pinned = [2, 0, 3, 0, 5, 0, 0];
        let strips = tie_sides(PAIR, &pinned, &[1; 7]);
        assert_eq!(strips, [0, 1, 2, 1, 4, 1, 4]);
        let strips = tie_sides(PAIR, &pinned, &[1, 1, 1, 1, 1, 1, 6]);
        assert_eq!(strips, [0, 1, 2, 1, 4, 1, 6]);
    }
}
