//! What moves a joint: the one quantity its value depends on, and how.

use model::{CoordinateId, Joint, JointMotion, JointValue, Pose, Robot};
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

/// The quantity a joint's value follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Source {
    /// A planned coordinate.
    Coordinate(CoordinateId),
    /// The gap between the fingers (m).
    Opening,
    /// Nothing.
    Constant,
}

/// A joint's value as `scale · source + offset` (rad or m), all mimicking followed to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drive {
    pub source: Source,
    pub scale: f64,
    pub offset: f64,
}

impl Drive {
    /// What moves `joint`. A ring of joints that mimic each other follows nothing.
    pub fn of(robot: &Robot, joint: &Joint) -> Self {
        let (mut scale, mut offset) = (1.0, 0.0);
        let mut value = &joint.value;
        for _ in 0..=robot.joints.len() {
            match value {
                JointValue::Coordinate(id) => return Self { source: Source::Coordinate(*id), scale, offset },
                JointValue::Finger { scale: per_opening } => {
                    return Self { source: Source::Opening, scale: scale * per_opening, offset };
                }
                JointValue::Constant(constant) => {
                    return Self { source: Source::Constant, scale: 0.0, offset: offset + scale * constant };
                }
                JointValue::Mimic { of, multiplier, offset: shift } => {
                    offset += scale * shift;
                    scale *= multiplier;
                    value = &robot.joints[of.index()].value;
                }
            }
        }
        Self { source: Source::Constant, scale: 0.0, offset }
    }

    /// The joint's value (rad or m).
    pub fn value(&self, q: &[f64], opening: f64) -> f64 {
        match self.source {
            Source::Coordinate(id) => self.scale * q[id.index()] + self.offset,
            Source::Opening => self.scale * opening + self.offset,
            Source::Constant => self.offset,
        }
    }
}

/// Takes the child link's frame to the joint frame at zero.
pub(crate) fn joint_from_child(motion: &JointMotion, value: f64) -> Pose {
    match motion {
        JointMotion::Fixed => Pose::identity(),
        JointMotion::Revolute { axis } => Isometry3::from_parts(
            Translation3::identity(),
            UnitQuaternion::from_axis_angle(&Unit::new_unchecked(Vector3::from(*axis)), value),
        ),
        JointMotion::Prismatic { axis } => {
            Isometry3::from_parts((Vector3::from(*axis) * value).into(), UnitQuaternion::identity())
        }
    }
}

/// Takes the child link's frame to the parent link's.
pub(crate) fn parent_from_child(joint: &Joint, value: f64) -> Pose {
    match joint.motion {
        JointMotion::Fixed => joint.parent_from_joint,
        _ => joint.parent_from_joint * joint_from_child(&joint.motion, value),
    }
}
