//! Makespan, bound, and what a plan was made from.

use serde::{Deserialize, Serialize};

/// When things are over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Makespan {
    /// Latest `done` point of any pair: arm home after the last release (s).
    pub task_s: f64,
    /// Last knot of any robot, closing returns included (s).
    pub total_s: f64,
}

/// A lower bound on `makespan.task_s`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LowerBound {
    /// Seconds.
    pub seconds: f64,
    /// What is held fixed in the bound, e.g. `assignment-roadmap`.
    pub kind: String,
}

/// What a plan was made from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Digest of the resolved problem (hex).
    pub problem_digest: String,
    /// Seed.
    pub seed: u64,
    /// Stage implementations, `stage implementation/version`, in stage order.
    pub implementations: Vec<String>,
    /// Digest of the committed ledger (hex).
    pub ledger_digest: String,
}
