//! 128-bit hashes of sets and sequences, and open-addressing tables of them.
//!
//! A set of quads is hashed as the exclusive or of its quads' random numbers (Zobrist), so adding a
//! quad is one operation. Patch counts are exact as long as no two of a mesh's patches share a hash;
//! with 128 bits and 10^8 patches that has a chance of 10^-23.

use std::ops::{Deref, DerefMut};

/// A hash; (0, 0) marks an empty slot of a table.
pub type Key = [u64; 2];

/// Share of slots in use at which a table doubles: linear probing stays short below it.
pub const LOAD: f64 = 0.625;

/// 2^64 divided by the golden ratio: steps of splitmix64.
pub const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// Return the finaliser of splitmix64: every input bit reaches every output bit.
#[inline]
pub fn mix(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// Return `n` fixed pairs of pseudo-random numbers.
pub fn random_pairs(n: usize) -> Vec<Key> {
    let number = |k: u64| mix(mix(k.wrapping_mul(GOLDEN)).wrapping_add(0xD1B5_4A32_D192_ED03));
    (0..n as u64)
        .map(|i| [number(2 * i + 1), number(2 * i + 2)])
        .collect()
}

/// Return the hash of the symbols of a code, or of the bytes of a packed one.
pub fn hash_symbols<T: Copy + Into<u64>>(symbols: &[T]) -> Key {
    let n = symbols.len() as u64;
    let mut a = 0x243F_6A88_85A3_08D3_u64.wrapping_add(n);
    let mut b = 0x1319_8A2E_0370_7344 ^ n;
    for &symbol in symbols {
        let s = symbol.into() + 1;
        a = (a ^ s).wrapping_mul(0x9FB2_1C65_1E98_DF25);
        a ^= a >> 28;
        b = b.wrapping_add(s).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        b ^= b >> 32;
    }
    [mix(a), mix(b)]
}

/// Return the hash of a set with or without an element, by the element's own hash.
#[inline]
pub fn toggle(set: Key, element: Key) -> Key {
    [set[0] ^ element[0], set[1] ^ element[1]]
}

/// Return the slot of a key in a table of 2^k slots, or as an error the slot where it belongs.
#[inline]
pub fn find(keys: &[Key], key: Key) -> Result<usize, usize> {
    let mask = keys.len() - 1;
    let mut slot = key[0] as usize & mask;
    loop {
        let there = keys[slot];
        if there == key {
            return Ok(slot);
        }
        if there == [0, 0] {
            return Err(slot);
        }
        slot = (slot + 1) & mask;
    }
}

/// Return whether one more key can be put into a table with `used` keys before it has to double.
pub fn has_slot(used: i64, slots: usize) -> bool {
    (used + 1) as f64 <= LOAD * slots as f64
}

/// Return the same set in a table of twice the size.
pub fn double_set(keys: &[Key]) -> Vec<Key> {
    let mut bigger = vec![[0, 0]; 2 * keys.len()];
    for &key in keys.iter().filter(|&&key| key != [0, 0]) {
        if let Err(slot) = find(&bigger, key) {
            bigger[slot] = key;
        }
    }
    bigger
}

/// Return the same map in a table of twice the size.
pub fn double_map(keys: &[Key], values: &[i32]) -> (Vec<Key>, Vec<i32>) {
    let mut bigger = vec![[0, 0]; 2 * keys.len()];
    let mut moved = vec![0; 2 * keys.len()];
    for (&key, &value) in keys.iter().zip(values).filter(|(key, _)| **key != [0, 0]) {
        if let Err(slot) = find(&bigger, key) {
            bigger[slot] = key;
            moved[slot] = value;
        }
    }
    (bigger, moved)
}

/// An array of a caller, which an own one replaces as soon as it has to be longer.
pub enum Table<'a, T> {
    /// The caller's.
    Given(&'a mut [T]),
    /// The one that replaces it.
    Own(Vec<T>),
}

impl<T> Deref for Table<'_, T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match self {
            Self::Given(items) => items,
            Self::Own(items) => items,
        }
    }
}

impl<T> DerefMut for Table<'_, T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        match self {
            Self::Given(items) => items,
            Self::Own(items) => items,
        }
    }
}

impl<T: Copy + Default> Table<'_, T> {
    /// Make the table `length` long and keep its first `kept` items; those after them are 0.
    pub fn lengthen(&mut self, kept: usize, length: usize) {
        let mut longer = Vec::with_capacity(length);
        longer.extend_from_slice(&self[..kept]);
        longer.resize(length, T::default());
        *self = Self::Own(longer);
    }
}

