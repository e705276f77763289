//! What a failure depends on: the choices of which at least one must change.

use std::collections::BTreeSet;

use contract::{AskFault, CauseTally, FailureReport, JobId, WorkKind};
use model::PairId;
use plan::Cause;
use skeleton::Occupancy;

/// A choice that a failure depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Choice {
    /// Where an object stands.
    Pose(Occupancy),
    /// How a pair is done.
    Alternative(PairId),
}

/// A failure with its causes and the choices it depends on (Lagriffoul and Andres, doi:10.1177/0278364915625498, call
/// them culprits).
#[derive(Clone, Debug, Default)]
pub(crate) struct Conflict {
    pub(crate) choices: BTreeSet<Choice>,
    pub(crate) causes: CauseTally,
    /// The job that showed it last.
    pub(crate) proof: Option<JobId>,
    /// Whether it holds under any orderings: who looked at fixed objects only knows nothing of them.
    pub(crate) under_any_orderings: bool,
}

impl Conflict {
    pub(crate) fn of(choices: impl IntoIterator<Item = Choice>, causes: &[(Cause, u64)], proof: Option<JobId>) -> Self {
        let mut tally = CauseTally::default();
        tally.count_all(causes);
        Self { choices: choices.into_iter().collect(), causes: tally, proof, under_any_orderings: false }
    }

    /// Takes over the choices and causes of another conflict.
    pub(crate) fn merge(&mut self, other: Conflict) {
        self.choices.extend(other.choices);
        self.causes.count_all(&other.causes.ranked());
        self.proof = other.proof.or(self.proof);
        self.under_any_orderings &= other.under_any_orderings;
    }

    /// The pair whose alternative it depends on and that comes last in the order of the search.
    pub(crate) fn last_pair(&self) -> Option<PairId> {
        let pairs = self.choices.iter().filter_map(|choice| match choice {
            Choice::Alternative(pair) => Some(*pair),
            Choice::Pose(_) => None,
        });
        pairs.max()
    }

    pub(crate) fn first_cause(&self) -> Option<Cause> {
        self.causes.clone().ranked().into_iter().next().map(|(cause, _)| cause)
    }
}

/// Why the whole search ends without a plan.
pub(crate) enum Halt {
    /// Asking failed.
    Fault(AskFault),
    /// A stage proves that there is none, whatever is chosen.
    Proven(FailureReport),
    /// A stage has failed whose policy is to stop, for these causes.
    Stopped(Vec<(Cause, u64)>),
    /// More was spent than a limit on work allows.
    LimitReached(WorkKind),
}

impl From<AskFault> for Halt {
    fn from(fault: AskFault) -> Self {
        Self::Fault(fault)
    }
}

/// Why a part of the search has no result.
pub(crate) enum Stuck {
    /// The run ends.
    Halted(Halt),
    /// The choices cannot be completed.
    Failed(Conflict),
}

impl From<AskFault> for Stuck {
    fn from(fault: AskFault) -> Self {
        Self::Halted(fault.into())
    }
}

impl From<Halt> for Stuck {
    fn from(halt: Halt) -> Self {
        Self::Halted(halt)
    }
}
