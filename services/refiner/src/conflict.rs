//! What a failure rests on: the choices and discovered orderings of which at least one must change.

use std::collections::BTreeSet;

use contract::{AskFault, CauseTally, FailureReport, JobId, WorkKind};
use model::PairId;
use plan::Cause;
use skeleton::Event;

pub(crate) use contract::Choice;

/// A discovered ordering: what happens first, what later.
pub(crate) type Order = (Event, Event);

/// A failure with its causes and what it rests on (Lagriffoul and Andres, doi:10.1177/0278364915625498, call them
/// culprits).
#[derive(Clone, Debug, Default)]
pub(crate) struct Conflict {
    pub(crate) choices: BTreeSet<Choice>,
    /// Discovered orderings without which it might not be.
    pub(crate) orders: BTreeSet<Order>,
    pub(crate) causes: CauseTally,
    /// The job that showed it last.
    pub(crate) proof: Option<JobId>,
}

impl Conflict {
    pub(crate) fn of(choices: impl IntoIterator<Item = Choice>, causes: &[(Cause, u64)], proof: Option<JobId>) -> Self {
        let mut tally = CauseTally::default();
        tally.count_all(causes);
        Self { choices: choices.into_iter().collect(), orders: BTreeSet::new(), causes: tally, proof }
    }

    /// Takes over what another conflict rests on, and its causes.
    pub(crate) fn merge(&mut self, other: Conflict) {
        self.choices.extend(other.choices);
        self.orders.extend(other.orders);
        self.causes.count_all(&other.causes.ranked());
        self.proof = other.proof.or(self.proof);
    }

    /// The pairs whose alternatives it rests on.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = PairId> + '_ {
        self.choices.iter().filter_map(|choice| match choice {
            Choice::Alternative(pair) => Some(*pair),
            Choice::Pose(_) => None,
        })
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
