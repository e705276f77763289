//! Forward kinematics.

use model::{CoordinateId, LinkId, Pose, Robot};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::drive::{Drive, Source, parent_from_child};

/// Pose of the tree's root in the world; `q` lists all coordinates, or at least the base's.
pub(crate) fn world_from_root(robot: &Robot, q: &[f64]) -> Pose {
    if robot.base.is_none() {
        return robot.world_from_base;
    }
    let base_from_root = Isometry3::from_parts(
        Translation3::new(q[0], q[1], 0.0),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q[2]),
    );
    robot.world_from_base * base_from_root
}

/// Poses of all links in the world, indexed by [`LinkId`].
///
/// `q` holds one value per coordinate (m or rad); `opening` is the gap between the fingers (m).
#[must_use]
pub fn link_poses(robot: &Robot, q: &[f64], opening: f64) -> Vec<Pose> {
    let mut poses = Vec::with_capacity(robot.links.len());
    link_poses_into(robot, q, opening, &mut poses);
    poses
}

/// As [`link_poses`], into a list that is kept from call to call: only the first call allocates.
pub fn link_poses_into(robot: &Robot, q: &[f64], opening: f64, poses: &mut Vec<Pose>) {
    poses.clear();
    poses.resize(robot.links.len(), Pose::identity());
    if let Some(root) = poses.first_mut() {
        *root = world_from_root(robot, q);
    }
    for joint in &robot.joints {
        let value = Drive::of(robot, joint).value(q, opening);
        poses[joint.child.index()] = poses[joint.parent.index()] * parent_from_child(joint, value);
    }
}

/// Pose of one link in the world with the hand fully open; only the joints on its chain are looked at.
#[must_use]
pub fn link_pose(robot: &Robot, q: &[f64], link: LinkId) -> Pose {
    match robot.joint_of_link(link) {
        None => world_from_root(robot, q),
        Some(joint) => {
            let joint = &robot.joints[joint.index()];
            let value = Drive::of(robot, joint).value(q, robot.end_effector.max_opening);
            link_pose(robot, q, joint.parent) * parent_from_child(joint, value)
        }
    }
}

/// Positions in `Robot::joints` of the joints between the root and `link`, the root's first.
pub(crate) fn joints_to(robot: &Robot, link: LinkId) -> Vec<usize> {
    let mut joints: Vec<usize> = std::iter::successors(robot.joint_of_link(link), |joint| {
        robot.joint_of_link(robot.joints[joint.index()].parent)
    })
    .map(model::JointId::index)
    .collect();
    joints.reverse();
    joints
}

/// Coordinates that move `link`, from the root outwards, the planar base's first; each once.
#[must_use]
pub fn chain(robot: &Robot, link: LinkId) -> Vec<CoordinateId> {
    let mut coordinates: Vec<CoordinateId> = (0..robot.base_len()).map(CoordinateId::at).collect();
    for joint in joints_to(robot, link) {
        if let Source::Coordinate(id) = Drive::of(robot, &robot.joints[joint]).source
            && !coordinates.contains(&id)
        {
            coordinates.push(id);
        }
    }
    coordinates
}
