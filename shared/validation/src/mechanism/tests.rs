use glamx::DVec3;
use model::{
    Coordinate, CoordinateId, EndEffector, Joint as ModelJoint, JointId, JointMotion, JointValue, Link, LinkId,
    PlanarBase, Pose, Robot,
};
use nalgebra::Isometry3;
use plan::Knot;

use super::{Mechanism, Posture, Rates};
use crate::frame::Frame;
use crate::random::Random;
use crate::track::Track;

/// A robot whose links form a chain, but for those given another parent.
fn robot(joints: Vec<(usize, Pose, JointMotion, JointValue)>, coordinates: usize, base: Option<PlanarBase>) -> Robot {
    let links = (0..=joints.len()).map(|i| Link { name: format!("l{i}"), bodies: Vec::new() }).collect();
    let joint = |(i, (parent, parent_from_joint, motion, value))| ModelJoint {
        name: format!("j{i}"),
        parent: LinkId::at(parent),
        child: LinkId::at(i + 1),
        parent_from_joint,
        motion,
        value,
    };
    let coordinate = |i| Coordinate { name: format!("c{i}"), lower: -9.0, upper: 9.0, velocity: 1.0 };
    Robot {
        name: "r".to_owned(),
        world_from_base: Pose::identity(),
        links,
        joints: joints.into_iter().enumerate().map(joint).collect(),
        coordinates: (0..coordinates).map(coordinate).collect(),
        base,
        end_effector: EndEffector {
            name: "hand".to_owned(),
            parent_link: LinkId(0),
            link_from_tool: Pose::identity(),
            links: Vec::new(),
            max_opening: 0.1,
        },
        disabled_pairs: Vec::new(),
        start: vec![0.0; coordinates],
        home: Vec::new(),
        carry: Vec::new(),
    }
}

fn planned(i: usize) -> JointValue {
    JointValue::Coordinate(CoordinateId::at(i))
}

fn turns(axis: [f64; 3]) -> JointMotion {
    JointMotion::Revolute { axis }
}

fn shift(x: f64, y: f64, z: f64) -> Pose {
    Isometry3::translation(x, y, z)
}

fn tip(robot: &Robot, q: &[f64], opening: f64) -> DVec3 {
    let (mechanism, mut posture) = (Mechanism::new(robot).expect("a tree"), Posture::default());
    mechanism.place(q, opening, &mut posture);
    posture.links[robot.links.len() - 1].origin
}

#[test]
fn a_planar_arm_reaches_where_sines_and_cosines_say() {
    let (a, b) = (0.7, 0.4);
    let z = [0.0, 0.0, 1.0];
    let fixed = (2, shift(b, 0.0, 0.0), JointMotion::Fixed, JointValue::Constant(0.0));
    let joints =
        vec![(0, shift(0.1, 0.2, 0.3), turns(z), planned(0)), (1, shift(a, 0.0, 0.0), turns(z), planned(1)), fixed];
    let arm = robot(joints, 2, None);
    for seed in 0..200 {
        let mut random = Random(seed);
        let (p, q) = (random.between(-7.0, 7.0), random.between(-7.0, 7.0));
        let expected = DVec3::new(0.1 + a * p.cos() + b * (p + q).cos(), 0.2 + a * p.sin() + b * (p + q).sin(), 0.3);
        let found = tip(&arm, &[p, q], 0.0);
        assert!(found.distance(expected) < 1e-12, "seed {seed}: {found}, expected {expected}");
    }
}

#[test]
fn a_planar_base_drives_in_the_frame_of_its_origin() {
    let mast = (0, shift(0.5, 0.0, 1.0), JointMotion::Prismatic { axis: [1.0, 0.0, 0.0] }, planned(3));
    let mut rover = robot(vec![mast], 4, Some(PlanarBase { speed: 1.0, yaw_rate: 1.0 }));
    let turned = Isometry3::rotation(nalgebra::Vector3::z() * std::f64::consts::FRAC_PI_2);
    rover.world_from_base = shift(10.0, 0.0, 0.0) * turned;
    // Origin (10, 0); x and y turned by a quarter: (2, 1) goes to (-1, 2); heading a quarter plus a quarter.
    let found = tip(&rover, &[2.0, 1.0, std::f64::consts::FRAC_PI_2, 0.25], 0.0);
    assert!(found.distance(DVec3::new(10.0 - 1.0 - 0.75, 2.0, 1.0)) < 1e-12, "{found}");
}

