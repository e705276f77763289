//! Alternatives of real scenes, checked by forward kinematics and direct geometry questions.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod common;

use collision::Geometry;
use common::{alternatives, ask, first_hops, job, middle_of_target, scene, statement};
use contract::{Alternative, Reach, Request};
use kinematics::link_pose;
use model::{AllowedContacts, Holding, PairId, Pose};
use nalgebra::{Translation3, Vector3};
use transition::TransitionStage;

fn check_reach(geometry: &Geometry, pair: PairId, alternative: &Alternative, reach: &Reach, world_from_object: &Pose) {
    let problem = geometry.problem();
    let pair = problem.pair(pair);
    let robot = problem.robot(pair.robot);
    let grasp = problem.movable[pair.object.index()].grasp(pair.robot, alternative.grasp);
    let world_from_link = link_pose(robot, &reach.at_object, robot.end_effector.parent_link);
    let held = world_from_link * grasp.link_from_object;
    assert!((held.translation.vector - world_from_object.translation.vector).norm() < 1e-6);
    assert!(held.rotation.angle_to(&world_from_object.rotation) < 1e-6);
    let hand = |q: &Vec<f64>| link_pose(robot, q, robot.end_effector.parent_link).translation.vector;
    let axis = world_from_link.rotation * Vector3::from(grasp.approach);
    let backed = hand(reach.approach.last().unwrap()) - hand(&reach.at_object);
    assert!((backed + axis * problem.settings.approach).norm() < 1e-5);
    let lifted = hand(&reach.lift[reach.lift_up as usize]) - hand(&reach.at_object);
    assert!((lifted - Vector3::z() * problem.settings.lift).norm() < 1e-5);
    let holding = Some(Holding { object: pair.object, grasp: alternative.grasp });
    let far = reach.lift.last().unwrap();
    assert_eq!(geometry.state_contact(pair.robot, holding, far, AllowedContacts::default()), None);
    for q in reach.approach.iter().chain(&reach.lift) {
        for (value, coordinate) in q.iter().zip(&robot.coordinates) {
            assert!((coordinate.lower..=coordinate.upper).contains(value), "{} = {value}", coordinate.name);
        }
        assert_eq!(q[..reach.stand.len()], reach.stand[..]);
    }
}

fn check_scene(name: &str) {
    let problem = scene(name);
    let geometry = Geometry::new(&problem).unwrap();
    let statement = statement(problem.clone());
    let stage = TransitionStage::new(&statement).unwrap();
    for pair in first_hops(&problem) {
        let outcome = ask(&stage, &statement, &job(&problem, pair, 12));
        let found = alternatives(outcome);
        assert!(!found.is_empty(), "{name}: no way to do {}", problem.pair(pair).name);
        let from = problem.movable[problem.pair(pair).object.index()].world_from_start;
        for alternative in &found {
            check_reach(&geometry, pair, alternative, &alternative.pick, &from);
            check_reach(&geometry, pair, alternative, &alternative.place, &middle_of_target(&problem, pair));
        }
    }
}

#[test]
fn alternatives_of_the_one_arm_scene_hold_the_object_where_it_stands_at_both_ends() {
    check_scene("t00_one_arm");
}

#[test]
fn alternatives_of_figure_1_hold_the_object_where_it_stands_at_both_ends() {
    check_scene("figure1");
}

#[test]
fn parts_of_the_enumeration_are_parts_of_the_whole_in_any_process() {
    let problem = scene("t00_one_arm");
    let statement = statement(problem.clone());
    let whole =
        alternatives(ask(&TransitionStage::new(&statement).unwrap(), &statement, &job(&problem, PairId(0), 12)));
    let stage = TransitionStage::new(&statement).unwrap();
    let mut part = job(&problem, PairId(0), 4);
    if let Request::Transition(request) = &mut part.request {
        request.first = 3;
    }
    assert_eq!(alternatives(ask(&stage, &statement, &part))[..], whole[3..7]);
}

#[test]
fn an_object_out_of_reach_is_named_with_its_region() {
    let mut problem = scene("t00_one_arm");
    let far = Translation3::new(9.0, 0.0, 0.0);
    problem.movable[0].world_from_start = far * problem.movable[0].world_from_start;
    let statement = statement(problem.clone());
    let outcome = ask(&TransitionStage::new(&statement).unwrap(), &statement, &job(&problem, PairId(0), 1));
    let causes = outcome.result.unwrap_err().causes;
    let region = problem.regions[problem.pairs[0].from.index()].name.clone();
    assert!(
        causes
            .iter()
            .any(|(cause, _)| matches!(cause, plan::Cause::Unreachable { region: named, .. } if *named == region))
    );
}
