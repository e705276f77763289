//! Grasp families: the ways in which a parallel gripper takes an upright object.

use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::{Body, EndEffector, Grasp, GraspFamily, MovableObject, Pose, Robot};

/// Gap between the palm and the object (m).
const PALM_GAP: f64 = 0.002;
/// Gap between finger tips and what the object stands on, when grasped from above (m).
const TIP_GAP: f64 = 0.005;

/// How far the hand's bodies reach along the tool frame's z axis (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct HandDepth {
    /// Front of the palm: of the links that the fingers' joints do not move.
    palm: f64,
    /// Finger tips.
    tip: f64,
}

impl HandDepth {
    /// Of a robot's hand. Without bodies, palm and tips are 25 mm from the tool's origin.
    ///
    /// A hand of one rigid piece holds with its front, as a suction cup does: palm and tips are one, at the front of its
    /// bodies or, without bodies, at the tool's origin.
    pub(crate) fn of(robot: &Robot) -> Self {
        let hand = &robot.end_effector;
        let tool_from_link = hand.link_from_tool.inverse();
        let (mut palm, mut tip) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        let mut rigid = true;
        for link in &hand.links {
            let (parent_from_link, moves) = pose_at_zero(robot, hand, *link);
            let front = front(&robot.links[link.index()].bodies, &(tool_from_link * parent_from_link));
            if moves {
                tip = tip.max(front)
            } else {
                palm = palm.max(front)
            }
            rigid &= !moves;
        }
        let known = |z: f64, default: f64| if z.is_finite() { z } else { default };
        if rigid {
            let front = known(palm, 0.0);
            return Self { palm: front, tip: front };
        }
        let palm = known(palm, -0.025);
        Self { palm, tip: known(tip, palm + 0.05).max(palm) }
    }
}

/// Pose of a hand link in the parent link with its fingers closed, and whether a finger joint moves it.
fn pose_at_zero(robot: &Robot, hand: &EndEffector, link: crate::LinkId) -> (Pose, bool) {
    let (mut pose, mut moves, mut at) = (Pose::identity(), false, link);
    while at != hand.parent_link {
        let Some(joint) = robot.joint_of_link(at).map(|joint| &robot.joints[joint.index()]) else { break };
        pose = joint.parent_from_joint * pose;
        moves |= joint.motion != crate::JointMotion::Fixed;
        at = joint.parent;
    }
    (pose, moves)
}

fn front(bodies: &[Body], tool_from_owner: &Pose) -> f64 {
    let heights = bodies.iter().flat_map(|body| {
        let tool_from_shape = tool_from_owner * body.owner_from_shape;
        let rounding = body.shape.rounding();
        body.shape.support_points().into_iter().map(move |p| (tool_from_shape * p).z + rounding)
    });
    heights.fold(f64::NEG_INFINITY, f64::max)
}

/// Horizontal approach: 4 yaws × 2 flips × 3 heights (centre and a quarter of the object's height above and below).
///
/// The first four differ in yaw, the first twelve in yaw and height. Grasps wider than the hand opens are left out.
pub(crate) fn side_grasps(object: &MovableObject, robot: &Robot, depth: HandDepth) -> Vec<Grasp> {
    let extent = Extent::of(&object.body);
    let mut grasps = Vec::new();
    for round in 0..6 {
        let height = [0.0, 0.25, -0.25][round % 3] * extent.size.z;
        let flip = (round % 3 + round / 3) % 2 == 1;
        for quarter in 0..4 {
            let approach = quarter_turn(quarter);
            let up = if flip { Vector3::z() } else { -Vector3::z() };
            let object_from_tool = frame(approach, up);
            let (near, width) = (extent.along(approach) / 2.0, extent.along(up.cross(&approach)));
            let inset = depth.palm + PALM_GAP + near;
            let origin = extent.centre + Vector3::z() * height - approach * inset.max(0.0);
            grasps.extend(grasp(robot, origin, object_from_tool, width, GraspFamily::Side));
        }
    }
    grasps
}

/// From above: 4 yaws, as deep as palm and support allow.
pub(crate) fn top_grasps(object: &MovableObject, robot: &Robot, depth: HandDepth) -> Vec<Grasp> {
    let extent = Extent::of(&object.body);
    let mut grasps = Vec::new();
    for quarter in 0..4 {
        let closing = quarter_turn(quarter);
        let approach = -Vector3::z();
        let object_from_tool = frame(approach, closing.cross(&approach));
        // The object's top at this depth along the tool's z: in front of the palm, and finger tips above the support.
        let top = (depth.palm + PALM_GAP).max(depth.tip - extent.size.z + TIP_GAP);
        let origin = extent.centre + Vector3::z() * (extent.size.z / 2.0 + top);
        grasps.extend(grasp(robot, origin, object_from_tool, extent.along(closing), GraspFamily::Top));
    }
    grasps
}

/// Takes turns between lists, so that the first few grasps are of all families.
pub(crate) fn take_turns(mut lists: Vec<Vec<Grasp>>) -> Vec<Grasp> {
    let mut mixed = Vec::new();
    lists.iter_mut().for_each(|list| list.reverse());
    while lists.iter().any(|list| !list.is_empty()) {
        mixed.extend(lists.iter_mut().filter_map(Vec::pop));
    }
    mixed
}

/// Axis-aligned bounds of a body in its object's frame.
struct Extent {
    centre: Vector3<f64>,
    size: Vector3<f64>,
}

impl Extent {
    fn of(body: &Body) -> Self {
        let grown = Vector3::repeat(body.shape.rounding());
        let points = body.shape.support_points();
        let points = points.iter().map(|p| (body.owner_from_shape * p).coords);
        let (low, high) = points.fold((Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN)), |(low, high), p| {
            (low.inf(&(p - grown)), high.sup(&(p + grown)))
        });
        Self { centre: (low + high) / 2.0, size: high - low }
    }

    /// Extent along one of the object's axes.
    fn along(&self, axis: Vector3<f64>) -> f64 {
        self.size.dot(&axis.abs())
    }
}

/// Unit vector in the plane at 0, 180, 90 and 270 degrees: opposite directions first, then the others.
fn quarter_turn(quarter: usize) -> Vector3<f64> {
    [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()][quarter % 4]
}

/// Orientation of a tool frame with this z and x axis.
fn frame(z: Vector3<f64>, x: Vector3<f64>) -> UnitQuaternion<f64> {
    let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}

fn grasp(
    robot: &Robot,
    origin: Vector3<f64>,
    object_from_tool: UnitQuaternion<f64>,
    width: f64,
    family: GraspFamily,
) -> Option<Grasp> {
    let hand = &robot.end_effector;
    let object_from_tool = Pose::from_parts(Translation3::from(origin), object_from_tool);
    let approach = hand.link_from_tool.rotation * Vector3::z();
    (width <= hand.max_opening).then(|| Grasp {
        link_from_object: hand.link_from_tool * object_from_tool.inverse(),
        opening: width,
        approach: approach.into(),
        family,
    })
}
