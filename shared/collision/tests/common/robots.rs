//! Small robots.

use model::{
    Body, Coordinate, CoordinateId, EndEffector, Joint, JointMotion, JointValue, Link, LinkId, PlanarBase, Pose, Robot,
    Shape,
};
use nalgebra::Point3;

use super::{at, body, boxed};

fn coordinate(name: &str, limit: f64) -> Coordinate {
    Coordinate { name: name.into(), lower: -limit, upper: limit, velocity: 1.0 }
}

fn link(name: &str, bodies: Vec<Body>) -> Link {
    Link { name: name.into(), bodies }
}

fn joint(name: &str, parent: u32, child: u32, offset: Pose, motion: JointMotion, value: JointValue) -> Joint {
    Joint { name: name.into(), parent: LinkId(parent), child: LinkId(child), parent_from_joint: offset, motion, value }
}

fn turning(parent: u32, offset: Pose, axis: [f64; 3], coordinate: u32) -> Joint {
    let value = JointValue::Coordinate(CoordinateId(coordinate));
    joint(&format!("j{coordinate}"), parent, parent + 1, offset, JointMotion::Revolute { axis }, value)
}

fn robot(name: &str, links: Vec<Link>, joints: Vec<Joint>, coordinates: Vec<Coordinate>, hand: EndEffector) -> Robot {
    let count = coordinates.len();
    let disabled_pairs = (1..links.len()).map(|i| (LinkId::at(i - 1), LinkId::at(i))).collect();
    Robot {
        name: name.into(),
        world_from_base: Pose::identity(),
        links,
        joints,
        coordinates,
        base: None,
        end_effector: hand,
        disabled_pairs,
        start: vec![0.0; count],
        home: vec![],
        carry: vec![],
    }
}

fn hand(parent: u32, links: &[u32]) -> EndEffector {
    EndEffector {
        name: "hand".into(),
        parent_link: LinkId(parent),
        link_from_tool: Pose::identity(),
        links: links.iter().map(|i| LinkId(*i)).collect(),
        max_opening: 0.08,
    }
}

/// Two links of 1 m, 0.1 m thick, turning in the plane z = 0 about the world's origin. The second is the hand.
pub fn planar_2r() -> Robot {
    let bar = || vec![boxed(at(0.5, 0.0, 0.0), [1.0, 0.1, 0.1])];
    let links = vec![link("root", vec![]), link("upper", bar()), link("lower", bar())];
    let z = [0.0, 0.0, 1.0];
    let joints = vec![turning(0, Pose::identity(), z, 0), turning(1, at(1.0, 0.0, 0.0), z, 1)];
    robot("arm", links, joints, vec![coordinate("j0", 3.0), coordinate("j1", 3.0)], hand(2, &[2]))
}

/// A box of 0.6 × 0.4 × 0.3 m on a planar base, resting on z = 0.
pub fn box_base(name: &str) -> Robot {
    let links = vec![link("base", vec![boxed(at(0.0, 0.0, 0.15), [0.6, 0.4, 0.3])])];
    let coordinates = ["x", "y", "yaw"].iter().map(|c| coordinate(c, 10.0)).collect();
    let mut base = robot(name, links, vec![], coordinates, hand(0, &[]));
    base.base = Some(PlanarBase { speed: 1.0, yaw_rate: 1.0 });
    base
}

/// A hand without bodies that slides up and down.
pub fn lift() -> Robot {
    let links = vec![link("post", vec![]), link("fork", vec![])];
    let value = JointValue::Coordinate(CoordinateId(0));
    let slide = joint("z", 0, 1, Pose::identity(), JointMotion::Prismatic { axis: [0.0, 0.0, 1.0] }, value);
    robot("lift", links, vec![slide], vec![coordinate("z", 2.0)], hand(1, &[1]))
}

