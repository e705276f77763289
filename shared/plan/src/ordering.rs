//! Orderings between pairs.

use model::Point;
use serde::{Deserialize, Serialize};

use crate::Cause;

/// One strict ordering between two points of pairs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanOrdering {
    /// What comes first.
    pub before: PairPoint,
    /// What comes later.
    pub after: PairPoint,
    /// Where it comes from.
    pub origin: Origin,
    /// Why it is there, if discovered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cause: Option<Cause>,
}

/// A point of a pair.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairPoint {
    /// Pair name.
    pub pair: String,
    /// Point.
    pub point: Point,
}

/// Where an ordering comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// The problem: listed there, or the hops of one object.
    Given,
    /// The geometry.
    Discovered,
}
