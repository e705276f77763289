//! What the search has committed to, in program order.

use model::PairId;
use plan::Cause;
use serde::{Deserialize, Serialize};
use skeleton::{Event, ModeId};

use crate::{Digest, DiscoveredOrder, JobId, Nogood, RoundChoice, StageKind, WorkKind, encode_canonical};

/// A decision of the search.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Decision {
    /// Sample level.
    Level(u32),
    /// Placement candidate, by its index at the present level.
    Placement(u32),
    /// Alternative of a pair.
    Alternative {
        /// Pair.
        pair: PairId,
        /// Index.
        index: u32,
    },
    /// An ordering is added because a pose would be in the way of a mode.
    Order(DiscoveredOrder),
    /// A mode is committed by the composite stage.
    Commit(ModeId),
    /// The rest is left to the composite search.
    Drrt,
    /// A stage that has failed is asked again with so many times as many samples.
    More {
        /// Stage.
        stage: StageKind,
        /// How many times.
        times: u32,
    },
    /// The hop of a pair is placed, where steps are merged.
    Hop {
        /// Pair.
        pair: PairId,
        /// Sample.
        sample: u32,
        /// Orderings added for it.
        orders: Vec<(Event, Event)>,
    },
    /// All modes are left to the planner of synchronous schedules.
    Synchronous(RoundChoice),
    /// Modes of the next round of a synchronous schedule.
    Round(Vec<ModeId>),
    /// A mode that cannot be committed, and the robots in its way, are planned together.
    Repair(ModeId),
}

/// One line of the committed log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LedgerEntry {
    /// A decision was taken.
    Decided(Decision),
    /// An outcome was used.
    Used {
        /// Job.
        job: JobId,
        /// Digest of the outcome.
        outcome: Digest,
    },
    /// A nogood was learnt.
    Learnt(Nogood),
    /// A decision of a stage is revised: the backtrack request.
    Backtrack {
        /// Stage whose decision is revised.
        stage: StageKind,
        /// Decision.
        decision: Decision,
        /// Why.
        because: Option<Cause>,
    },
    /// A plan was committed.
    Solved {
        /// Digest of the plan's product.
        plan: Digest,
    },
    /// The run ends: a stage has failed whose policy is to stop.
    Stopped {
        /// Stage.
        stage: StageKind,
    },
    /// The run ends: a limit on work is exceeded.
    LimitReached {
        /// Limited work.
        work: WorkKind,
        /// Work units spent.
        spent: u64,
    },
}

/// The committed log. Two runs of one statement have equal ledgers, or one is a prefix of the other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Entries in program order.
    pub entries: Vec<LedgerEntry>,
}

impl Ledger {
    /// Appends an entry.
    pub fn commit(&mut self, entry: LedgerEntry) {
        self.entries.push(entry);
    }

    /// Digest of all entries.
    #[must_use]
    pub fn digest(&self) -> Digest {
        Digest::of("mrtamp ledger", &[&encode_canonical(self)])
    }
}
