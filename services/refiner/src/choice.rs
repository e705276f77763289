//! Alternatives of one pair: which are left, which is chosen, what the loss of the others depends on.

use contract::Alternative;

use crate::conflict::Conflict;

/// The alternatives of one pair.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairChoice {
    /// Alternatives not excluded by poses, in the order in which they are tried.
    list: Vec<Alternative>,
    /// The chosen one.
    at: usize,
    /// Why alternatives were excluded or given up.
    conflict: Conflict,
    /// How often an alternative was given up.
    pub(crate) revisions: u32,
}

impl PairChoice {
    /// The chosen alternative.
    pub(crate) fn chosen(&self) -> Option<&Alternative> {
        self.list.get(self.at)
    }

    /// Alternatives that are left, the chosen one first.
    pub(crate) fn left(&self) -> &[Alternative] {
        self.list.get(self.at..).unwrap_or_default()
    }

    /// Keeps only these alternatives, in this order; what was dropped fell to `conflict`.
    pub(crate) fn keep(&mut self, list: Vec<Alternative>, conflict: Conflict) {
        (self.list, self.at) = (list, 0);
        self.conflict.merge(conflict);
    }

    /// Why alternatives were excluded or given up.
    pub(crate) fn why_fewer(&self) -> Conflict {
        self.conflict.clone()
    }

    /// Gives up the chosen alternative because of a conflict; the next one, or the conflict of them all.
    pub(crate) fn give_up(&mut self, conflict: Conflict) -> Result<&Alternative, Conflict> {
        self.revisions += 1;
        self.conflict.merge(conflict);
        self.at += 1;
        self.list.get(self.at).ok_or_else(|| self.conflict.clone())
    }

    /// Leaves the chosen alternative for the next one, which may be taken back; whether there is one.
    pub(crate) fn step(&mut self) -> bool {
        let more = self.at + 1 < self.list.len();
        self.at += usize::from(more);
        more
    }

    /// The position of the chosen alternative, for [`PairChoice::take_back`].
    pub(crate) fn position(&self) -> usize {
        self.at
    }

    /// Chooses an earlier alternative again.
    pub(crate) fn take_back(&mut self, position: usize) {
        self.at = position.min(self.at);
    }

    /// Every alternative of `list` is open again: a choice they were given up for has changed.
    pub(crate) fn reopen(&mut self, list: Vec<Alternative>) {
        let revisions = self.revisions;
        *self = Self { list, revisions, ..Self::default() };
    }
}
