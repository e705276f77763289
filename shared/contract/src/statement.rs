//! The statement that every process of a run works from.

use std::collections::BTreeMap;

use model::Problem;
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
}

/// What the search does with failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SearchOptions {
    /// Learn from the causes of failures which placements cannot be kept together (the paper's backtracking with cause).
    pub causes: bool,
    /// Placement candidates refined at one level before the next level is tried.
    pub candidates: u32,
    /// Failures of composite motion of one placement candidate after which it is given up.
    pub composite_failures: u32,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self { causes: true, candidates: 64, composite_failures: 12 }
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
    /// A statement with this program's own stages.
    #[must_use]
    pub fn new(problem: Problem, seed: u64, composite: CompositeMethod) -> Self {
        Self {
            problem,
            seed,
            composite,
            options: SearchOptions::default(),
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