/// Two bars of 1 m that swing about vertical axes 2 m + `gap` apart, each towards the other at angle 0.
pub fn two_bars(gap: f64) -> Robot {
    let bar = |x: f64| vec![boxed(at(x, 0.0, 0.0), [1.0, 0.1, 0.1])];
    let links = vec![link("post", vec![]), link("left", bar(0.5)), link("right", bar(-0.5))];
    let turn = || JointMotion::Revolute { axis: [0.0, 0.0, 1.0] };
    let value = |i| JointValue::Coordinate(CoordinateId(i));
    let joints = vec![
        joint("left", 0, 1, Pose::identity(), turn(), value(0)),
        joint("right", 0, 2, at(2.0 + gap, 0.0, 0.0), turn(), value(1)),
    ];
    let mut bars = robot("bars", links, joints, vec![coordinate("left", 3.0), coordinate("right", 3.0)], hand(2, &[]));
    bars.disabled_pairs.clear();
    bars
}

/// A planar base with a six-joint arm of all kinds of shapes, a wheel that mimics a joint, a hand and two fingers.
pub fn mobile_arm(name: &str) -> Robot {
    let capsule = |z, length| body(at(0.0, 0.0, z), Shape::Capsule { radius: 0.05, length });
    let can = |z, radius, length| body(at(0.0, 0.0, z), Shape::Cylinder { radius, length });
    let elbow = Shape::Hull {
        points: (0..12)
            .map(|i| {
                let turn = f64::from(i % 4) * 1.57 + 0.3;
                let height = f64::from(i / 4);
                Point3::new(0.06 * turn.cos(), 0.06 * turn.sin(), 0.06 + 0.07 * height)
            })
            .collect(),
    };
    let finger = || vec![boxed(at(0.0, 0.0, 0.03), [0.02, 0.01, 0.06])];
    let links = vec![
        link("base", vec![boxed(at(0.0, 0.0, 0.2), [0.5, 0.4, 0.4]), can(0.5, 0.08, 0.2)]),
        link("shoulder", vec![body(at(0.0, 0.0, 0.06), Shape::Sphere { radius: 0.08 })]),
        link("upper", vec![capsule(0.2, 0.2)]),
        link("elbow", vec![body(Pose::identity(), elbow)]),
        link("fore", vec![can(0.14, 0.04, 0.16)]),
        link("wrist", vec![capsule(0.05, 0.04)]),
        link("palm", vec![boxed(at(0.0, 0.0, 0.05), [0.06, 0.14, 0.05])]),
        link("left", finger()),
        link("right", finger()),
        link("flag", vec![boxed(at(0.0, 0.12, 0.0), [0.02, 0.1, 0.06])]),
    ];
    let (y, z) = ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let slide = |y: f64| JointMotion::Prismatic { axis: [0.0, y, 0.0] };
    let flag = JointValue::Mimic { of: model::JointId(1), multiplier: -0.5, offset: 0.2 };
    let joints = vec![
        turning(0, at(0.1, 0.0, 0.62), z, 3),
        turning(1, at(0.0, 0.0, 0.1), y, 4),
        turning(2, at(0.0, 0.0, 0.4), y, 5),
        turning(3, at(0.0, 0.0, 0.25), z, 6),
        turning(4, at(0.0, 0.0, 0.28), y, 7),
        turning(5, at(0.0, 0.0, 0.12), z, 8),
        joint("left", 6, 7, at(0.0, 0.005, 0.075), slide(1.0), JointValue::Finger { scale: 0.5 }),
        joint("right", 6, 8, at(0.0, -0.005, 0.075), slide(-1.0), JointValue::Finger { scale: 0.5 }),
        joint("flag", 2, 9, at(0.0, 0.0, 0.1), JointMotion::Revolute { axis: z }, flag),
    ];
    let mut coordinates: Vec<Coordinate> = ["x", "y", "yaw"].iter().map(|c| coordinate(c, 5.0)).collect();
    coordinates.extend((3..9).map(|i| coordinate(&format!("j{i}"), 2.2)));
    let mut arm = robot(name, links, joints, coordinates, hand(6, &[6, 7, 8]));
    arm.base = Some(PlanarBase { speed: 1.0, yaw_rate: 1.0 });
    arm.disabled_pairs = [(0, 1), (1, 2), (2, 3), (2, 9), (3, 4), (4, 5), (5, 6), (6, 7), (6, 8), (7, 8), (4, 6)]
        .map(|(a, b)| (LinkId(a), LinkId(b)))
        .to_vec();
    arm.disabled_pairs.sort_unstable();
    arm
}
