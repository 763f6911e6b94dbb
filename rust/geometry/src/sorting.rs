//! Sorting by keys, with one fixed order of equal keys.
//!
//! Which of two triangles of equal keys comes first decides in which box each lies, and so the order
//! of results. The order is that of one quicksort, which databases and pictures made before depend
//! on; a stable sort would give another.

/// The most items that are sorted by insertion.
const SMALL: usize = 15;

/// Return the order that sorts the keys, NaN last.
///
/// Quicksort with the median of three as its pivot (Sedgewick 1978, "Implementing Quicksort
/// programs").
pub fn argsort(keys: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..keys.len()).collect();
    if keys.len() < 2 {
        return order;
    }
    let mut ranges = vec![(0, keys.len() - 1)];
    while let Some((mut low, mut high)) = ranges.pop() {
        // The larger part waits, so that few do. Both ends belong to a range.
        while high >= low + SMALL {
            let pivot = partition(keys, &mut order, low, high);
            if high - pivot > pivot - low {
                ranges.push((pivot + 1, high));
                if pivot == low {
                    // Nothing is below the pivot.
                    high = low;
                    break;
                }
                high = pivot - 1;
            } else {
                ranges.push((low, pivot - 1));
                low = pivot + 1;
            }
        }
        if high > low {
            insertion_sort(keys, &mut order[low..=high]);
        }
    }
    order
}

fn is_less(a: f64, b: f64) -> bool {
    a < b || (b.is_nan() && !a.is_nan())
}

fn insertion_sort(keys: &[f64], order: &mut [usize]) {
    for i in 1..order.len() {
        let item = order[i];
        let mut j = i;
        while j > 0 && is_less(keys[item], keys[order[j - 1]]) {
            order[j] = order[j - 1];
            j -= 1;
        }
        order[j] = item;
    }
}

/// Move items of lower keys before a pivot, others behind it; return its place.
fn partition(keys: &[f64], order: &mut [usize], low: usize, high: usize) -> usize {
    let middle = (low + high) / 2;
    let key = |order: &[usize], at: usize| keys[order[at]];
    for (one, other) in [(low, middle), (middle, high), (low, middle)] {
        if is_less(key(order, other), key(order, one)) {
            order.swap(one, other);
        }
    }
    let pivot = key(order, middle);
    order.swap(high, middle);
    let mut i = low;
    // One more than the place that is looked at from above, which may be one below `low`.
    let mut j = high;
    loop {
        while i < high && is_less(key(order, i), pivot) {
            i += 1;
        }
        while j > low && is_less(pivot, key(order, j - 1)) {
            j -= 1;
        }
        if i + 1 >= j {
            break;
        }
        order.swap(i, j - 1);
        i += 1;
        j -= 1;
    }
    order.swap(i, high);
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keys that repeat, from a linear congruence.
    fn keys(n: usize, different: u64) -> Vec<f64> {
        let mut state = 1u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 33) % different) as f64
        };
        (0..n).map(|_| next()).collect()
    }

    #[test]
    fn keys_ascend_in_the_order_returned() {
        for n in [0, 1, 2, 15, 16, 17, 100, 1000] {
            for different in [1, 2, 7, 1 << 20] {
                let keys = keys(n, different);
                let order = argsort(&keys);
                assert!(order.is_sorted_by(|&a, &b| keys[a] <= keys[b]));
                let mut each = order.clone();
                each.sort_unstable();
                assert!(each.into_iter().eq(0..n));
            }
        }
    }

    #[test]
    fn nan_comes_last() {
        let mut keys = keys(40, 9);
        keys[3] = f64::NAN;
        assert_eq!(argsort(&keys)[39], 3);
    }
}
