//! Robots built joint by joint, random numbers and comparisons for the tests of this crate.
#![allow(dead_code)]

use model::{
    Coordinate, CoordinateId, EndEffector, Joint, JointMotion, JointValue, Link, LinkId, PlanarBase, Pose, Robot,
};
use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use std::f64::consts::{PI, TAU};

/// SplitMix64; a failing test names its seed.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.unit()
    }

    pub fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = Vector3::from_fn(|_, _| self.between(-1.0, 1.0));
            if v.norm() > 0.1 && v.norm() < 1.0 {
                return v.normalize();
            }
        }
    }

    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Unit::new_normalize(self.direction()), self.between(-PI, PI))
    }

    pub fn pose(&mut self, size: f64) -> Pose {
        let shift = Vector3::from_fn(|_, _| self.between(-size, size));
        Isometry3::from_parts(shift.into(), self.rotation())
    }

    /// A configuration within the limits; unlimited coordinates within ±3.
    pub fn configuration(&mut self, robot: &Robot) -> Vec<f64> {
        robot.coordinates.iter().map(|c| self.between(c.lower.max(-3.0), c.upper.min(3.0))).collect()
    }
}

/// An axis of a joint in the root frame where all joints are zero.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    pub point: Point3<f64>,
    pub direction: Vector3<f64>,
    pub slides: bool,
}

pub fn turning(point: [f64; 3], direction: [f64; 3]) -> Axis {
    Axis { point: Point3::from(point), direction: Vector3::from(direction), slides: false }
}

pub fn sliding(direction: [f64; 3]) -> Axis {
    Axis { point: Point3::origin(), direction: Vector3::from(direction), slides: true }
}

/// A robot with only its root.
pub fn bare(name: &str) -> Robot {
    Robot {
        name: name.into(),
        world_from_base: Pose::identity(),
        links: vec![Link { name: "root".into(), bodies: Vec::new() }],
        joints: Vec::new(),
        coordinates: Vec::new(),
        base: None,
        end_effector: EndEffector {
            name: "hand".into(),
            parent_link: LinkId(0),
            link_from_tool: Pose::identity(),
            links: Vec::new(),
            max_opening: 0.1,
        },
        disabled_pairs: Vec::new(),
        start: Vec::new(),
        home: Vec::new(),
        carry: Vec::new(),
    }
}

/// Gives the root a planar base; call it before any joint is added.
pub fn add_base(robot: &mut Robot, world_from_base: Pose) {
    robot.world_from_base = world_from_base;
    robot.base = Some(PlanarBase { speed: 0.8, yaw_rate: 1.5 });
    for name in ["base/x", "base/y", "base/yaw"] {
        let limit = if name == "base/yaw" { f64::INFINITY } else { 5.0 };
        robot.coordinates.push(Coordinate { name: name.into(), lower: -limit, upper: limit, velocity: 1.0 });
    }
}

/// Adds a link behind `parent` and the joint that moves it.
pub fn add_joint(
    robot: &mut Robot,
    parent: LinkId,
    parent_from_joint: Pose,
    motion: JointMotion,
    value: JointValue,
) -> LinkId {
    let child = LinkId::at(robot.links.len());
    robot.links.push(Link { name: format!("link {}", child.index()), bodies: Vec::new() });
    let name = format!("joint {}", child.index());
    robot.joints.push(Joint { name, parent, child, parent_from_joint, motion, value });
    child
}

/// A new coordinate with these limits.
pub fn add_coordinate(robot: &mut Robot, limits: [f64; 2]) -> JointValue {
    let [lower, upper] = limits;
    let id = CoordinateId::at(robot.coordinates.len());
    robot.coordinates.push(Coordinate { name: format!("q{}", id.index()), lower, upper, velocity: 2.0 });
    robot.home.push(if lower <= 0.0 && upper >= 0.0 { 0.0 } else { 0.5 * (lower + upper) });
    JointValue::Coordinate(id)
}

/// Adds an arm from its axes at zero and the hand's pose there. With `random`, every joint frame stands anywhere on its
/// axis, turned anyhow; joints whose entry in `flipped` is true turn the other way round.
pub fn add_arm(
    robot: &mut Robot,
    axes: &[Axis],
    root_from_hand: Pose,
    limits: &[[f64; 2]],
    flipped: &[bool],
    mut random: Option<&mut Random>,
) {
    let mut parent = LinkId(0);
    let mut root_from_parent = Pose::identity();
    for (i, axis) in axes.iter().enumerate() {
        let mut root_from_joint = Pose::from_parts(axis.point.coords.into(), UnitQuaternion::identity());
        if let Some(random) = random.as_deref_mut() {
            let along = axis.direction * random.between(-0.3, 0.3);
            root_from_joint = Isometry3::from_parts((axis.point.coords + along).into(), random.rotation());
        }
        let [mut lower, mut upper] = limits[i];
        let mut direction = root_from_joint.rotation.inverse() * axis.direction;
        if flipped.get(i).copied().unwrap_or(false) {
            direction = -direction;
            (lower, upper) = (-upper, -lower);
        }
        let axis_in_joint = direction.into();
        let motion = if axis.slides {
            JointMotion::Prismatic { axis: axis_in_joint }
        } else {
            JointMotion::Revolute { axis: axis_in_joint }
        };
        let value = add_coordinate(robot, [lower, upper]);
        parent = add_joint(robot, parent, root_from_parent.inverse() * root_from_joint, motion, value);
        root_from_parent = root_from_joint;
    }
    let hand = root_from_parent.inverse() * root_from_hand;
    robot.end_effector.parent_link = add_joint(robot, parent, hand, JointMotion::Fixed, JointValue::Constant(0.0));
}