#[test]
fn fingers_follow_the_opening_and_mimics_follow_what_they_name() {
    let slides = |y: f64| JointMotion::Prismatic { axis: [0.0, y, 0.0] };
    let late = JointValue::Mimic { of: JointId(1), multiplier: -2.0, offset: 0.01 };
    let joints = vec![
        (0, Pose::identity(), slides(1.0), late),
        (0, Pose::identity(), slides(1.0), JointValue::Finger { scale: 0.5 }),
        (0, Pose::identity(), slides(1.0), JointValue::Mimic { of: JointId(0), multiplier: 1.0, offset: 0.0 }),
    ];
    let hand = robot(joints, 0, None);
    assert!(tip(&hand, &[], 0.08).distance(DVec3::new(0.0, -0.07, 0.0)) < 1e-15);
}

#[test]
fn rings_of_mimics_and_joints_out_of_order_are_refused() {
    let z = [0.0, 0.0, 1.0];
    let follows = |of: u32| JointValue::Mimic { of: JointId(of), multiplier: 1.0, offset: 0.0 };
    let ring = vec![(0, Pose::identity(), turns(z), follows(1)), (1, Pose::identity(), turns(z), follows(0))];
    assert!(Mechanism::new(&robot(ring, 0, None)).is_none());
    let early = vec![(2, Pose::identity(), turns(z), planned(0)), (0, Pose::identity(), turns(z), planned(0))];
    assert!(Mechanism::new(&robot(early, 1, None)).is_none());
    assert!(Mechanism::new(&robot(vec![(0, Pose::identity(), turns(z), planned(3))], 1, None)).is_none());
}

/// A random tree of six joints with repeated coordinates and mimics, on a planar base or not.
fn random_robot(random: &mut Random) -> Robot {
    let base = (random.unit() < 0.5).then_some(PlanarBase { speed: 1.0, yaw_rate: 1.0 });
    let first = if base.is_some() { 3 } else { 0 };
    let mut joints = Vec::new();
    for i in 0..6 {
        let axis = random.direction().to_array();
        let motion = match random.below(3) {
            0 => JointMotion::Prismatic { axis },
            _ => turns(axis),
        };
        let value = match random.below(5) {
            0 if i > 0 => JointValue::Mimic { of: JointId(0), multiplier: random.between(-2.0, 2.0), offset: 0.3 },
            1 => JointValue::Finger { scale: 0.5 },
            _ => planned(first + random.below(4)),
        };
        joints.push((if random.unit() < 0.7 { i } else { random.below(i + 1) }, random.pose(0.5), motion, value));
    }
    let mut robot = robot(joints, first + 4, base);
    robot.world_from_base = random.pose(1.0);
    robot
}

#[test]
fn no_point_moves_faster_than_its_bound() {
    for seed in 0..2000 {
        let mut random = Random(seed);
        let robot = random_robot(&mut random);
        let mechanism = Mechanism::new(&robot).expect("a tree");
        let knot = |t: f64, random: &mut Random| Knot {
            t,
            q: (0..robot.coordinates.len()).map(|_| random.between(-2.0, 2.0)).collect(),
        };
        let knots = [knot(1.0, &mut random), knot(1.8, &mut random)];
        let leg = Track { knots: &knots }.leg(1.0);
        let (mut rates, mut here, mut there) = (Rates::default(), Posture::default(), Posture::default());
        mechanism.rates(&leg, &mut rates);
        let (t, s) = (random.between(1.0, 1.8), random.between(1.0, 1.8));
        mechanism.place_at(&leg, t, 0.05, &mut here);
        mechanism.place_at(&leg, s, 0.05, &mut there);
        let (a, b) = (LinkId::at(random.below(7)), LinkId::at(random.below(7)));
        let (p, q) = (DVec3::from(random.vector(0.5)), DVec3::from(random.vector(0.5)));
        let radius = 0.1;
        let speed = |link: LinkId, centre: DVec3| mechanism.speed(&here, &rates, link, centre, radius);
        let beyond = |link: LinkId, other: LinkId, centre: DVec3| {
            mechanism.speed_beyond(&here, &rates, link, other, centre, radius)
        };
        let (centre_a, centre_b) = (here.links[a.index()].point(p), here.links[b.index()].point(q));
        let on_rim = p + random.direction() * radius;
        let (from, to) = (here.links[a.index()].point(on_rim), there.links[a.index()].point(on_rim));
        let allowed = speed(a, centre_a) * (t - s).abs();
        assert!(from.distance(to) <= allowed + 1e-12, "seed {seed}: {} > {allowed}", from.distance(to));
        let apart =
            |posture: &Posture| posture.links[a.index()].point(on_rim).distance(posture.links[b.index()].point(q));
        let allowed = (beyond(a, b, centre_a) + beyond(b, a, centre_b)) * (t - s).abs();
        assert!((apart(&here) - apart(&there)).abs() <= allowed + 1e-12, "seed {seed}: own speed beyond {allowed}");
    }
}

