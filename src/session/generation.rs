//! Which session, and which model: a number that no other has while the program runs.

use std::sync::atomic::{AtomicU64, Ordering};

/// A number that is given once and grows: the later of two is the larger. Unlike an address, it is never used again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Generation(u64);

impl Generation {
    /// One that nothing has yet.
    pub fn next() -> Self {
        static NEWEST: AtomicU64 = AtomicU64::new(0);
        Generation(NEWEST.fetch_add(1, Ordering::Relaxed) + 1)
    }
}

impl Default for Generation {
    /// The same as [`Generation::next`]: what is made anew is something new.
    fn default() -> Self {
        Generation::next()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn none_is_given_twice() {
        let threads = (0..4).map(|_| std::thread::spawn(|| (0..1000).map(|_| Generation::next()).collect::<Vec<_>>()));
        let threads: Vec<_> = threads.collect();
        let mut all: Vec<Generation> = threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 4000);
    }
}
