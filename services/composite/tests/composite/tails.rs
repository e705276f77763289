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
fn a_goal_under_another_robots_start_is_a_deadlock_or_no_path_if_that_robot_never_moves() {
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
    let report = world.clone().build().commit(None, mode(0, 0)).unwrap_err();
    let blocking = vec![plan::BodyRef::Link { robot: "r2".into(), link: "body".into() }];
    assert_eq!(report.causes, [(Cause::NoPath { pair: Some("r1.1".into()), robot: "r1".into(), blocking }, 1)]);
    // Somewhere else robot 2 has something to do.
    world.points.push([0.0, 5.0]);
    world.objects.push(4);
    world.errands.push(Errand { robot: 1, object: 1, from: 4, to: 4 });
    let report = world.build().commit(None, mode(0, 0)).unwrap_err();
    assert_eq!(report.causes, [(Cause::Deadlock { robots: vec!["r1".into(), "r2".into()] }, 1)]);
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

/// Commits modes in this order, all of them, on roadmaps edited like this.
fn commit_in_order(
    toy: &Toy,
    modes: &[(usize, u32)],
    edit: impl Fn(&mut ModeRoadmap) + Copy,
) -> Vec<contract::Commitment> {
    let mut prefix = None;
    for (robot, step) in modes {
        let outcome = toy.ask(&toy.commit_job(prefix, mode(*robot, *step), edit)).unwrap();
        let Ok(contract::Answer::Committed { prefix: longer, .. }) = outcome.result else { panic!("{outcome:?}") };
        prefix = Some(longer);
    }
    toy.commitments(prefix.unwrap())
}

/// Two lines that cross at vertex 2: robot 1's from left to right, robot 2's from top to bottom.
fn cross(left: f64, top: f64) -> World {
    let points = vec![[-left, 0.0], [0.7, 0.0], [0.0, 0.0], [0.0, top], [0.0, -0.7], [0.0, -1.4]];
    World { points, ways: vec![(0, 2), (2, 1), (3, 2), (2, 4), (4, 5)], starts: vec![0, 3], ..World::default() }
}

#[test]
fn a_hand_does_not_pause_where_somebody_is_about_to_pass() {
    // Robot 1 could be at the crossing at 1.4 s, but robot 2 passes at 2.1 s, before the pause is over.
    let mut world = cross(1.4, 2.1);
    world.objects = vec![2, 5];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 2, to: 2 }, Errand { robot: 1, object: 1, from: 5, to: 5 }];
    world.grip_time = 0.5;
    let toy = world.build();
    let commitments = commit_in_order(&toy, &[(1, 0), (0, 0)], |_| ());
    assert!(commitments[1].event_s > 2.5, "{} s", commitments[1].event_s);
    assert_free(&toy, &commitments, "pause");
}

#[test]
fn a_return_waits_until_nobody_will_pass_its_end_any_more() {
    // Robot 1 starts at the crossing. Robot 2 will pass it while robot 1 is away.
    let mut world = cross(1.4, 2.1);
    world.starts = vec![2, 3];
    world.objects = vec![1, 5];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 1, to: 1 }, Errand { robot: 1, object: 1, from: 5, to: 5 }];
    let toy = world.build();
    let aside = |roadmap: &mut ModeRoadmap| {
        if roadmap.mode.robot.index() == 0 {
            roadmap.parking = vec![contract::VertexId(1)];
        }
    };
    let commitments = commit_in_order(&toy, &[(0, 0), (0, 1), (1, 0), (1, 1), (1, 2), (0, 2)], aside);
    assert_free(&toy, &commitments, "return");
    let back = commitments.last().unwrap();
    assert!(back.event_s > commitments[4].moves.last().unwrap().begins_s, "returned at {} s", back.event_s);
}

#[test]
fn nobody_parks_where_an_object_will_stand() {
    // Robot 2 puts an object next to where robot 1 would park best.
    let mut world = cross(0.7, 0.7);
    world.points.push([-0.35, -0.7]);
    world.ways.push((5, 6));
    world.objects = vec![2, 5];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 2, to: 2 }, Errand { robot: 1, object: 1, from: 5, to: 6 }];
    let toy = world.build();
    let below = |roadmap: &mut ModeRoadmap| {
        let parking = if roadmap.mode.robot.index() == 0 { 4 } else { 3 };
        roadmap.parking = vec![contract::VertexId(parking)];
    };
    let commitments = commit_in_order(&toy, &[(1, 0), (1, 1), (0, 0)], below);
    assert_free(&toy, &commitments, "parking");
    assert!(commitments[2].tail.last().is_none_or(|last| last.to != vec![0.0, -0.7, 0.0]));
    let undisturbed = commit_in_order(&toy, &[(0, 0)], below);
    assert_eq!(undisturbed[0].tail.last().unwrap().to, vec![0.0, -0.7, 0.0]);
}

#[test]
fn one_long_drive_is_late_enough_for_all_who_cross_it() {
    // On time robot 1 would meet robot 3 at 2.8 m; a little later robot 2 at 1.4 m.
    let points = vec![[0.0, 0.0], [4.2, 0.0], [1.4, 2.4], [1.4, -2.4], [2.8, 2.8], [2.8, -2.8]];
    let mut world = World { points, ways: vec![(0, 1), (2, 3), (4, 5)], starts: vec![0, 2, 4], ..World::default() };
    world.objects = vec![1, 3, 5];
    world.errands = (0..3).map(|r| Errand { robot: r, object: r, from: 2 * r + 1, to: 2 * r + 1 }).collect();
    let toy = world.build();
    let commitments = commit_in_order(&toy, &[(1, 0), (2, 0), (0, 0)], |_| ());
    assert_free(&toy, &commitments, "long drive");
    assert!(commitments[2].event_s > 4.2 + 1.0, "{} s", commitments[2].event_s);
}
