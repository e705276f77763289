//! Dependency arcs between knots of different robots.

use serde::{Deserialize, Serialize};

/// `after.robot` may leave `after.knot` only once `before.robot` has reached `before.knot`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Dependency {
    /// What must have been reached.
    pub before: KnotRef,
    /// What may only then be left.
    pub after: KnotRef,
}

/// A knot of a robot.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KnotRef {
    /// Robot name.
    pub robot: String,
    /// Index into its knots.
    pub knot: usize,
}
