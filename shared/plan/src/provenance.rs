//! Makespan, bound, and what a plan was made from.

use std::collections::BTreeMap;
use std::num::NonZeroU64;

use model::FailurePolicy;
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
    /// How it was searched for; absent if by the defaults.
    #[serde(default, skip_serializing_if = "SearchRecord::is_default")]
    pub search: SearchRecord,
    /// Digest of the committed ledger (hex).
    pub ledger_digest: String,
}

/// How a plan was searched for, so far as that was not the default: with problem and seed, all that the result depends on.
/// Wherever it was said: in the problem, in the launch file, on the command line. Limits on time change no plan and are not here.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SearchRecord {
    /// How composite motion was searched for, a name that `--composite` takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub composite: Option<String>,
    /// Which steps were done as one, a name that `--merge` takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub merge: Option<String>,
    /// What failures led to, by stage.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub policy: BTreeMap<String, FailurePolicy>,
    /// Work units after which the run would have ended, by stage, or of `drrt`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub limit: BTreeMap<String, NonZeroU64>,
    /// Placement candidates refined at one level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub candidates: Option<u32>,
    /// Failures of composite motion after which a placement candidate was given up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub composite_failures: Option<u32>,
}

impl SearchRecord {
    /// Whether nothing differs from the defaults.
    #[must_use]
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
