//! Grasps.

use serde::{Deserialize, Serialize};

use crate::Pose;

/// One way to hold an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grasp {
    /// Takes the object's frame to the frame of the end effector's parent link.
    pub link_from_object: Pose,
    /// Opening between the fingers while holding (m).
    pub opening: f64,
    /// Unit direction in the parent link's frame along which the hand approaches the object.
    pub approach: [f64; 3],
    /// Family it comes from, for messages.
    pub family: GraspFamily,
}

/// Where a grasp comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum GraspFamily {
    /// Horizontal approach: 4 yaws × 2 flips × 3 heights.
    Side,
    /// From above: 4 yaws.
    Top,
    /// Listed in the problem file.
    Listed,
}
