//! A robot as a kinematic tree with planned coordinates.

use serde::{Deserialize, Serialize};

use crate::{Body, Configuration, CoordinateId, JointId, LinkId, Pose};

/// One robot of the problem. Links and joints form a tree; `links[0]` is its root.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    /// Unique name.
    pub name: String,
    /// Where the tree's root stands; for a planar base, the frame in which x, y and yaw are measured.
    pub world_from_base: Pose,
    /// Links; `links[0]` is the root.
    pub links: Vec<Link>,
    /// Joints, each after the joint that moves its parent link.
    pub joints: Vec<Joint>,
    /// Planned coordinates. Where there is a planar base, its x, y, yaw are the first three.
    pub coordinates: Vec<Coordinate>,
    /// The holonomic planar base, if the SRDF declares a planar virtual joint.
    pub base: Option<PlanarBase>,
    /// The hand.
    pub end_effector: EndEffector,
    /// Link pairs (smaller first, sorted) that are never tested against each other: adjacent links and the SRDF's.
    pub disabled_pairs: Vec<(LinkId, LinkId)>,
    /// Start configuration, one value per coordinate.
    pub start: Configuration,
    /// Arm coordinates (those after the base) of the group state `home`: how the robot drives empty-handed.
    pub home: Vec<f64>,
    /// Arm coordinates of the group state `carry` (default `home`): how the robot drives while holding.
    pub carry: Vec<f64>,
}

impl Robot {
    /// Number of leading base coordinates: 3 with a planar base, else 0.
    #[must_use]
    pub fn base_len(&self) -> usize {
        if self.base.is_some() { 3 } else { 0 }
    }

    /// The link a joint moves.
    #[must_use]
    pub fn joint_of_link(&self, link: LinkId) -> Option<JointId> {
        self.joints.iter().position(|j| j.child == link).map(JointId::at)
    }

    /// Least time (s) for the straight motion between two configurations within the velocity limits.
    ///
    /// The base obeys its translation speed as a norm and its yaw rate; every other coordinate its own limit.
    #[must_use]
    pub fn duration(&self, from: &[f64], to: &[f64]) -> f64 {
        let mut longest: f64 = 0.0;
        if let Some(base) = &self.base {
            let travelled = (to[0] - from[0]).hypot(to[1] - from[1]);
            longest = (travelled / base.speed).max((to[2] - from[2]).abs() / base.yaw_rate);
        }
        for i in self.base_len()..self.coordinates.len() {
            longest = longest.max((to[i] - from[i]).abs() / self.coordinates[i].velocity);
        }
        longest
    }

    /// `to` with unbounded coordinates (yaw, continuous joints) taken the short way from `from`: each differs from
    /// `from`'s by at most π. Every edge of a roadmap and every [`crate::Robot::duration`] of one means this motion.
    #[must_use]
    pub fn short_way(&self, from: &[f64], to: &[f64]) -> Configuration {
        let turn = std::f64::consts::TAU;
        let short = |i: usize| {
            if self.coordinates[i].upper.is_finite() {
                return to[i];
            }
            to[i] - turn * ((to[i] - from[i]) / turn).round()
        };
        (0..to.len()).map(short).collect()
    }

    /// Whether `link` belongs to the end effector (a touch link).
    #[must_use]
    pub fn is_touch_link(&self, link: LinkId) -> bool {
        self.end_effector.links.contains(&link)
    }
}

/// A rigid link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Name in the URDF.
    pub name: String,
    /// Collision bodies in the link's frame.
    pub bodies: Vec<Body>,
}

/// A joint of the tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Name in the URDF.
    pub name: String,
    /// Parent link.
    pub parent: LinkId,
    /// Child link.
    pub child: LinkId,
    /// Takes the joint frame at zero to the parent link's frame.
    pub parent_from_joint: Pose,
    /// How the child moves in the joint frame.
    pub motion: JointMotion,
    /// Where the joint's value comes from.
    pub value: JointValue,
}

/// How a joint's value moves its child.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum JointMotion {
    /// Rigid.
    Fixed,
    /// Rotation by the value (rad) about a unit axis; also URDF `continuous`.
    Revolute {
        /// Unit axis in the joint frame.
        axis: [f64; 3],
    },
    /// Translation by the value (m) along a unit axis.
    Prismatic {
        /// Unit axis in the joint frame.
        axis: [f64; 3],
    },
}

/// Where a joint's value comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum JointValue {
    /// A planned coordinate.
    Coordinate(CoordinateId),
    /// A finger: `scale` times the opening between the fingers (m).
    Finger {
        /// Joint value per metre of opening (0.5 for each of two opposed prismatic fingers).
        scale: f64,
    },
    /// `multiplier` times another joint's value, plus `offset`.
    Mimic {
        /// The joint that is followed; earlier or later in the list.
        of: JointId,
        /// Factor.
        multiplier: f64,
        /// Added (rad or m).
        offset: f64,
    },
    /// A constant (0 for fixed joints).
    Constant(f64),
}

/// One planned coordinate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coordinate {
    /// URDF joint name; `<virtual joint>/x`, `/y`, `/yaw` for a planar base.
    pub name: String,
    /// Least value (m or rad); `-inf` for yaw and continuous joints.
    pub lower: f64,
    /// Greatest value (m or rad); `+inf` for yaw and continuous joints.
    pub upper: f64,
    /// Greatest speed (m/s or rad/s). For base x and y the norm counts, see [`PlanarBase::speed`].
    pub velocity: f64,
}

/// A holonomic base in the plane. Its coordinates are the first three: x, y (m), yaw (rad, unbounded).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanarBase {
    /// Greatest norm of (ẋ, ẏ) (m/s).
    pub speed: f64,
    /// Greatest |yaw rate| (rad/s).
    pub yaw_rate: f64,
}

/// The hand. Open at `max_opening` while empty, at the grasp's opening while holding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndEffector {
    /// Name in the SRDF.
    pub name: String,
    /// The link that grasps are expressed in (`link_from_object`).
    pub parent_link: LinkId,
    /// Tool frame in the parent link: origin between the fingers, +z the approach axis, y the closing axis.
    pub link_from_tool: Pose,
    /// Links of the end-effector group: those that may touch the object it holds or is about to hold.
    pub links: Vec<LinkId>,
    /// Greatest opening between the fingers (m).
    pub max_opening: f64,
}
