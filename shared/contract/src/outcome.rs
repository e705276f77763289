//! Outcomes: answers and failures, with their causes.

use std::collections::BTreeMap;

use model::{PairId, Pose, RobotId};
use plan::{Cause, Certificate};
use serde::{Deserialize, Serialize};
use skeleton::{Event, ModeId, Occupancy};

use crate::{Alternative, HopChoice, JobId, PlacementCandidate, ProductRef};

/// What a stage says to a job. A failed search is an outcome, not an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Answer or failure.
    pub result: Result<Answer, FailureReport>,
    /// Work units spent.
    pub work: u64,
}

/// An answer; the variant belongs to the request's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Answer {
    /// To `Placement`: candidates in canonical order; fewer than asked if the level has no more.
    Placements(Vec<PlacementCandidate>),
    /// To `Transition`: alternatives in canonical order; fewer than asked if the level has no more.
    Alternatives(Vec<Alternative>),
    /// To `Blockers` and `GraspBlockers`: for each standing object, whether it blocks the reach, or every grasp.
    Blocked(Vec<bool>),
    /// To `Piece`.
    Piece(ProductRef),
    /// To `Mode`.
    Mode {
        /// Glued roadmap.
        roadmap: ProductRef,
        /// Least time from start to goal, possible poses ignored (s).
        shortest_s: f64,
        /// Smallest known set of possible poses (indices into the job's list) on one way from the folded arm at the start to
        /// the goal: what in every execution has to be away when the robot comes.
        in_the_way: Vec<u32>,
    },
    /// To `CommitMode` and `Drrt`.
    Committed {
        /// The longer prefix.
        prefix: ProductRef,
        /// When the last committed event happens (s).
        event_s: f64,
        /// When the robot's tail is over (s); for `Drrt`, when all motion is over.
        tail_s: f64,
    },
    /// To `Assemble`.
    Plan {
        /// Bytes of `plan.json`.
        plan: ProductRef,
        /// Makespan of the task (s).
        makespan_s: f64,
    },
    /// To `Hop`.
    Hop {
        /// Choices in canonical order: fewest orderings first, then by sample; fewer than asked if there are no more.
        choices: Vec<HopChoice>,
        /// Poses with which samples of the hop collide: only they, and the orderings that hold, make choices what they are.
        against: Vec<Occupancy>,
        /// What stands in the way of samples that are no choice, most frequent first.
        causes: Vec<(Cause, u64)>,
    },
    /// To `Samples`: numbers and poses (world from object) of those that touch nothing that is always there.
    Samples(Vec<(u32, Pose)>),
    /// To `Synchronous`.
    Rounds {
        /// All modes committed.
        prefix: ProductRef,
        /// Modes of each round, in order of robots.
        rounds: Vec<Vec<ModeId>>,
        /// When the last round is over (s).
        ends_s: f64,
    },
    /// To `Repair`.
    Repaired {
        /// The longer prefix.
        prefix: ProductRef,
        /// The modes that it adds, in order of their events, and when those happen (s).
        modes: Vec<(ModeId, f64)>,
    },
    /// To `Passages`: modes without a passage, each with the robot that is in the way wherever it is; at most one for each
    /// mode.
    NoPassage(Vec<(ModeId, RobotId)>),
}

/// Why a job failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FailureReport {
    /// Causes with how often each was met, most frequent first.
    pub causes: Vec<(Cause, u64)>,
    /// Whether more samples could help.
    pub soundness: Soundness,
    /// A proof that the whole problem has no plan, whatever is chosen elsewhere; only with [`Soundness::Hard`].
    pub certificate: Option<Certificate>,
    /// Choices of which one must change, all else of the job being as it may; `None`: any that the job names.
    pub rests_on: Option<Vec<Choice>>,
}

/// A choice that a failure may rest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Choice {
    /// Where an object stands.
    Pose(Occupancy),
    /// How a pair is done.
    Alternative(PairId),
}

/// How far a failure goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Soundness {
    /// Proven for every sample at every level.
    Hard,
    /// Only for the samples of this level.
    Soft {
        /// Level.
        level: u32,
    },
}

/// One committed choice that a nogood speaks of.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Literal {
    /// A pose of an object is this sample.
    Pose {
        /// Which pose.
        occupancy: Occupancy,
        /// Which sample.
        sample: u32,
    },
    /// A pair is done in this way.
    Alternative {
        /// Pair.
        pair: PairId,
        /// Index in the canonical enumeration.
        index: u32,
    },
    /// An ordering was added.
    Order {
        /// First.
        before: Event,
        /// Later.
        after: Event,
    },
}

/// Choices that cannot all be kept, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Nogood {
    /// Choices.
    pub literals: Vec<Literal>,
    /// Why.
    pub cause: Option<Cause>,
    /// How far it goes.
    pub soundness: Soundness,
    /// The job that showed it.
    pub proof: JobId,
}

/// Counts causes.
#[derive(Clone, Debug, Default)]
pub struct CauseTally(BTreeMap<Cause, u64>);

impl CauseTally {
    /// Counts one more.
    pub fn count(&mut self, cause: Cause) {
        *self.0.entry(cause).or_insert(0) += 1;
    }

    /// Adds the counts of a report.
    pub fn count_all(&mut self, causes: &[(Cause, u64)]) {
        for (cause, times) in causes {
            *self.0.entry(cause.clone()).or_insert(0) += times;
        }
    }

    /// Most frequent first; equal counts in the causes' own order.
    #[must_use]
    pub fn ranked(self) -> Vec<(Cause, u64)> {
        let mut causes: Vec<(Cause, u64)> = self.0.into_iter().collect();
        causes.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        causes
    }
}

impl Outcome {
    /// An answer.
    #[must_use]
    pub fn answer(answer: Answer, work: u64) -> Self {
        Self { result: Ok(answer), work }
    }

    /// A failure at one level.
    #[must_use]
    pub fn soft_failure(causes: CauseTally, level: u32, work: u64) -> Self {
        Self { result: Err(FailureReport::soft(causes, level)), work }
    }

    /// A proof that there is no plan.
    #[must_use]
    pub fn infeasible(causes: CauseTally, certificate: Certificate, work: u64) -> Self {
        Self { result: Err(FailureReport::infeasible(causes, certificate)), work }
    }
}

impl FailureReport {
    /// A failure at one level.
    #[must_use]
    pub fn soft(causes: CauseTally, level: u32) -> Self {
        let soundness = Soundness::Soft { level };
        Self { causes: causes.ranked(), soundness, certificate: None, rests_on: None }
    }

    /// The same, resting on these choices only.
    #[must_use]
    pub fn resting_on(mut self, choices: Vec<Choice>) -> Self {
        self.rests_on = Some(choices);
        self
    }

    /// A proof that there is no plan.
    #[must_use]
    pub fn infeasible(causes: CauseTally, certificate: Certificate) -> Self {
        Self { causes: causes.ranked(), soundness: Soundness::Hard, certificate: Some(certificate), rests_on: None }
    }

    /// The proof that there is no plan, if the report carries one.
    #[must_use]
    pub fn proof(&self) -> Option<&Certificate> {
        self.certificate.as_ref().filter(|_| self.soundness == Soundness::Hard)
    }
}
