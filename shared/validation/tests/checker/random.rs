//! The continuous check against dense sampling, on random robots that carry random objects among random obstacles.

use model::{
    Coordinate, CoordinateId, EndEffector, FixedObject, Joint, JointId, JointMotion, JointValue, Link, LinkId,
    PlanarBase, Pose, Problem, Robot,
};
use nalgebra::Isometry3;
use plan::{EventKind, Plan};
use validation::{Rule, Violation};

use crate::fixture::{Writer, add_object, add_pair, add_table, finish, problem, violations};
use crate::numbers::Random;
use crate::sampling::{link_pose, sampled_clearance};

/// A chain of turning and sliding joints, on a base or not, with a finger and its mimic at the end.
fn random_robot(random: &mut Random, name: &str, x: f64) -> Robot {
    let base = (random.unit() < 0.5).then_some(PlanarBase { speed: 0.8, yaw_rate: 1.5 });
    let first = if base.is_some() { 3 } else { 0 };
    let links: Vec<Link> = (0..7).map(|i| Link { name: format!("l{i}"), bodies: vec![random.body(0.3)] }).collect();
    let mut joints = Vec::new();
    for i in 0..6 {
        let axis = random.direction().to_array();
        let turns = random.unit() < 0.7 && i < 4;
        joints.push(Joint {
            name: format!("j{i}"),
            parent: LinkId::at(i.min(4)),
            child: LinkId::at(i + 1),
            parent_from_joint: random.pose(0.25),
            motion: if turns { JointMotion::Revolute { axis } } else { JointMotion::Prismatic { axis } },
            value: match i {
                4 => JointValue::Finger { scale: 0.5 },
                5 => JointValue::Mimic { of: JointId(random.below(5) as u32), multiplier: -0.5, offset: 0.02 },
                _ => JointValue::Coordinate(CoordinateId::at(first + i)),
            },
        });
    }
    let unbounded =
        |i: usize| Coordinate { name: format!("c{i}"), lower: f64::NEG_INFINITY, upper: f64::INFINITY, velocity: 1.0 };
    let start: Vec<f64> = (0..first + 4).map(|_| random.between(-0.5, 0.5)).collect();
    let mut disabled_pairs: Vec<(LinkId, LinkId)> = joints.iter().map(|j| (j.parent, j.child)).collect();
    disabled_pairs.push((LinkId(5), LinkId(6)));
    // Most of these tangles hit themselves at once: leave only one pair to test.
    (0..7).for_each(|b| (0..b).filter(|a| (*a, b) != (1, 4)).for_each(|a| disabled_pairs.push((LinkId(a), LinkId(b)))));
    Robot {
        name: name.to_owned(),
        world_from_base: Isometry3::translation(x, 0.0, 0.0) * random.pose(0.2),
        links,
        joints,
        coordinates: (0..first + 4).map(unbounded).collect(),
        base,
        end_effector: EndEffector {
            name: "hand".to_owned(),
            parent_link: LinkId(4),
            link_from_tool: Pose::identity(),
            links: [LinkId(4), LinkId(5), LinkId(6)].to_vec(),
            max_opening: 0.1,
        },
        disabled_pairs,
        home: start[first..].to_vec(),
        carry: start[first..].to_vec(),
        start,
    }
}

/// Opening of a hand that holds (m).
pub const HELD: f64 = 0.05;

/// Two robots wander among three fixed bodies; on its second way of three the first carries an object, from and to nowhere.
fn random_case(random: &mut Random) -> (Problem, Plan) {
    let robots = vec![random_robot(random, "a", -0.7), random_robot(random, "b", 0.7)];
    let mut problem = problem(robots);
    for i in 0..3 {
        let away = Isometry3::translation(random.between(-1.5, 1.5), random.between(0.4, 1.5), 0.0);
        problem.fixed.push(FixedObject {
            name: format!("f{i}"),
            world_from_object: away * random.pose(0.2),
            bodies: vec![random.body(0.4)],
        });
    }
    // What the object is said to stand on is far away, so that no contact with it is allowed.
    let nowhere = add_table(&mut problem, "nowhere", 50.0, 0.0);
    problem.settings.grip_time = 0.0;
    let ways: Vec<Vec<Vec<f64>>> = problem
        .robots
        .iter()
        .map(|robot| {
            let near = |random: &mut Random| robot.start.iter().map(|s| s + random.between(-0.8, 0.8)).collect();
            (0..3).map(|_| near(random)).collect()
        })
        .collect();
    let grasp = Isometry3::translation(0.0, 0.0, 0.3) * random.pose(0.1);
    let body = random.body(0.2);
    let [taken, put] = [0, 1].map(|way| link_pose(&problem.robots[0], &ways[0][way], HELD, 4) * grasp);
    let object = add_object(&mut problem, "m", 0.0, 0.0, nowhere);
    (problem.movable[0].body, problem.movable[0].world_from_start) = (body, taken);
    let pair = add_pair(&mut problem, 0, object, nowhere, nowhere);
    let mut writers = Vec::new();
    for robot in 0..2 {
        let mut writer = Writer::new(&problem, robot);
        writer.begin((robot == 0).then_some(pair));
        for (i, q) in ways[robot].iter().enumerate() {
            writer.go(plan::SegmentKind::Reach, q);
            match i {
                0 if robot == 0 => drop(writer.grip(EventKind::Attach, 0.0, 0.0)),
                1 if robot == 0 => drop(writer.grip(EventKind::Detach, 0.0, 0.0)),
                _ => {}
            }
        }
        writers.push(writer);
    }
    let mut plan = finish(&problem, writers);
    for (event, pose) in plan.events.iter_mut().zip([taken, put]) {
        (event.link_from_object, event.world_from_object, event.opening) = (grasp.into(), pose.into(), HELD);
    }
    (problem, plan)
}

#[test]
fn nothing_is_accepted_that_sampling_refutes_and_nothing_refused_that_is_free() {
    let (mut refuted, mut free, mut held) = (0, 0, 0);
    for seed in 0..200 {
        let (problem, plan) = random_case(&mut Random(seed));
        let found = violations(&problem, &plan);
        let meets = found.iter().any(|violation| violation.rule == Rule::V11);
        // The grasp is not listed, the object hangs in the air, the hand may brush it early, and all end anywhere.
        let idle = |v: &Violation| matches!(v.rule, Rule::V5 | Rule::V6 | Rule::V7 | Rule::V12 | Rule::V13);
        assert!(found.iter().all(|v| v.rule == Rule::V11 || idle(v)), "seed {seed}: {:?}", found[0]);
        let even = (0..=300).map(|i| plan.makespan.total_s * f64::from(i) / 300.0);
        let clearance = sampled_clearance(&problem, &plan, even);
        assert!(meets || clearance > 0.0, "seed {seed}: accepted, but sampling finds bodies that meet");
        // Parry's own distances are this far above the true ones where surfaces are curved.
        for violation in found.iter().filter(|v| v.rule == Rule::V11) {
            let there = sampled_clearance(&problem, &plan, violation.t.into_iter());
            assert!(there < 3e-5, "seed {seed}: the sampled clearance there is {there}: {violation}");
            held += usize::from(violation.message.contains("held by"));
        }
        refuted += usize::from(clearance <= 0.0);
        free += usize::from(!meets);
    }
    assert!(refuted >= 80 && free >= 20 && held >= 20, "{refuted}, {free}, {held}: the cases prove too little");
}