/// The axes of `axes` after the joints have turned by `q`, and the hand's pose: the same arm with other zero angles.
pub fn with_other_zero(axes: &[Axis], root_from_hand: Pose, q: &[f64]) -> (Vec<Axis>, Pose) {
    let mut moved = Pose::identity();
    let mut result = Vec::new();
    for (axis, q) in axes.iter().zip(q) {
        let (point, direction) = (moved * axis.point, moved * axis.direction);
        result.push(Axis { point, direction, slides: axis.slides });
        let shift = if axis.slides { direction * *q } else { Vector3::zeros() };
        let turn = if axis.slides { 0.0 } else { *q };
        let turn = UnitQuaternion::from_axis_angle(&Unit::new_normalize(direction), turn);
        let about = Translation3::from(point.coords) * turn * Translation3::from(-point.coords);
        moved = Translation3::from(shift) * about * moved;
    }
    (result, moved * root_from_hand)
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

fn degrees(limits: &[f64]) -> Vec<[f64; 2]> {
    limits.iter().map(|l| [-l.to_radians(), l.to_radians()]).collect()
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

/// S-R-S, 0.34 to the shoulder, 0.40 + 0.40, hand 0.126 beyond the wrist; upright at zero.
pub fn srs_axes() -> (Vec<Axis>, Pose, Vec<[f64; 2]>) {
    let (s, e, w) = ([0.0, 0.0, 0.34], [0.0, 0.0, 0.74], [0.0, 0.0, 1.14]);
    let axes = vec![
        turning(s, Z),
        turning(s, Y),
        turning(s, Z),
        turning(e, [0.0, -1.0, 0.0]),
        turning(w, Z),
        turning(w, Y),
        turning(w, Z),
    ];
    (axes, at(0.0, 0.0, 1.266), degrees(&[170.0, 120.0, 170.0, 120.0, 170.0, 120.0, 175.0]))
}

/// An arm of the same kind with the elbow beside the line from shoulder to wrist and an oblique wrist.
pub fn offset_srs_axes() -> (Vec<Axis>, Pose, Vec<[f64; 2]>) {
    let (s, e, w) = ([0.0, 0.1, 0.3], [0.045, 0.0, 0.85], [0.0, 0.0, 1.15]);
    let oblique = Vector3::new(0.5, 1.0, 0.3).normalize().into();
    let axes = vec![
        turning(s, Z),
        turning(s, X),
        turning(s, Z),
        turning(e, Y),
        turning(w, Z),
        turning(w, oblique),
        turning(w, X),
    ];
    (axes, at(0.05, 0.02, 1.25), degrees(&[150.0, 115.0, 160.0, 140.0, 170.0, 120.0, 175.0]))
}

/// Seven axes like those of a Panda: elbow and wrist offset, so no closed form here.
pub fn offset_wrist_axes() -> (Vec<Axis>, Pose, Vec<[f64; 2]>) {
    let axes = vec![
        turning([0.0, 0.0, 0.333], Z),
        turning([0.0, 0.0, 0.333], Y),
        turning([0.0, 0.0, 0.649], Z),
        turning([0.0825, 0.0, 0.649], [0.0, -1.0, 0.0]),
        turning([0.0, 0.0, 1.033], Z),
        turning([0.0, 0.0, 1.033], [0.0, -1.0, 0.0]),
        turning([0.088, 0.0, 1.033], [0.0, 0.0, -1.0]),
    ];
    let hand = Isometry3::from_parts(Translation3::new(0.088, 0.0, 0.926), UnitQuaternion::new(Vector3::x() * PI));
    let limits = vec![
        [-2.8973, 2.8973],
        [-1.7628, 1.7628],
        [-2.8973, 2.8973],
        [-3.0718, -0.0698],
        [-2.8973, 2.8973],
        [-0.0175, 3.7525],
        [-2.8973, 2.8973],
    ];
    (axes, hand, limits)
}

/// Six axes without a spherical wrist, limits of one turn either way.
pub fn six_axes() -> (Vec<Axis>, Pose, Vec<[f64; 2]>) {
    let axes = vec![
        turning([0.0, 0.0, 0.089], Z),
        turning([0.0, 0.13, 0.089], Y),
        turning([0.425, 0.13, 0.089], Y),
        turning([0.817, 0.13, 0.089], Y),
        turning([0.817, 0.109, 0.0], [0.0, 0.0, -1.0]),
        turning([0.817, 0.109, -0.006], Y),
    ];
    (axes, at(0.817, 0.19, -0.006), vec![[-TAU, TAU]; 6])
}

/// A fixed robot with these axes.
pub fn arm(name: &str, (axes, hand, limits): (Vec<Axis>, Pose, Vec<[f64; 2]>)) -> Robot {
    let mut robot = bare(name);
    add_arm(&mut robot, &axes, hand, &limits, &[], None);
    robot
}

/// The greater of the distance (m) and the angle (rad) between two poses.
pub fn pose_error(a: &Pose, b: &Pose) -> f64 {
    // Not the quaternions' angle_to: an arc cosine cannot tell angles below 1e-8.
    let turned = (a.rotation.inverse() * b.rotation).imag().norm() * 2.0;
    (a.translation.vector - b.translation.vector).norm().max(turned)
}

/// Greatest joint difference up to whole turns (rad).
pub fn turn_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| ((a - b) - TAU * ((a - b) / TAU).round()).abs()).fold(0.0, f64::max)
}

/// Whether every coordinate after the base lies within its limits.
pub fn within_limits(robot: &Robot, arm: &[f64]) -> bool {
    let coordinates = &robot.coordinates[robot.base_len()..];
    arm.len() == coordinates.len() && arm.iter().zip(coordinates).all(|(x, c)| *x >= c.lower && *x <= c.upper)
}
