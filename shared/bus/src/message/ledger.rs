//! Refiner to supervisor and observers: the committed log.

use contract::{Decision, Job, Ledger, LedgerEntry, StageKind};
use plan::Cause;
use serde::{Deserialize, Serialize};

/// An entry of the committed log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Committed {
    /// Position in the log.
    pub index: u64,
    /// Entry.
    pub entry: LedgerEntry,
}

/// A decision of a stage is revised. Committed in the log; felt upstream as that stage's next job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BacktrackRequest {
    /// Stage whose decision is revised.
    pub stage: StageKind,
    /// Decision.
    pub decision: Decision,
    /// Why.
    pub because: Option<Cause>,
}

/// The search is over. Repeated until the run is shut down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SearchEnd {
    /// The whole log.
    pub ledger: Ledger,
    /// How it ended, encoded by whoever runs the search.
    pub conclusion: Vec<u8>,
    /// Bytes of the plan's product, if there is a plan.
    pub plan: Option<Vec<u8>>,
    /// The job on which workers died again and again, if that is what ended it.
    pub poison: Option<Job>,
}