#[test]
fn links_that_no_joint_parts_cannot_move_against_one_another() {
    let still = (1, shift(1.0, 0.0, 0.0), JointMotion::Fixed, JointValue::Constant(0.0));
    let joints = vec![(0, Pose::identity(), turns([0.0, 0.0, 1.0]), planned(0)), still.clone(), still];
    let mechanism = Mechanism::new(&robot(joints, 1, None)).expect("a tree");
    assert!(!mechanism.can_move(LinkId(2), LinkId(3)));
    assert!(mechanism.can_move(LinkId(0), LinkId(3)));
}

fn joint_value(robot: &Robot, q: &[f64], opening: f64, joint: &ModelJoint) -> f64 {
    match joint.value {
        JointValue::Coordinate(id) => q[id.index()],
        JointValue::Finger { scale } => scale * opening,
        JointValue::Mimic { of, multiplier, offset } => {
            multiplier * joint_value(robot, q, opening, &robot.joints[of.index()]) + offset
        }
        JointValue::Constant(value) => value,
    }
}

/// Pose of a link by walking up to the root, in quaternions.
fn walked(robot: &Robot, q: &[f64], opening: f64, link: LinkId) -> Pose {
    let value = |joint: &ModelJoint| joint_value(robot, q, opening, joint);
    let Some(joint) = robot.joints.iter().find(|joint| joint.child == link) else {
        let Some(_) = robot.base else { return robot.world_from_base };
        return robot.world_from_base * shift(q[0], q[1], 0.0) * Isometry3::rotation(nalgebra::Vector3::z() * q[2]);
    };
    let moved = match joint.motion {
        JointMotion::Fixed => Pose::identity(),
        JointMotion::Revolute { axis } => Isometry3::rotation(nalgebra::Vector3::from(axis) * value(joint)),
        JointMotion::Prismatic { axis: [x, y, z] } => shift(x * value(joint), y * value(joint), z * value(joint)),
    };
    walked(robot, q, opening, joint.parent) * joint.parent_from_joint * moved
}

#[test]
fn links_of_the_shipped_robots_are_where_walking_up_their_joints_puts_them() {
    for scene in ["t00_one_arm", "t01_one_robot"] {
        let path = format!("{}/../../launch/scenes/{scene}.yaml", env!("CARGO_MANIFEST_DIR"));
        let problem = model::load_problem(&model::DiskFiles, &path).expect("a valid problem");
        let robot = &problem.robots[0];
        let (mechanism, mut posture) = (Mechanism::new(robot).expect("a tree"), Posture::default());
        for seed in 0..100 {
            let mut random = Random(seed);
            let q: Vec<f64> = robot.coordinates.iter().map(|_| random.between(-2.0, 2.0)).collect();
            mechanism.place(&q, 0.06, &mut posture);
            for link in (0..robot.links.len()).map(LinkId::at) {
                let (distance, angle) =
                    posture.links[link.index()].difference(&Frame::of(&walked(robot, &q, 0.06, link)));
                assert!(distance < 1e-12 && angle < 1e-12, "seed {seed}, link {link:?}: {distance} m, {angle} rad");
            }
        }
    }
}
