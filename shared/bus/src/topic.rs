//! Topics, and who reads and writes which.

use contract::StageKind;

use crate::Role;

/// A topic of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// The problem statement: supervisor to all.
    Problem,
    /// Jobs: refiner to the workers of a stage.
    Offer(StageKind),
    /// What became of jobs: workers of a stage to refiner and store.
    Outcome(StageKind),
    /// Products as they are made: workers to later stages and store.
    Product,
    /// Requests for what the store keeps: all to supervisor.
    Want,
    /// What was wanted: supervisor to all.
    Delivery,
    /// Committed revisions of decisions: refiner to observers.
    Backtrack,
    /// Which offers still count: refiner to workers.
    Retirement,
    /// Committed nogoods: refiner to observers.
    Nogood,
    /// The committed log and the end of the search: refiner to supervisor and observers.
    Ledger,
    /// Who is there, alive or gone: all to supervisor and refiner.
    Presence,
    /// The end of the run: supervisor to all.
    Shutdown,
}

impl Topic {
    /// All topics.
    #[must_use]
    pub fn all() -> Vec<Topic> {
        let stages = StageKind::ALL.into_iter().flat_map(|stage| [Topic::Offer(stage), Topic::Outcome(stage)]);
        [Topic::Problem]
            .into_iter()
            .chain(stages)
            .chain([Topic::Product, Topic::Want, Topic::Delivery, Topic::Backtrack, Topic::Retirement])
            .chain([Topic::Nogood, Topic::Ledger, Topic::Presence, Topic::Shutdown])
            .collect()
    }

    /// Name below `mrtamp/<run>/`.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Topic::Problem => "problem".to_owned(),
            Topic::Offer(stage) => format!("{stage}/offer"),
            Topic::Outcome(stage) => format!("{stage}/outcome"),
            Topic::Product => "product".to_owned(),
            Topic::Want => "want".to_owned(),
            Topic::Delivery => "delivery".to_owned(),
            Topic::Backtrack => "backtrack".to_owned(),
            Topic::Retirement => "retirement".to_owned(),
            Topic::Nogood => "nogood".to_owned(),
            Topic::Ledger => "ledger".to_owned(),
            Topic::Presence => "presence".to_owned(),
            Topic::Shutdown => "shutdown".to_owned(),
        }
    }

    /// Whether large bodies travel on it, in parts.
    #[must_use]
    pub fn is_bulky(self) -> bool {
        matches!(self, Topic::Problem | Topic::Product | Topic::Delivery)
    }
}

impl Role {
    /// Topics that a member of this role reads.
    #[must_use]
    pub fn reads(self) -> Vec<Topic> {
        let outcomes = StageKind::ALL.into_iter().map(Topic::Outcome);
        match self {
            Role::Supervisor => outcomes.chain([Topic::Product, Topic::Want, Topic::Presence, Topic::Ledger]).collect(),
            Role::Refiner => {
                outcomes.chain([Topic::Problem, Topic::Delivery, Topic::Presence, Topic::Shutdown]).collect()
            }
            Role::Worker(stage) => {
                let mut topics = vec![Topic::Problem, Topic::Offer(stage), Topic::Retirement, Topic::Shutdown];
                match stage {
                    StageKind::Placement | StageKind::Transition => {}
                    // Pieces stay with their robot's worker; what it lacks it wants.
                    StageKind::Roadmap => topics.push(Topic::Delivery),
                    StageKind::Composite => topics.extend([Topic::Delivery, Topic::Product]),
                }
                topics
            }
        }
    }

    /// Topics that a member of this role writes at every run; others it opens when it first writes to them.
    #[must_use]
    pub fn writes(self) -> Vec<Topic> {
        match self {
            Role::Supervisor => vec![Topic::Problem, Topic::Delivery, Topic::Presence, Topic::Shutdown],
            Role::Refiner => {
                let mut topics: Vec<Topic> = StageKind::ALL.into_iter().map(Topic::Offer).collect();
                topics.extend([Topic::Want, Topic::Ledger, Topic::Presence]);
                topics
            }
            Role::Worker(stage) => vec![Topic::Outcome(stage), Topic::Presence],
        }
    }
}
