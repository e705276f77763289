//! The moving joints between a robot's root and its hand, with everything rigid folded together.

use model::{JointMotion, Pose, Robot};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3, Vector6};

use crate::drive::{Drive, Source, parent_from_child};
use crate::forward::joints_to;
use crate::line::{Line, rotation};
use crate::range::Range;

/// A joint moved by an arm coordinate: its value is `scale · arm[index] + offset`.
#[derive(Clone, Debug)]
pub(crate) struct SerialJoint {
    /// Takes the joint frame at zero to the frame of the link moved by the joint before it (of the root, for the first).
    pub parent_from_joint: Pose,
    /// Unit axis in the joint frame.
    pub axis: Vector3<f64>,
    /// Whether it turns (else it slides).
    pub turns: bool,
    pub index: usize,
    pub scale: f64,
    pub offset: f64,
}

/// The joints moved by arm coordinates, from the root to the end effector's parent link. The hand is fully open.
#[derive(Clone, Debug)]
pub(crate) struct SerialChain {
    pub joints: Vec<SerialJoint>,
    /// Takes the end effector's parent link to the link moved by the last joint.
    pub child_from_link: Pose,
    /// Limits of the arm coordinates, also of those that do not move the hand.
    pub ranges: Vec<Range>,
    /// Values for arm coordinates that do not move the hand: the robot's home.
    pub rest: Vec<f64>,
}

impl SerialChain {
    /// The chain to the end effector's parent link.
    pub fn of(robot: &Robot) -> Self {
        let ranges: Vec<Range> = robot.coordinates[robot.base_len()..]
            .iter()
            .map(|coordinate| Range { lower: coordinate.lower, upper: coordinate.upper })
            .collect();
        let rest = ranges
            .iter()
            .enumerate()
            .map(|(i, range)| range.nearest(robot.home.get(i).copied().unwrap_or_default()))
            .collect();
        let mut joints = Vec::new();
        let mut rigid = Pose::identity();
        for joint in joints_to(robot, robot.end_effector.parent_link) {
            let joint = &robot.joints[joint];
            let (axis, turns) = match joint.motion {
                JointMotion::Fixed => {
                    rigid *= joint.parent_from_joint;
                    continue;
                }
                JointMotion::Revolute { axis } => (Vector3::from(axis), true),
                JointMotion::Prismatic { axis } => (Vector3::from(axis), false),
            };
            let drive = Drive::of(robot, joint);
            let Source::Coordinate(id) = drive.source else {
                rigid *= parent_from_child(joint, drive.value(&[], robot.end_effector.max_opening));
                continue;
            };
            let (parent_from_joint, index) = (rigid * joint.parent_from_joint, id.index() - robot.base_len());
            joints.push(SerialJoint {
                parent_from_joint,
                axis,
                turns,
                index,
                scale: drive.scale,
                offset: drive.offset,
            });
            rigid = Pose::identity();
        }
        Self { joints, child_from_link: rigid, ranges, rest }
    }

    /// The joints' axes in the root frame, and `root_from_link`, where every joint's value is zero.
    pub fn at_zero(&self) -> (Vec<Line>, Pose) {
        let mut root_from_joint = Pose::identity();
        let mut lines = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            root_from_joint *= joint.parent_from_joint;
            let axis = root_from_joint.rotation * joint.axis;
            lines.push(Line { point: Point3::from(root_from_joint.translation.vector), axis });
        }
        (lines, root_from_joint * self.child_from_link)
    }

    /// The pose `root_from_link` and, in `columns`, the Jacobian of the link's origin in the root frame: one column of
    /// velocity and angular velocity per arm coordinate.
    pub fn pose_and_columns(&self, arm: &[f64], columns: &mut Vec<Vector6<f64>>) -> Pose {
        let mut lines: Vec<Line> = Vec::with_capacity(self.joints.len());
        let mut root_from_child = Pose::identity();
        for joint in &self.joints {
            root_from_child *= joint.parent_from_joint;
            let axis = root_from_child.rotation * joint.axis;
            lines.push(Line { point: Point3::from(root_from_child.translation.vector), axis });
            root_from_child *= joint.joint_from_child(arm);
        }
        let root_from_link = root_from_child * self.child_from_link;
        columns.clear();
        columns.resize(self.ranges.len(), Vector6::zeros());
        for (joint, line) in self.joints.iter().zip(&lines) {
            let arm = root_from_link.translation.vector - line.point.coords;
            let (linear, angular) =
                if joint.turns { (line.axis.cross(&arm), line.axis) } else { (line.axis, Vector3::zeros()) };
            let column = &mut columns[joint.index];
            column.fixed_rows_mut::<3>(0).axpy(joint.scale, &linear, 1.0);
            column.fixed_rows_mut::<3>(3).axpy(joint.scale, &angular, 1.0);
        }
        root_from_link
    }
}

impl SerialJoint {
    /// Takes the moved link's frame to the joint frame at zero.
    fn joint_from_child(&self, arm: &[f64]) -> Pose {
        let value = self.scale * arm[self.index] + self.offset;
        if self.turns {
            Isometry3::from_parts(Translation3::identity(), rotation(&self.axis, value))
        } else {
            Isometry3::from_parts((self.axis * value).into(), UnitQuaternion::identity())
        }
    }
}
