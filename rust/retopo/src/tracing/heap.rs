//! Numbers in a heap by key, for searches that visit the nearest first.
//!
//! Not [`std::collections::BinaryHeap`], which takes the other of two equal keys: on regular meshes
//! many are equal, and results would not stay what they are, bit for bit.

/// Items by key, the least key first. The order of equal keys is a fixed one.
#[derive(Clone, Debug, Default)]
pub struct Heap {
    entries: Vec<(f64, i32)>,
}

impl Heap {
    /// Return an empty heap.
    pub fn new() -> Heap {
        Heap::default()
    }

    /// Put an item in.
    #[inline]
    pub fn push(&mut self, key: f64, item: i32) {
        let mut at = self.entries.len();
        self.entries.push((key, item));
        let entries = &mut self.entries[..];
        while at > 0 {
            let above = (at - 1) / 2;
            if entries[above].0 <= key {
                break;
            }
            entries[at] = entries[above];
            at = above;
        }
        entries[at] = (key, item);
    }

    /// Take the least key and its item out; None where the heap is empty.
    #[inline]
    pub fn pop(&mut self) -> Option<(f64, i32)> {
        let last = self.entries.pop()?;
        let entries = &mut self.entries[..];
        let Some(&least) = entries.first() else {
            return Some(last);
        };
        let mut at = 0;
        loop {
            let mut below = 2 * at + 1;
            if below >= entries.len() {
                break;
            }
            if below + 1 < entries.len() && entries[below + 1].0 < entries[below].0 {
                below += 1;
            }
            if entries[below].0 >= last.0 {
                break;
            }
            entries[at] = entries[below];
            at = below;
        }
        entries[at] = last;
        Some(least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_come_out_in_order() {
        let mut heap = Heap::new();
        for item in 0..50 {
            heap.push(f64::from(item * 37 % 50), item);
        }
        let keys: Vec<f64> = std::iter::from_fn(|| heap.pop())
            .map(|(key, _)| key)
            .collect();
        assert!(keys.is_sorted());
        assert_eq!(keys.len(), 50);
    }

    #[test]
    fn equal_keys_have_a_fixed_order() {
        let mut heap = Heap::new();
        for item in 0..5 {
            heap.push(1.0, item);
        }
        let items: Vec<i32> = std::iter::from_fn(|| heap.pop())
            .map(|(_, item)| item)
            .collect();
        assert_eq!(items, [0, 4, 3, 2, 1]);
    }
}
