//! Boundary labels and signatures: which sides a pattern's polychords join, and in what order.
//!
//! The *label* of a pattern numbers its boundary edges, in order from corner 0, so that two edges
//! have one number exactly if one polychord joins them; numbers appear in order 0, 1, 2, ... It is
//! written as a word: for every side its length, then its numbers. The *signature* is the smallest
//! word over all rotations (by sides) and both reflections.
//!
//! Source: Marcias et al. 2015, section 4 ("Edge-flow constraints", Figure 9).

use std::cmp::Ordering;

/// The polychords of a pattern's boundary edges, and its sides.
pub struct Sides<'a> {
    /// Polychord of each boundary edge, counter-clockwise.
    pub chord: &'a [i32],
    /// First edge of each side, ascending. Without a corner the whole boundary is one side.
    pub start: &'a [i32],
    /// Whether there is a corner; without one, rotations count edges in place of sides.
    pub has_corners: bool,
}

/// From where a label is read: from side `rotation` on, or clockwise from that side's far end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orientation {
    /// The first side (the first edge of a pattern without corners).
    pub rotation: usize,
    /// Whether the label is read clockwise.
    pub reflected: bool,
}

/// The smallest word of a pattern.
pub struct Signature {
    /// For every side its length, then its numbers.
    pub word: Vec<i32>,
    /// The first orientation whose label is this word.
    pub orientation: Orientation,
    /// Number of rotations and reflections that leave the word as it is.
    pub symmetries: usize,
}

impl Sides<'_> {
    /// Return the number of edges of a side.
    fn length(&self, side: usize) -> usize {
        let end = match self.start.get(side + 1) {
            Some(&next) => next as usize,
            None => self.start[0] as usize + self.chord.len(),
        };
        end - self.start[side] as usize
    }

    /// Write the label in an orientation to `word`.
    ///
    /// `names` is scratch with a place for every polychord.
    pub fn write_label(
        &self,
        Orientation {
            rotation,
            reflected,
        }: Orientation,
        word: &mut Vec<i32>,
        names: &mut [i32],
    ) {
        let (n_sides, perimeter) = (self.start.len(), self.chord.len());
        names.fill(-1);
        word.clear();
        let mut fresh = 0;
        for k in 0..n_sides {
            let (first, length) = if n_sides == 1 {
                (self.start[0] as usize + rotation, perimeter)
            } else {
                let k = if reflected { n_sides - k } else { k };
                let side = (rotation + k) % n_sides;
                (self.start[side] as usize, self.length(side))
            };
            word.push(length as i32);
            for i in 0..length {
                let edge = first + if reflected { length - 1 - i } else { i };
                let edge = if edge < perimeter {
                    edge
                } else {
                    edge - perimeter
                };
                let name = &mut names[self.chord[edge] as usize];
                if *name < 0 {
                    *name = fresh;
                    fresh += 1;
                }
                word.push(*name);
            }
        }
    }

    /// Return the signature; `names` as in [`Self::write_label`].
    pub fn signature(&self, names: &mut [i32]) -> Signature {
        let n_sides = self.start.len();
        let n_rotations = if self.has_corners {
            n_sides
        } else {
            self.chord.len()
        };
        // A word begins with the length of its first side, so the smallest with a shortest one.
        let shortest = (0..n_sides).map(|side| self.length(side)).min();
        let mut best: Option<Signature> = None;
        let mut word = Vec::new();
        for reflected in [false, true] {
            for rotation in 0..n_rotations {
                if n_sides > 1 && Some(self.length(rotation)) > shortest {
                    continue;
                }
                let orientation = Orientation {
                    rotation,
                    reflected,
                };
                self.write_label(orientation, &mut word, names);
                let order = best.as_ref().map(|best| word.cmp(&best.word));
                match (order, &mut best) {
                    (Some(Ordering::Greater), _) => {}
                    (Some(Ordering::Equal), Some(best)) => best.symmetries += 1,
                    _ => {
                        best = Some(Signature {
                            word: word.clone(),
                            orientation,
                            symmetries: 1,
                        });
                    }
                }
            }
        }
        best.expect("a boundary has an edge")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_has_eight_symmetries() {
        let quad = Sides {
            chord: &[0, 1, 0, 1],
            start: &[0, 1, 2, 3],
            has_corners: true,
        };
        let signature = quad.signature(&mut [0; 2]);
        assert_eq!(signature.word, [1, 0, 1, 1, 1, 0, 1, 1]);
        assert_eq!(signature.symmetries, 8);
    }

    #[test]
    fn a_signature_begins_with_the_shortest_side() {
        // Two quads: sides of one, two, one and two edges, read from a long one.
        let pair = Sides {
            chord: &[0, 1, 2, 1, 0, 2],
            start: &[1, 3, 4, 6 - 1],
            has_corners: true,
        };
        let mut word = Vec::new();
        let as_it_is = Orientation {
            rotation: 0,
            reflected: false,
        };
        pair.write_label(as_it_is, &mut word, &mut [0; 3]);
        assert_eq!(word[..3], [2, 0, 1]);
        let signature = pair.signature(&mut [0; 3]);
        assert_eq!(signature.word[0], 1);
    }
}
