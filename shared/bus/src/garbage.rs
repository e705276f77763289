//! Refused messages, counted by reason.

use std::collections::BTreeMap;

/// Why a message was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Garbage {
    /// Another version of the contract.
    Version,
    /// Another run.
    Run,
    /// No such kind of message.
    Kind,
    /// A kind that does not belong on the topic.
    Topic,
    /// A part whose bytes do not match its checksum or whose numbers contradict one another.
    Damaged,
    /// Parts of a message are missing.
    Torn,
    /// Larger than a message may be.
    TooLarge,
    /// A body that is no message of its kind.
    Body,
    /// A message that contradicts what its receiver knows: unknown sender, wrong identity, wrong answer.
    Claim,
}

/// How often each reason was met.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GarbageTally(BTreeMap<Garbage, u64>);

impl GarbageTally {
    /// Counts one more.
    pub fn count(&mut self, reason: Garbage) {
        *self.0.entry(reason).or_insert(0) += 1;
    }

    /// How often a reason was met.
    #[must_use]
    pub fn of(&self, reason: Garbage) -> u64 {
        self.0.get(&reason).copied().unwrap_or(0)
    }

    /// All reasons met, with their counts.
    pub fn iter(&self) -> impl Iterator<Item = (Garbage, u64)> + '_ {
        self.0.iter().map(|(reason, count)| (*reason, *count))
    }

    /// All together.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.0.values().sum()
    }
}
