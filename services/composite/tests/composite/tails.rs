//! Safe tails: without them prioritised planning drives into dead ends.

use contract::{FailureReport, ModeRoadmap};
use model::{GivenOrdering, Point};
use plan::Cause;

use crate::oracle::assert_free;
use crate::toys::{Errand, Toy, World, mode, pair};

/// A corridor of six points with a bay at the third. Robot 1 comes from the left and picks in the corridor; robot 2 must
/// pass there from the right to pick in the bay, and robot 1 may place only after that.
fn corridor() -> Toy {
    let mut world = World::grid(6, 1, 0.7);
    world.points.push([1.4, 0.7]);
    world.ways.push((2, 6));
    world.starts = vec![0, 5];
    world.objects = vec![3, 6];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 3, to: 3 }, Errand { robot: 1, object: 1, from: 6, to: 6 }];
    world.orderings = vec![GivenOrdering { before: (pair(1), Point::Grasp), after: (pair(0), Point::Release) }];
    world.build()
}

/// The next mode's roadmap without edges: the robot can only stay where its event was.
fn staying(roadmap: &mut ModeRoadmap) {
    if roadmap.mode == mode(0, 1) {
        roadmap.edges.clear();
    }
}

#[test]
fn a_robot_that_stays_where_it_finished_blocks_the_other_for_ever() {
    let toy = corridor();
    let outcome = toy.ask(&toy.commit_job(None, mode(0, 0), staying)).unwrap();
    let Ok(contract::Answer::Committed { prefix, .. }) = outcome.result else { panic!("{outcome:?}") };
    let report: FailureReport = toy.commit(Some(prefix), mode(1, 0)).unwrap_err();
    let robots = vec!["r1".to_owned(), "r2".to_owned()];
    assert!(report.causes.iter().any(|(cause, _)| *cause == Cause::Deadlock { robots: robots.clone() }), "{report:?}");
}

#[test]
fn with_safe_tails_the_same_modes_are_all_committed() {
    let toy = corridor();
    let (prefix, failures) = toy.commit_all(|commitments| assert_free(&toy, commitments, "corridor"));
    assert!(toy.is_complete(prefix), "{failures:?}");
}

#[test]
fn a_tail_ends_at_the_best_parking_vertex_that_is_free_for_ever() {
    let toy = corridor();
    let (prefix, _) = toy.commit(None, mode(0, 0)).unwrap();
    let commitments = toy.commitments(prefix);
    let tail = &commitments[0].tail;
    assert_eq!(tail.last().unwrap().to, toy.problem().robots[0].start);
    assert_eq!(tail.first().unwrap().begins_s, commitments[0].event_s);
}

#[test]
fn a_closing_return_ends_where_the_robot_may_stand_for_ever() {
    let toy = corridor();
    let (prefix, _) = toy.commit_all(|_| ());
    let commitments = toy.commitments(prefix.unwrap());
    for (r, robot) in toy.problem().robots.iter().enumerate() {
        let last = commitments.iter().rfind(|c| c.mode.robot.index() == r).unwrap();
        assert!(last.tail.is_empty());
        assert_eq!(last.moves.last().unwrap().to, robot.start);
    }
}

#[test]
fn a_goal_under_another_robots_start_is_a_deadlock_that_names_it() {
    let mut world = World::grid(4, 1, 0.7);
    world.starts = vec![0, 3];
    world.objects = vec![2];
    world.errands = vec![Errand { robot: 0, object: 0, from: 2, to: 1 }];
    let report = world.build().commit(None, mode(0, 0));
    // Beside the other robot's start there is room.
    assert!(report.is_ok());
    let mut world = World::grid(4, 1, 0.7);
    world.starts = vec![0, 2];
    world.objects = vec![3];
    world.errands = vec![Errand { robot: 0, object: 0, from: 3, to: 1 }];
    let report = world.build().commit(None, mode(0, 0)).unwrap_err();
    assert_eq!(report.causes[0].0, Cause::Deadlock { robots: vec!["r1".into(), "r2".into()] });
}

#[test]
fn an_object_in_a_corridor_leaves_no_path_and_is_named() {
    let mut world = World::grid(4, 1, 0.7);
    world.starts = vec![0];
    world.objects = vec![3, 1];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 3, to: 2 }, Errand { robot: 0, object: 1, from: 1, to: 0 }];
    let report = world.build().commit(None, mode(0, 0)).unwrap_err();
    let blocking = vec![plan::BodyRef::Object("m2".into())];
    let expected = Cause::NoPath { pair: Some("r1.1".into()), robot: "r1".into(), blocking };
    assert_eq!(report.causes[0].0, expected);
}
