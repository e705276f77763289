//! ROS 2 messages as JSON, with the messages' field names and types.
//!
//! A robot's arm is a `trajectory_msgs/JointTrajectory`, its planar base and each object a
//! `trajectory_msgs/MultiDOFJointTrajectory` in the frame `world`; both together as in `moveit_msgs/RobotTrajectory`.
//! Points carry positions alone: a controller then moves linearly between them, which is what the plan means.

use model::{ObjectId, Pose, RobotId};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use plan::{EventKind, Knot};
use serde::Serialize;

use super::object_times;
use crate::playback::Playback;

/// Greatest turn of a base between two points (rad), so that the short way round is the planned one.
const GREATEST_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// The whole file.
#[derive(Serialize)]
struct Export {
    robots: Vec<Robot>,
    objects: Vec<MultiDofJointTrajectory>,
    events: Vec<HandEvent>,
}

/// A robot with its `moveit_msgs/RobotTrajectory`.
#[derive(Serialize)]
struct Robot {
    name: String,
    joint_trajectory: JointTrajectory,
    multi_dof_joint_trajectory: MultiDofJointTrajectory,
}

/// `trajectory_msgs/JointTrajectory`.
#[derive(Serialize)]
struct JointTrajectory {
    header: Header,
    joint_names: Vec<String>,
    points: Vec<JointTrajectoryPoint>,
}

/// `trajectory_msgs/JointTrajectoryPoint`.
#[derive(Serialize)]
struct JointTrajectoryPoint {
    positions: Vec<f64>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
    effort: Vec<f64>,
    time_from_start: Duration,
}

/// `trajectory_msgs/MultiDOFJointTrajectory`.
#[derive(Serialize)]
struct MultiDofJointTrajectory {
    header: Header,
    joint_names: Vec<String>,
    points: Vec<MultiDofJointTrajectoryPoint>,
}

/// `trajectory_msgs/MultiDOFJointTrajectoryPoint`; no twists.
#[derive(Serialize)]
struct MultiDofJointTrajectoryPoint {
    transforms: Vec<Transform>,
    velocities: [(); 0],
    accelerations: [(); 0],
    time_from_start: Duration,
}

/// `std_msgs/Header`.
#[derive(Serialize)]
struct Header {
    stamp: Duration,
    frame_id: String,
}

/// `builtin_interfaces/Duration`, and `Time` in a header.
#[derive(Clone, Copy, Serialize, PartialEq, Eq, PartialOrd, Ord)]
struct Duration {
    sec: i32,
    nanosec: u32,
}

/// `geometry_msgs/Transform`.
#[derive(Serialize)]
struct Transform {
    translation: Xyz,
    rotation: Xyzw,
}

/// `geometry_msgs/Vector3`.
#[derive(Serialize)]
struct Xyz {
    x: f64,
    y: f64,
    z: f64,
}

