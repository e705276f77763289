//! Which joints are planned, which follow the gripper, which stand still.

use crate::problem_error::{FindingKind, Found};
use crate::urdf::{Description, JointDescription};
use crate::{Coordinate, CoordinateId, Joint, JointId, JointMotion, JointValue};

/// Joints with their sources of values.
pub(crate) struct Plan {
    pub joints: Vec<Joint>,
    pub coordinates: Vec<Coordinate>,
    /// For each coordinate after the base, the joint that it moves.
    pub planned: Vec<usize>,
    /// Number of base coordinates.
    pub base: usize,
    /// Opening that the finger joints' limits allow (m); 0 where there is no finger joint.
    pub max_opening: f64,
}

/// Gives every joint its source.
///
/// Planned are the movable joints of the end effector's parent group (all but the gripper's, where the SRDF names none).
/// Prismatic joints of the gripper are fingers, closed at 0; its other joints stand as the group state `open` says.
/// Movable joints outside both groups stand as `home` says, or at the value within their limits that is nearest to 0.
pub(crate) fn plan_coordinates(described: &Description, base: Vec<Coordinate>) -> Found<Plan> {
    let mut coordinates = base;
    let base = coordinates.len();
    let fingers: Vec<f64> = (0..described.joints.len()).map(|joint| finger_travel(described, joint)).collect();
    let max_opening = fingers.iter().map(|travel| travel.abs()).sum();
    let mut planned = Vec::new();
    let mut values = Vec::with_capacity(described.joints.len());
    for (position, joint) in described.joints.iter().enumerate() {
        values.push(if joint.motion == JointMotion::Fixed {
            JointValue::Constant(0.0)
        } else if joint.mimic.is_some() {
            // Filled in below, when all leaders are known.
            JointValue::Constant(0.0)
        } else if described.srdf.gripper_joints.contains(&position) {
            gripper_value(described, position, fingers[position], max_opening)?
        } else if described.srdf.arm_joints.as_ref().is_none_or(|arm| arm.contains(&position)) {
            planned.push(position);
            coordinates.push(coordinate(joint));
            JointValue::Coordinate(CoordinateId::at(coordinates.len() - 1))
        } else {
            JointValue::Constant(standing_value(described, position, "home"))
        });
    }
    follow(described, &mut values);
    if planned.is_empty() {
        let place = described.srdf.end_effector.span;
        return Err(described
            .srdf_source
            .finding(place, FindingKind::BadRobot, "no movable joint in the arm")
            .help("`parent_group` must name the group of the arm's joints"));
    }
    Ok(Plan { joints: joints(described, values), coordinates, planned, base, max_opening })
}

fn joints(described: &Description, values: Vec<JointValue>) -> Vec<Joint> {
    let joint = |(joint, value): (&JointDescription, JointValue)| Joint {
        name: joint.name.clone(),
        parent: joint.parent,
        child: joint.child,
        parent_from_joint: joint.parent_from_joint,
        motion: joint.motion.clone(),
        value,
    };
    described.joints.iter().zip(values).map(joint).collect()
}

fn coordinate(joint: &JointDescription) -> Coordinate {
    let limit = joint.limit;
    Coordinate { name: joint.name.clone(), lower: limit.lower, upper: limit.upper, velocity: limit.velocity }
}

/// Mimic joints follow their leaders.
fn follow(described: &Description, values: &mut [JointValue]) {
    for (position, joint) in described.joints.iter().enumerate() {
        let Some(mimic) = &joint.mimic else { continue };
        if joint.motion == JointMotion::Fixed {
            continue;
        }
        values[position] = match values[mimic.of] {
            JointValue::Constant(value) => JointValue::Constant(mimic.multiplier * value + mimic.offset),
            _ => JointValue::Mimic { of: JointId::at(mimic.of), multiplier: mimic.multiplier, offset: mimic.offset },
        };
    }
}

/// Travel of a finger joint from closed to open (m); 0 for joints that are no fingers.
fn finger_travel(described: &Description, position: usize) -> f64 {
    let joint = &described.joints[position];
    let is_finger =
        described.srdf.gripper_joints.contains(&position) && matches!(joint.motion, JointMotion::Prismatic { .. });
    match (&joint.mimic, is_finger) {
        (_, false) => 0.0,
        (None, true) => travel(joint),
        (Some(mimic), true) => mimic.multiplier * travel(&described.joints[mimic.of]),
    }
}

/// From 0 to the limit farther from 0.
fn travel(joint: &JointDescription) -> f64 {
    let limit = joint.limit;
    if limit.upper.abs() >= limit.lower.abs() { limit.upper } else { limit.lower }
}

fn gripper_value(described: &Description, position: usize, travel: f64, max_opening: f64) -> Found<JointValue> {
    let joint = &described.joints[position];
    if travel != 0.0 && joint.limit.lower <= 0.0 && joint.limit.upper >= 0.0 {
        return Ok(JointValue::Finger { scale: travel / max_opening });
    }
    if !described.srdf.states.iter().any(|state| state.name == "open") {
        return Err(described
            .urdf
            .finding(
                joint.span,
                FindingKind::BadRobot,
                format!("gripper joint `{}` is no sliding finger, closed at 0", joint.name),
            )
            .help("add a group state `open` to the SRDF: such a joint is kept at its open value"));
    }
    Ok(JointValue::Constant(standing_value(described, position, "open")))
}

/// The value of a joint that is not planned.
fn standing_value(described: &Description, position: usize, state: &str) -> f64 {
    let states = described.srdf.states.iter().filter(|known| known.name == state);
    let said = states.flat_map(|state| &state.values).find(|(joint, _)| *joint == position);
    let limit = described.joints[position].limit;
    said.map_or_else(|| 0.0_f64.clamp(limit.lower, limit.upper), |(_, value)| *value)
}
