//! The progress of a search, and the request to stop it, as other threads see and make them.

use std::sync::atomic::{AtomicI64, Ordering};

/// Patches between two updates of the shared number: some hundred microseconds of work.
const INTERVAL: i64 = 256;

/// Counts patches in a number that several searches share, and reads the flag that stops them.
pub struct Pulse<'a> {
    stop: &'a AtomicI64,
    met: &'a AtomicI64,
    /// Patches that are not in the shared number yet.
    pending: i64,
}

impl<'a> Pulse<'a> {
    /// Watch `stop`, which stops the search where it is not 0, and raise `met` by the patches met.
    pub fn new(stop: &'a AtomicI64, met: &'a AtomicI64) -> Self {
        let pending = 0;
        Self { stop, met, pending }
    }

    /// Return whether the search has to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed) != 0
    }

    /// Count a patch.
    pub fn count(&mut self) {
        self.pending += 1;
        if self.pending == INTERVAL {
            self.publish();
        }
    }

    fn publish(&mut self) {
        self.met.fetch_add(self.pending, Ordering::Relaxed);
        self.pending = 0;
    }
}

impl Drop for Pulse<'_> {
    fn drop(&mut self) {
        self.publish();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_patches_are_counted_in_the_end() {
        let (stop, met) = (AtomicI64::new(0), AtomicI64::new(5));
        let mut pulse = Pulse::new(&stop, &met);
        for _ in 0..INTERVAL + 1 {
            pulse.count();
        }
        assert_eq!(met.load(Ordering::Relaxed), 5 + INTERVAL);
        assert!(!pulse.is_stopped());
        drop(pulse);
        assert_eq!(met.into_inner(), 6 + INTERVAL);
    }
}
