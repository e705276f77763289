//! A plan of the size of the paper's Figure 1: three mobile manipulators, about a thousand knots each, 150 s.

use model::{
    Body, Coordinate, CoordinateId, EndEffector, Joint, JointMotion, JointValue, Link, LinkId, PlanarBase, Pose,
    Problem, Robot, Shape,
};
use nalgebra::Isometry3;
use plan::{Plan, SegmentKind};
use validation::Rule;

use crate::fixture::{Writer, accepted, add_fixed, add_table, finish, problem, rules};
use crate::random::Random;
use crate::robots::{at, block};

/// Turns of the arm's axes, from the shoulder on: upright and across in turn.
const AXES: [[f64; 3]; 7] = [
    [0.0, 0.0, 1.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];
/// Way from each arm joint to the one before it (m).
const OFFSETS: [f64; 7] = [0.65, 0.24, 0.2, 0.2, 0.2, 0.2, 0.1];
const HOME: [f64; 7] = [0.0, -0.6, 0.0, 2.2, 0.0, 1.0, 0.0];

fn capsule(length: f64) -> Vec<Body> {
    vec![Body {
        owner_from_shape: at(0.0, 0.0, length / 2.0),
        shape: Shape::Capsule { radius: 0.06, length: length - 0.05 },
    }]
}

/// A disc-shaped base, a 7-joint arm, a palm and two fingers: 12 links, 10 coordinates.
fn mobile_manipulator(name: &str, x: f64, y: f64) -> Robot {
    let body = Body { owner_from_shape: at(0.0, 0.0, 0.3), shape: Shape::Cylinder { radius: 0.3, length: 0.5 } };
    let mut links = vec![Link { name: "base".to_owned(), bodies: vec![body] }];
    let mut joints = Vec::new();
    let mut add = |parent: usize,
                   parent_from_joint: Pose,
                   motion: JointMotion,
                   value: JointValue,
                   bodies: Vec<Body>| {
        let child = LinkId::at(links.len());
        let name = format!("l{}", links.len());
        joints.push(Joint { name: name.clone(), parent: LinkId::at(parent), child, parent_from_joint, motion, value });
        links.push(Link { name, bodies });
    };
    for i in 0..7 {
        let value = JointValue::Coordinate(CoordinateId::at(3 + i));
        let bodies = capsule(OFFSETS.get(i + 1).copied().unwrap_or(0.1));
        add(i, at(0.0, 0.0, OFFSETS[i]), JointMotion::Revolute { axis: AXES[i] }, value, bodies);
    }
    add(7, at(0.0, 0.0, 0.12), JointMotion::Fixed, JointValue::Constant(0.0), Vec::new());
    add(
        8,
        at(0.0, 0.0, 0.02),
        JointMotion::Fixed,
        JointValue::Constant(0.0),
        vec![block([0.05, 0.12, 0.04], [0.0; 3])],
    );
    for side in [1.0, -1.0] {
        let slides = JointMotion::Prismatic { axis: [0.0, side, 0.0] };
        let finger = vec![block([0.02, 0.01, 0.05], [0.0, 0.0, 0.045])];
        add(9, at(0.0, side * 0.005, 0.0), slides, JointValue::Finger { scale: 0.5 }, finger);
    }
    let near = |a: usize, b: usize| b - a < 3 || a >= 7;
    let disabled = |b: usize| (0..b).filter(move |a| near(*a, b)).map(move |a| (LinkId::at(a), LinkId::at(b)));
    let disabled_pairs = (0..links.len()).flat_map(disabled).collect();
    let arm = |i: usize| Coordinate { name: format!("j{i}"), lower: -2.9, upper: 2.9, velocity: 1.7 };
    let base = ["x", "y", "yaw"].map(|n| Coordinate {
        name: format!("base/{n}"),
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity: 0.8,
    });
    Robot {
        name: name.to_owned(),
        world_from_base: Isometry3::identity(),
        links,
        joints,
        coordinates: base.into_iter().chain((0..7).map(arm)).collect(),
        base: Some(PlanarBase { speed: 0.8, yaw_rate: 1.5 }),
        end_effector: EndEffector {
            name: "hand".to_owned(),
            parent_link: LinkId(8),
            link_from_tool: Pose::identity(),
            links: [9, 10, 11].map(LinkId::at).to_vec(),
            max_opening: 0.1,
        },
        disabled_pairs,
        start: [&[x, y, 0.0][..], &HOME].concat(),
        home: HOME.to_vec(),
        carry: HOME.to_vec(),
    }
}

fn room() -> Problem {
    let mut problem = problem([0.0, 2.9, 5.8].iter().map(|x| mobile_manipulator(&format!("r{x}"), *x, 0.0)).collect());
    for (name, size, centre) in [
        ("south", [9.0, 0.2, 1.0], [2.9, -1.5, 0.5]),
        ("north", [9.0, 0.2, 1.0], [2.9, 1.9, 0.5]),
        ("west", [0.2, 3.4, 1.0], [-1.6, 0.2, 0.5]),
        ("east", [0.2, 3.4, 1.0], [7.4, 0.2, 0.5]),
        ("shelf", [0.3, 0.3, 0.05], [2.9, 0.8, 1.1]),
    ] {
        add_fixed(&mut problem, name, size, centre);
    }
    for i in 0..5 {
        add_table(&mut problem, &format!("t{i}"), 1.45 * f64::from(i), 1.1);
    }
    problem
}

/// Whether one robot's straight motion is free, by the checker itself.
fn is_free(problem: &Problem, robot: usize, from: &[f64], to: &[f64]) -> bool {
    let mut alone = problem.clone();
    alone.robots = vec![problem.robots[robot].clone()];
    alone.robots[0].start = from.to_vec();
    let mut writer = Writer::new(&alone, 0);
    writer.go(SegmentKind::Reach, to);
    let plan = finish(&alone, vec![writer]);
    !rules(&alone, &plan).contains(&Rule::V11)
}

/// Wanders about its place, base and arm in turn, along motions that are free of fixed obstacles; comes back by the same way.
fn wander<'a>(problem: &'a Problem, robot: usize, knots: usize, random: &mut Random) -> Writer<'a> {
    let start = &problem.robots[robot].start;
    let mut way = vec![start.clone()];
    while way.len() < knots / 2 {
        let from = &way[way.len() - 1];
        let mut to = from.clone();
        if way.len() % 8 < 2 {
            (0..3).for_each(|i| to[i] = start[i] + random.between(-0.4, 0.4));
        } else {
            (3..10).for_each(|i| to[i] = (from[i] + random.between(-0.3, 0.3)).clamp(-2.9, 2.9));
        }
        if is_free(problem, robot, from, &to) {
            way.push(to);
        }
    }
    let mut writer = Writer::new(problem, robot);
    for q in way.iter().chain(way.iter().rev()).skip(1) {
        writer.go(SegmentKind::Reach, q);
    }
    writer
}

fn figure_one() -> (Problem, Plan) {
    let problem = room();
    let writers = (0..3).map(|robot| wander(&problem, robot, 1000, &mut Random(robot as u64))).collect();
    let plan = finish(&problem, writers);
    (problem, plan)
}

#[test]
fn a_plan_of_the_size_of_figure_one_is_checked_with_little_work() {
    let (problem, plan) = figure_one();
    assert!(plan.makespan.total_s > 120.0, "{}", plan.makespan.total_s);
    let verdict = accepted(&problem, &plan);
    println!("{:.1} s of motion: {verdict:?}", plan.makespan.total_s);
    // About 0.1 µs per pair and 1 µs per distance on the machines it was written on.
    assert!(verdict.distances < 2_000_000 && verdict.pairs_tested < 20_000_000, "{verdict:?}");
    let least = verdict.least_clearance;
    assert!(least.robot_fixed.is_some_and(|d| d < 0.05) && least.own.is_some_and(|d| d < 0.05), "{least:?}");
}
