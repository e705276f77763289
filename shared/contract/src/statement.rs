//! The statement that every process of a run works from.

use std::collections::BTreeMap;

use model::{FailurePolicy, Policies, Problem, SearchSettings, WorkLimits};
use serde::{Deserialize, Serialize};

use crate::{Digest, StageKind, encode_canonical};

/// How composite motion is searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CompositeMethod {
    /// Mode by mode with safe tails; multi-modal dRRT* where that fails.
    #[default]
    Prioritised,
    /// Multi-modal dRRT* alone.
    Drrt,
    /// In rounds, for comparison: in each one as many robots as can do a whole mode, all wait for the slowest.
    SyncGreedy,
    /// In rounds, for comparison: the shortest sequence of rounds.
    SyncOpt,
    /// The shorter of `Prioritised` and the motion of `SyncOpt` without its waits.
    Shorter,
}

/// Which of the paper's steps are done as one, hop by hop: its ablations (Sec. IV).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Merge {
    /// None: all hops are placed before anything else is asked.
    #[default]
    None,
    /// Placement and transition (MERGE 1&2): alternatives of a hop's pair are asked before the next hop is placed.
    PlacementAndTransition,
    /// Placement to roadmap (MERGE 1–3): its roadmaps, too.
    PlacementToRoadmap,
}

/// What the search does with failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SearchOptions {
    /// What each stage's failures lead to.
    pub policies: Policies,
    /// Work units after which the run ends.
    pub limits: WorkLimits,
    /// Placement candidates refined at one level before the next level is tried.
    pub candidates: u32,
    /// Failures of composite motion of one placement candidate after which it is given up.
    pub composite_failures: u32,
    /// Which steps are done as one.
    pub merge: Merge,
}

impl Default for SearchOptions {
    fn default() -> Self {
        let (policies, limits) = (Policies::default(), WorkLimits::default());
        Self { policies, limits, candidates: 256, composite_failures: 12, merge: Merge::None }
    }
}

impl SearchOptions {
    /// The options that settings ask for.
    #[must_use]
    pub fn of(settings: &SearchSettings) -> Self {
        Self { policies: settings.policy, limits: settings.limit, ..Self::default() }
    }

    /// What a stage's failures lead to.
    #[must_use]
    pub fn policy(&self, stage: StageKind) -> FailurePolicy {
        let policy = match stage {
            StageKind::Placement => self.policies.placement,
            StageKind::Transition => self.policies.transition,
            StageKind::Roadmap => self.policies.roadmap,
            StageKind::Composite => self.policies.composite,
        };
        policy.unwrap_or_default()
    }

    /// Work units that may be spent in all; none: any number.
    #[must_use]
    pub fn limit(&self, work: WorkKind) -> Option<u64> {
        let limit = match work {
            WorkKind::Stage(StageKind::Placement) => self.limits.placement,
            WorkKind::Stage(StageKind::Transition) => self.limits.transition,
            WorkKind::Stage(StageKind::Roadmap) => self.limits.roadmap,
            WorkKind::Stage(StageKind::Composite) => self.limits.composite,
            WorkKind::Drrt => self.limits.drrt,
        };
        limit.map(std::num::NonZeroU64::get)
    }
}

/// Work that may be limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum WorkKind {
    /// Of a stage.
    Stage(StageKind),
    /// Of dRRT*, which counts as the composite stage's, too.
    Drrt,
}

impl std::fmt::Display for WorkKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Stage(stage) => stage.fmt(f),
            Self::Drrt => f.write_str("drrt"),
        }
    }
}

/// Problem, seed and the implementation of each stage. Self-contained: geometry, no paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProblemStatement {
    /// Problem.
    pub problem: Problem,
    /// Seed of all random values.
    pub seed: u64,
    /// How composite motion is searched for.
    pub composite: CompositeMethod,
    /// What the search does with failures.
    pub options: SearchOptions,
    /// `name/version` of each stage's implementation, as its worker said in its Hello.
    pub implementations: BTreeMap<StageKind, String>,
}

impl ProblemStatement {
    /// A statement with this program's own stages, and the options that the problem asks for.
    #[must_use]
    pub fn new(problem: Problem, seed: u64, composite: CompositeMethod) -> Self {
        let options = SearchOptions::of(&problem.search);
        Self {
            problem,
            seed,
            composite,
            options,
            implementations: StageKind::ALL.map(|stage| (stage, Self::own_implementation(stage))).into(),
        }
    }

    /// What this program's own worker of a stage says it is.
    #[must_use]
    pub fn own_implementation(stage: StageKind) -> String {
        format!("mrtamp-{stage}/{}", env!("CARGO_PKG_VERSION"))
    }

    /// Implementation of a stage; empty if none has said Hello.
    #[must_use]
    pub fn implementation(&self, stage: StageKind) -> &str {
        self.implementations.get(&stage).map_or("", String::as_str)
    }

    /// Digest of the problem alone.
    #[must_use]
    pub fn problem_digest(&self) -> Digest {
        Digest::of("mrtamp problem", &[&encode_canonical(&self.problem)])
    }
}
