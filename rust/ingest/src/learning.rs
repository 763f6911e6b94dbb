//! Putting the results of several tasks together: hashes of codes, and examples as they are stored.

use patterndb_core::shortcode::{Rows, push_packed};

use crate::hashing::{Key, hash_symbols};

/// Return the hashes of packed codes: code i is `raw[ends[i]..ends[i + 1]]`.
pub fn hash_rows(raw: &[u8], ends: &[i64]) -> Vec<Key> {
    let rows = ends.windows(2);
    rows.map(|at| hash_symbols(&raw[at[0] as usize..at[1] as usize]))
        .collect()
}

/// Pack the examples of patterns: of each its faces, ascending, as differences of seven bits a byte.
///
/// `quads` are the examples one after the other, `sizes` their lengths, `faces` the face of each
/// quad.
pub fn pack_faces(quads: &[i32], sizes: &[i32], faces: &[i64]) -> Rows<u8> {
    let mut packed = Rows {
        flat: Vec::with_capacity(2 * quads.len()),
        ends: vec![0],
        bad: None,
    };
    let mut own = Vec::new();
    let mut rest = quads;
    for &size in sizes {
        let (example, after) = rest.split_at(size as usize);
        rest = after;
        own.clear();
        own.extend(example.iter().map(|&quad| faces[quad as usize]));
        own.sort_unstable();
        let mut before = 0;
        for &face in &own {
            push_packed(&mut packed.flat, (face - before) as u64);
            before = face;
        }
        packed.ends.push(packed.flat.len() as i64);
    }
    packed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_stored_as_differences() {
        let packed = pack_faces(&[2, 0, 1], &[2, 1], &[5, 900, 300]);
        // 300 - 5 = 2 * 128 + 39, 900 = 7 * 128 + 4.
        assert_eq!(packed.flat, [5, 39 | 128, 2, 4 | 128, 7]);
        assert_eq!(packed.ends, [0, 3, 5]);
    }
}
