//! Roadmaps: pieces against fixed objects, and the glued, reversible roadmap of a mode.

use model::{AllowedContacts, Configuration, Holding, RobotId};
use serde::{Deserialize, Serialize};
use skeleton::{ModeId, Occupancy};

/// A vertex: index into a roadmap's vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct VertexId(pub u32);

impl VertexId {
    /// The vertex at `index`.
    #[must_use]
    pub fn at(index: usize) -> Self {
        Self(u32::try_from(index).unwrap_or(u32::MAX))
    }

    /// The index.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Which part of the robot an edge moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum EdgeKind {
    /// The base drives, the arm is folded.
    Base,
    /// The arm moves, the base stands.
    Arm,
}

/// A straight motion in configuration space between two vertices, usable both ways; unbounded coordinates (yaw) go the
/// short way round, see `model::Robot::short_way`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Edge {
    /// One end.
    pub a: VertexId,
    /// The other end.
    pub b: VertexId,
    /// What moves.
    pub kind: EdgeKind,
    /// Contacts that are no collision on it.
    pub allowed: AllowedContacts,
    /// Least time to travel it (s).
    pub duration_s: f64,
    /// Indices into [`ModeRoadmap::possible`] of the poses that block it, ascending; empty in a piece.
    pub blockers: Vec<u32>,
}

/// A roadmap valid against the robot itself and the fixed objects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoadmapPiece {
    /// Robot.
    pub robot: RobotId,
    /// What it holds throughout.
    pub holding: Option<Holding>,
    /// Configurations; of an arm piece, vertex 0 is the drive configuration at its stand and vertex 1 the configuration
    /// at the object; of a base piece, vertex 0 is the robot's start stand.
    pub vertices: Vec<Configuration>,
    /// Edges.
    pub edges: Vec<Edge>,
}

/// The glued roadmap of one mode, valid against itself, fixed objects and poses that are certainly present.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModeRoadmap {
    /// Mode.
    pub mode: ModeId,
    /// What the robot holds throughout.
    pub holding: Option<Holding>,
    /// Configurations. An edge is the straight motion to `Robot::short_way(from, to)`: unbounded coordinates (yaw) go
    /// the short way round, so a path's configurations are vertices' up to whole turns of those coordinates.
    pub vertices: Vec<Configuration>,
    /// Edges, annotated with the possible poses that block them.
    pub edges: Vec<Edge>,
    /// Where the mode begins.
    pub start: VertexId,
    /// Where the event that ends the mode happens (of a closing return, the end configuration).
    pub goal: VertexId,
    /// Vertices at which the robot may wait out of the way, best first.
    pub parking: Vec<VertexId>,
    /// Poses that may be present during the mode; `Edge::blockers` are indices into it.
    pub possible: Vec<Occupancy>,
    /// Least time from each vertex to the goal, possible poses ignored (s); infinite where there is no way.
    pub cost_to_go_s: Vec<f64>,
}
