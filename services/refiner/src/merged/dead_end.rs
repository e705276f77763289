//! What a failure depends on, where hops are placed one after the other.

use std::collections::BTreeSet;

use plan::Cause;

/// Hops of which at least one must be placed elsewhere or ordered otherwise.
#[derive(Debug, Default)]
pub(crate) struct DeadEnd {
    /// Their positions in the sequence.
    pub(crate) hops: BTreeSet<usize>,
    /// The last cause met.
    pub(crate) cause: Option<Cause>,
}

impl DeadEnd {
    /// Takes over what another one depends on.
    pub(crate) fn merge(&mut self, other: Self) {
        self.hops.extend(other.hops);
        self.cause = other.cause.or(self.cause.take());
    }
}