/// `geometry_msgs/Quaternion`.
#[derive(Serialize)]
struct Xyzw {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

/// When to attach or detach: fields as in `moveit_msgs/AttachedCollisionObject` where there are such.
#[derive(Serialize)]
struct HandEvent {
    time_from_start: Duration,
    kind: EventKind,
    robot: String,
    object: String,
    link_name: String,
    touch_links: Vec<String>,
    opening: f64,
}

/// The plan as ROS 2 messages, as JSON text.
///
/// # Errors
/// A number that JSON cannot hold.
pub fn ros2(playback: &Playback, rate_hz: Option<f64>) -> Result<String, serde_json::Error> {
    let rate = rate_hz.unwrap_or(super::CURVE_RATE_HZ);
    let export = Export {
        robots: playback.problem.robot_ids().map(|robot| robot_trajectory(playback, robot)).collect(),
        objects: (0..playback.problem.movable.len())
            .map(|object| object_trajectory(playback, ObjectId::at(object), rate))
            .collect(),
        events: hand_events(playback),
    };
    Ok(serde_json::to_string(&export)? + "\n")
}

fn robot_trajectory(playback: &Playback, id: RobotId) -> Robot {
    let robot = playback.problem.robot(id);
    let base_len = robot.base_len();
    let knots = fine_knots(&playback.plan.robots[id.index()].knots, base_len);
    let points = knots.iter().map(|knot| JointTrajectoryPoint {
        positions: knot.q[base_len..].to_vec(),
        velocities: Vec::new(),
        accelerations: Vec::new(),
        effort: Vec::new(),
        time_from_start: duration(knot.t),
    });
    let base = |knot: &Knot| MultiDofJointTrajectoryPoint {
        transforms: vec![transform(&(robot.world_from_base * planar(&knot.q)))],
        velocities: [],
        accelerations: [],
        time_from_start: duration(knot.t),
    };
    // `<virtual joint>/x` names the virtual joint.
    let virtual_joint = robot.coordinates.first().filter(|_| base_len > 0).map(|x| x.name.trim_end_matches("/x"));
    Robot {
        name: robot.name.clone(),
        joint_trajectory: JointTrajectory {
            header: header(robot.links.first().map_or("", |root| &root.name)),
            joint_names: robot.coordinates[base_len..].iter().map(|coordinate| coordinate.name.clone()).collect(),
            points: points.collect(),
        },
        multi_dof_joint_trajectory: MultiDofJointTrajectory {
            header: header("world"),
            joint_names: virtual_joint.iter().map(|&name| name.to_owned()).collect(),
            points: if base_len > 0 { knots.iter().map(base).collect() } else { Vec::new() },
        },
    }
}

fn object_trajectory(playback: &Playback, object: ObjectId, rate_hz: f64) -> MultiDofJointTrajectory {
    let point = |t: f64| MultiDofJointTrajectoryPoint {
        transforms: vec![transform(&playback.object_pose(object, t))],
        velocities: [],
        accelerations: [],
        time_from_start: duration(t),
    };
    let mut points: Vec<_> = object_times(playback, object, rate_hz).into_iter().map(point).collect();
    points.dedup_by_key(|point| point.time_from_start);
    MultiDofJointTrajectory {
        header: header("world"),
        joint_names: vec![playback.problem.movable[object.index()].name.clone()],
        points,
    }
}

fn hand_events(playback: &Playback) -> Vec<HandEvent> {
    let touch_links = |name: &str| {
        let robot = playback.problem.robots.iter().find(|robot| robot.name == name);
        let names = robot.iter().flat_map(|robot| {
            robot.end_effector.links.iter().map(|link| robot.links[link.index()].name.clone()).collect::<Vec<_>>()
        });
        names.collect()
    };
    let events = playback.plan.events.iter().map(|event| HandEvent {
        time_from_start: duration(event.t),
        kind: event.kind,
        robot: event.robot.clone(),
        object: event.object.clone(),
        link_name: event.link.clone(),
        touch_links: touch_links(&event.robot),
        opening: event.opening,
    });
    events.collect()
}

/// Knots with more between two whose base yaws differ much, and those left out whose times a nanosecond cannot tell apart.
fn fine_knots(knots: &[Knot], base_len: usize) -> Vec<Knot> {
    let mut fine: Vec<Knot> = knots.first().into_iter().cloned().collect();
    for pair in knots.windows(2) {
        let turn = if base_len > 0 { (pair[1].q[2] - pair[0].q[2]).abs() } else { 0.0 };
        let parts = (turn / GREATEST_TURN).ceil().max(1.0);
        for part in (1..=parts as u32).map(|part| f64::from(part) / parts) {
            let mix = |a: f64, b: f64| if part < 1.0 { a + (b - a) * part } else { b };
            let q = pair[0].q.iter().zip(&pair[1].q).map(|(a, b)| mix(*a, *b)).collect();
            fine.push(Knot { t: mix(pair[0].t, pair[1].t), q });
        }
    }
    fine.dedup_by_key(|knot| duration(knot.t));
    fine
}

fn planar(q: &[f64]) -> Pose {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q[2]);
    Isometry3::from_parts(Translation3::new(q[0], q[1], 0.0), turn)
}

fn transform(pose: &Pose) -> Transform {
    let (t, q) = (pose.translation.vector, pose.rotation.coords);
    Transform { translation: Xyz { x: t.x, y: t.y, z: t.z }, rotation: Xyzw { x: q.x, y: q.y, z: q.z, w: q.w } }
}

fn header(frame_id: &str) -> Header {
    Header { stamp: duration(0.0), frame_id: frame_id.to_owned() }
}

/// Seconds to the nearest nanosecond.
fn duration(t: f64) -> Duration {
    let whole = t.floor();
    let nanosec = ((t - whole) * 1e9).round() as u32;
    if nanosec == 1_000_000_000 {
        Duration { sec: whole as i32 + 1, nanosec: 0 }
    } else {
        Duration { sec: whole as i32, nanosec }
    }
}