/// A map from keys to numbers in tables of 2^k slots.
pub struct KeyMap<'a> {
    /// Key of each slot.
    pub keys: Table<'a, Key>,
    /// Value of each slot.
    pub values: Table<'a, i32>,
}

impl KeyMap<'_> {
    /// Return an empty map.
    pub fn new(slots: usize) -> Self {
        Self {
            keys: Table::Own(vec![[0, 0]; slots]),
            values: Table::Own(vec![0; slots]),
        }
    }

    /// Return the value of a key, or as an error the slot where it belongs.
    #[inline]
    pub fn get(&self, key: Key) -> Result<i32, usize> {
        find(&self.keys, key).map(|slot| self.values[slot])
    }

    /// Put a key into the slot where it belongs.
    pub fn set(&mut self, slot: usize, key: Key, value: i32) {
        self.keys[slot] = key;
        self.values[slot] = value;
    }

    /// Double the number of slots.
    pub fn double(&mut self) {
        let (keys, values) = double_map(&self.keys, &self.values);
        *self = Self {
            keys: Table::Own(keys),
            values: Table::Own(values),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_that_doubles_keeps_its_values() {
        let mut map = KeyMap::new(4);
        // All begin at one slot.
        let keys: Vec<Key> = (0..100).map(|i| [64 * i, i + 1]).collect();
        for (i, &key) in keys.iter().enumerate() {
            if !has_slot(i as i64, map.keys.len()) {
                map.double();
            }
            let slot = map.get(key).expect_err("a key is found that is not there");
            map.set(slot, key, i as i32);
        }
        assert_eq!(map.keys.len(), 256);
        for (i, &key) in keys.iter().enumerate() {
            assert_eq!(map.get(key), Ok(i as i32));
        }
        assert_eq!(double_set(&map.keys), double_map(&map.keys, &map.values).0);
    }

    #[test]
    fn random_keys_are_found_in_tables_of_any_size() {
        let random = random_pairs(6000);
        for keys in random.chunks(60) {
            // Few different low bits, so that keys collide and runs wrap round the table's end.
            let narrow = |x: u64| if x & 7 == 0 { x | 15 } else { 1 + x % 40 };
            let mut map = KeyMap::new(4);
            let mut known = std::collections::HashMap::new();
            for key in keys.iter().map(|key| key.map(narrow)) {
                let value = known.len() as i32;
                match map.get(key) {
                    Ok(found) => assert_eq!(known.get(&key), Some(&found)),
                    Err(_) => {
                        if !has_slot(known.len() as i64, map.keys.len()) {
                            map.double();
                        }
                        let slot = map.get(key).expect_err("a key is found that is not there");
                        map.set(slot, key, value);
                        assert_eq!(known.insert(key, value), None);
                    }
                }
            }
            assert!(map.keys.len() as f64 * LOAD >= known.len() as f64);
            let doubled = double_set(&map.keys);
            for (&key, &value) in &known {
                assert_eq!(map.get(key), Ok(value));
                assert!(find(&doubled, key).is_ok());
            }
            for set in [&map.keys[..], &doubled] {
                assert_eq!(
                    set.iter().filter(|&&key| key != [0, 0]).count(),
                    known.len()
                );
            }
        }
    }

    #[test]
    fn hashes_of_random_lists_differ() {
        let random = random_pairs(2000);
        let symbols = |key: Key| (0..key[1] % 8).map(move |k| (key[0] >> (8 * k)) as u16 % 1000);
        let lists: std::collections::HashSet<Vec<u16>> =
            random.iter().map(|&key| symbols(key).collect()).collect();
        let hashes: std::collections::HashSet<Key> =
            lists.iter().map(|list| hash_symbols(list)).collect();
        assert_eq!(hashes.len(), lists.len());
    }

    #[test]
    fn hashes_tell_lengths_and_symbols_apart() {
        let lists = [&[][..], &[0_u16], &[0, 0], &[1], &[0, 1], &[1, 0]];
        for (i, a) in lists.iter().enumerate() {
            for b in &lists[..i] {
                assert_ne!(hash_symbols(a), hash_symbols(b));
            }
        }
        assert_eq!(hash_symbols(&[7_u16, 9]), hash_symbols(&[7_u8, 9]));
    }
}
