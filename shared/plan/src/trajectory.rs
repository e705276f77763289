//! Trajectories and events.

use model::Pose;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};
use skeleton::ModeKind;

/// One robot's motion: linear in q between knots; before the first and after the last knot the robot stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotTrajectory {
    /// Robot name.
    pub name: String,
    /// Coordinate names: URDF joints, or `<virtual joint>/x`, `/y`, `/yaw`.
    pub joints: Vec<String>,
    /// Knots with strictly increasing times.
    pub knots: Vec<Knot>,
    /// What the robot is doing, covering all knots without gaps.
    pub segments: Vec<Segment>,
}

/// A configuration at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Knot {
    /// Time (s).
    pub t: f64,
    /// One value per joint (m or rad; angles unwrapped).
    pub q: Vec<f64>,
}

/// A stretch of knots `from..=to` that belong to one part of a mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// First knot.
    pub from: usize,
    /// Last knot; the next segment's first.
    pub to: usize,
    /// Pair name; absent in a closing return.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pair: Option<String>,
    /// Mode.
    pub mode: ModeKind,
    /// Kind of motion.
    pub kind: SegmentKind,
}

/// Kind of motion in a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SegmentKind {
    /// The base drives.
    Base,
    /// The arm goes to a grasp or a placement.
    Reach,
    /// The arm comes back from a grasp or a placement.
    Retract,
    /// The robot stands.
    Wait,
}

/// An object is attached to, or detached from, a hand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// Time (s); equals the time of `knot`.
    pub t: f64,
    /// What happens.
    pub kind: EventKind,
    /// Robot name.
    pub robot: String,
    /// The robot's knot at which it happens.
    pub knot: usize,
    /// Pair name.
    pub pair: String,
    /// Object name.
    pub object: String,
    /// Link that holds.
    pub link: String,
    /// Takes the object's frame to the link's while held.
    pub link_from_object: PoseRecord,
    /// Where the object stands just before an attach or just after a detach.
    pub world_from_object: PoseRecord,
    /// Opening between the fingers while held (m).
    pub opening: f64,
}

/// Kind of event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// The hand takes the object.
    Attach,
    /// The hand lets the object stand.
    Detach,
}

/// A pose as written in files: m, unit quaternion x y z w.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoseRecord {
    /// Translation (m).
    pub xyz: [f64; 3],
    /// Unit quaternion.
    pub quat_xyzw: [f64; 4],
}

impl From<Pose> for PoseRecord {
    fn from(pose: Pose) -> Self {
        let (t, q) = (pose.translation.vector, pose.rotation.coords);
        Self { xyz: [t.x, t.y, t.z], quat_xyzw: [q.x, q.y, q.z, q.w] }
    }
}

impl From<PoseRecord> for Pose {
    /// Exact copy of the numbers: the quaternion is not normalised again.
    fn from(record: PoseRecord) -> Self {
        let [x, y, z, w] = record.quat_xyzw;
        let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        let [x, y, z] = record.xyz;
        Isometry3::from_parts(Translation3::new(x, y, z), rotation)
    }
}
