//! The hand alone: what it touches, every configuration touches that brings it there, and nothing else of the robot counts.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod common;

use collision::{AllowedContacts, BodyName, Geometry, Holding, Standing};
use common::*;
use model::{FixedId, LinkId, ObjectId, Pose, Problem, Robot, RobotId};

/// Whether only fingers are between a link and the end effector's parent link: then it rides with the hand.
fn rides_with_hand(robot: &Robot, link: LinkId) -> bool {
    let parent = robot.end_effector.parent_link;
    let is_finger = |value: &model::JointValue| matches!(value, model::JointValue::Finger { .. });
    let is_stiff = |joint: &model::Joint| match &joint.value {
        model::JointValue::Mimic { of, .. } => is_finger(&robot.joints[of.index()].value),
        value => is_finger(value) || matches!(joint.motion, model::JointMotion::Fixed),
    };
    let root_of = |mut link: LinkId| {
        while let Some(joint) = robot.joints.iter().find(|joint| joint.child == link && is_stiff(joint)) {
            link = joint.parent;
        }
        link
    };
    root_of(link) == root_of(parent)
}

/// The bodies of the hand and its load by the oracle, where a configuration brings them.
fn hand_pieces(problem: &Problem, robot: RobotId, holding: Option<Holding>, q: &[f64]) -> Vec<Piece> {
    let is_hand = |piece: &Piece| match piece.name {
        BodyName::Link { link, .. } => rides_with_hand(problem.robot(robot), link),
        BodyName::Held { .. } => true,
        BodyName::Fixed(_) | BodyName::Object(_) => false,
    };
    Oracle(problem).robot(robot, holding, q).into_iter().filter(is_hand).collect()
}

fn world_from_link(problem: &Problem, robot: RobotId, q: &[f64]) -> Pose {
    let robot = problem.robot(robot);
    kinematics::link_pose(robot, q, robot.end_effector.parent_link)
}

fn random_allowed(problem: &Problem, random: &mut Random) -> AllowedContacts {
    AllowedContacts {
        touch: (random.pick(2) == 0).then(|| ObjectId::at(random.pick(problem.movable.len()))),
        support: (random.pick(2) == 0).then(|| FixedId::at(random.pick(problem.fixed.len()))),
    }
}

fn scenes() -> [(Problem, f64); 2] {
    [(mobile_problem(), 1.0), (figure1(), 2.0)]
}

#[test]
fn the_hand_touches_fixed_objects_where_parry_says_so_and_then_every_configuration_does() {
    for (problem, scale) in scenes() {
        let (geometry, oracle) = (Geometry::new(&problem).unwrap(), Oracle(&problem));
        let clearance = problem.settings.clearance;
        let (mut free, mut hit) = (0, 0);
        for seed in 0..3000 {
            let mut random = Random(seed);
            let robot = RobotId::at(random.pick(problem.robots.len()));
            let mut q = random_configuration(problem.robot(robot), &mut random);
            q[..2].iter_mut().for_each(|x| *x *= scale);
            let holding = random_holding(&problem, &mut random);
            let link = world_from_link(&problem, robot, &q);
            let none = AllowedContacts::default();
            let least = least_distance(&hand_pieces(&problem, robot, holding, &q), &oracle.fixed());
            let contact = geometry.hand_contact(robot, holding, &link, none);
            let agrees = if contact.is_some() { least < clearance + PARRY } else { least >= clearance - PARRY };
            assert!(agrees, "seed {seed}: {contact:?} at {least} m");
            *if contact.is_some() { &mut hit } else { &mut free } += 1;
            let allowed = random_allowed(&problem, &mut random);
            if geometry.hand_contact(robot, holding, &link, allowed).is_some() {
                let whole = geometry.state_contact(robot, holding, &q, allowed);
                assert!(whole.is_some(), "seed {seed}: the hand touches something, the robot nothing");
            }
        }
        assert!(free > 100 && hit > 30, "{free} free, {hit} in contact");
    }
}

#[test]
fn the_hand_touches_standing_objects_where_parry_says_so_and_then_every_configuration_does() {
    for (problem, _) in scenes() {
        let (geometry, oracle) = (Geometry::new(&problem).unwrap(), Oracle(&problem));
        let clearance = problem.settings.clearance;
        let (mut free, mut hit, mut spared) = (0, 0, 0);
        for seed in 0..3000 {
            let mut random = Random(seed + 5_000_000);
            let robot = RobotId::at(random.pick(problem.robots.len()));
            let q = random_configuration(problem.robot(robot), &mut random);
            let object = ObjectId::at(random.pick(problem.movable.len()));
            let holding = random_holding(&problem, &mut random).filter(|holding| holding.object != object);
            let link = world_from_link(&problem, robot, &q);
            let hand = hand_pieces(&problem, robot, holding, &q);
            let near = hand[random.pick(hand.len())].pose.translation;
            let standing = Standing { object, world_from_object: near * random.pose(0.15) };
            let least = least_distance(&hand, &[oracle.standing(&standing)]);
            let none = AllowedContacts::default();
            let hits = geometry.hand_hits(robot, holding, &link, none, &standing).is_some();
            let agrees = if hits { least < clearance + PARRY } else { least >= clearance - PARRY };
            assert!(agrees, "seed {seed}: hits {hits} at {least} m");
            *if hits { &mut hit } else { &mut free } += 1;
            let allowed = random_allowed(&problem, &mut random);
            if geometry.hand_hits(robot, holding, &link, allowed, &standing).is_some() {
                let whole = geometry.state_hits(robot, holding, &q, allowed, &standing);
                assert!(whole.is_some(), "seed {seed}: the hand touches the object, the robot does not");
            } else {
                spared += u32::from(hits);
            }
        }
        assert!(free > 300 && hit > 300 && spared > 20, "{free} free, {hit} in contact, {spared} allowed");
    }
}
