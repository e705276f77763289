//! What the search asks of geometry, so that it can be tested without any.

use contract::{Move, VertexId};
use model::Holding;
use skeleton::{ModeId, Occupancy};

/// One robot's part of a composite edge, named: along an edge of its mode's roadmap, or (no edge) standing at a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RobotEdge {
    /// Whose, and in which mode.
    pub mode: ModeId,
    /// Index of the edge in the mode's roadmap; standing has none.
    pub edge: Option<u32>,
    /// Where it begins.
    pub from: VertexId,
    /// Where it ends.
    pub to: VertexId,
}

/// The same as motion; `travel` begins at 0 s.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedEdge {
    /// Name.
    pub edge: RobotEdge,
    /// What the robot holds all the way.
    pub holding: Option<Holding>,
    /// Straight motion; of a standing robot both ends are equal and it takes no time.
    pub travel: Move,
}

/// Geometry as the composite search sees it. Answers must not depend on the names: equal motions of a robot in different
/// modes are asked about once.
pub trait CompositeValidity {
    /// Whether two robots come too close when they set out at the same time, each at its own pace, and then stand at the
    /// ends of their edges for ever.
    fn edges_conflict(&self, a: &TimedEdge, b: &TimedEdge) -> bool;

    /// Whether a standing robot, or its load, is too close to an object that stands at one of its poses.
    fn stand_hits(&self, stand: &TimedEdge, occupancy: Occupancy) -> bool;
}
