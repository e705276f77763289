//! What a robot holds, what may touch, and what stands where.

use serde::{Deserialize, Serialize};

use crate::{FixedId, GraspId, ObjectId, Pose};

/// An object in a hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Holding {
    /// What is held.
    pub object: ObjectId,
    /// How: index into the object's grasps for the robot.
    pub grasp: GraspId,
}

/// Contacts that are no collision on a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct AllowedContacts {
    /// Standing object that the end effector's links may touch: while approaching or backing off.
    pub touch: Option<ObjectId>,
    /// Fixed object whose surface the held object may touch from above: while lifting or lowering.
    pub support: Option<FixedId>,
}

/// A movable object standing at a pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// Object.
    pub object: ObjectId,
    /// Where.
    pub world_from_object: Pose,
}
