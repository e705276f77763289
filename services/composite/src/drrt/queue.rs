//! Entries of priority queues with total, deterministic order.

use std::cmp::Ordering;

/// Least key first in a `BinaryHeap`; equal keys: least item first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<T> {
    pub key: f64,
    pub item: T,
}

impl<T: Ord> Entry<T> {
    pub fn new(key: f64, item: T) -> Self {
        Self { key, item }
    }
}

impl<T: Ord> Ord for Entry<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        other.key.total_cmp(&self.key).then_with(|| other.item.cmp(&self.item))
    }
}

impl<T: Ord> PartialOrd for Entry<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T: Ord> PartialEq for Entry<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T: Ord> Eq for Entry<T> {}
