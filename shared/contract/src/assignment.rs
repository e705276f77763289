//! Values that the search assigns: placements, orders, alternatives.

use model::{Configuration, FixedId, GraspId, PairId, Pose};
use plan::Cause;
use serde::{Deserialize, Serialize};
use skeleton::Event;

/// A placement chosen for the hop of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// The pair that places.
    pub pair: PairId,
    /// Index of the sample.
    pub sample: u32,
    /// Where the object then stands.
    pub world_from_object: Pose,
}

/// An ordering that the geometry forces.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct DiscoveredOrder {
    /// What must come first.
    pub before: Event,
    /// What must come later.
    pub after: Event,
    /// Why.
    pub cause: Cause,
}

/// One complete answer of the placement stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacementCandidate {
    /// Position in the canonical enumeration.
    pub index: u32,
    /// One placement for every pair, in pair order.
    pub placements: Vec<Placed>,
    /// Orderings it needs beyond the given ones.
    pub orders: Vec<DiscoveredOrder>,
}

/// One way to place one hop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HopChoice {
    /// Placement.
    pub placed: Placed,
    /// Orderings it needs beyond those that hold.
    pub orders: Vec<DiscoveredOrder>,
}

/// How a robot comes to an object at one end of a pair. Configurations have all coordinates, the base's included.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// Base coordinates of the stand; empty for a fixed base.
    pub stand: Vec<f64>,
    /// Configuration with the object in the hand at its standing pose: the transition configuration.
    pub at_object: Configuration,
    /// Empty-handed way from `at_object` back along the approach axis, `at_object` first.
    pub approach: Vec<Configuration>,
    /// Holding way from `at_object` up and then back along the approach axis, `at_object` first.
    pub lift: Vec<Configuration>,
    /// Number of leading motions of `lift` that are the way up, on which the object may touch its support.
    pub lift_up: u32,
    /// What the object stands on.
    pub support: FixedId,
}

/// One way to do a pair: one grasp, and a reach at each end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Alternative {
    /// Position in the canonical enumeration.
    pub index: u32,
    /// Grasp, the same at both ends.
    pub grasp: GraspId,
    /// At the pose the object is taken from.
    pub pick: Reach,
    /// At the pose the object is brought to.
    pub place: Reach,
}

/// What the composite stage must know of the choices so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Assignment {
    /// `poses[object][hop]`: where each object stands after each hop; hop 0 is its start.
    pub poses: Vec<Vec<Pose>>,
    /// Grasp of each pair, in pair order.
    pub grasps: Vec<GraspId>,
    /// Discovered orderings.
    pub orders: Vec<DiscoveredOrder>,
}
