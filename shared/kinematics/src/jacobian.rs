//! The geometric Jacobian.

use model::{JointMotion, LinkId, Robot};
use nalgebra::{DMatrix, Point3, Vector3};

use crate::drive::{Drive, Source, joint_from_child};
use crate::forward::{joints_to, world_from_root};

/// 6×n geometric Jacobian of a point fixed in `link` (`link_point`, in the link's frame), in the world frame.
///
/// Rows are vx, vy, vz (m/s) and wx, wy, wz (rad/s); columns are the robot's coordinates, zero where one does not move
/// the link. A mimicking joint counts in the column of the coordinate it follows. The hand is fully open.
#[must_use]
pub fn jacobian(robot: &Robot, q: &[f64], link: LinkId, link_point: &Point3<f64>) -> DMatrix<f64> {
    let mut columns = DMatrix::zeros(6, robot.coordinates.len());
    let root = world_from_root(robot, q);
    let mut world_from_link = root;
    // Per moving joint: its column, whether it turns, its axis in the world times its gear, and a point on the axis.
    let mut motions: Vec<(usize, bool, Vector3<f64>, Point3<f64>)> = Vec::new();
    if robot.base.is_some() {
        let along = |axis: Vector3<f64>| robot.world_from_base.rotation * axis;
        motions.push((0, false, along(Vector3::x()), Point3::origin()));
        motions.push((1, false, along(Vector3::y()), Point3::origin()));
        motions.push((2, true, along(Vector3::z()), Point3::from(root.translation.vector)));
    }
    for joint in joints_to(robot, link) {
        let joint = &robot.joints[joint];
        let drive = Drive::of(robot, joint);
        let world_from_joint = world_from_link * joint.parent_from_joint;
        if let Source::Coordinate(id) = drive.source {
            let along = |axis: &[f64; 3]| world_from_joint.rotation * Vector3::from(*axis) * drive.scale;
            let centre = Point3::from(world_from_joint.translation.vector);
            match &joint.motion {
                JointMotion::Fixed => {}
                JointMotion::Revolute { axis } => motions.push((id.index(), true, along(axis), centre)),
                JointMotion::Prismatic { axis } => motions.push((id.index(), false, along(axis), centre)),
            }
        }
        let value = drive.value(q, robot.end_effector.max_opening);
        world_from_link = world_from_joint * joint_from_child(&joint.motion, value);
    }
    let point = world_from_link * link_point;
    for (column, turns, axis, centre) in motions {
        let velocity = if turns { axis.cross(&(point - centre)) } else { axis };
        let mut linear = columns.fixed_view_mut::<3, 1>(0, column);
        linear += velocity;
        if turns {
            let mut angular = columns.fixed_view_mut::<3, 1>(3, column);
            angular += axis;
        }
    }
    columns
}
