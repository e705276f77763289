//! Orderings between points of pairs are kept, whichever points they name.

use contract::{Move, ProductRef};
use model::{GivenOrdering, PairId, Point};
use plan::{EventKind, Plan, RobotTrajectory, SegmentKind};

use crate::oracle::assert_free;
use crate::toys::{Errand, Toy, World, mode, pair};

/// Two robots with two errands each, far enough apart to be independent.
fn two_robots(arms: bool, grip_time: f64) -> World {
    let mut world = World::grid(4, 4, 0.7);
    world.starts = vec![0, 12];
    world.objects = vec![1, 4, 9, 10];
    world.errands = vec![
        Errand { robot: 0, object: 0, from: 1, to: 2 },
        Errand { robot: 0, object: 1, from: 4, to: 5 },
        Errand { robot: 1, object: 2, from: 9, to: 8 },
        Errand { robot: 1, object: 3, from: 10, to: 14 },
    ];
    (world.arms, world.grip_time) = (arms, grip_time);
    world
}

/// Time of a point (s), from the plan alone.
fn time_of(toy: &Toy, plan: &Plan, pair: PairId, point: Point) -> f64 {
    let problem = toy.problem();
    let robot = problem.pair(pair).robot;
    let trajectory = &plan.robots[robot.index()];
    let name = &problem.pair(pair).name;
    let event = |kind| plan.events.iter().find(|e| e.pair == *name && e.kind == kind).unwrap();
    let (attach, detach) = (event(EventKind::Attach), event(EventKind::Detach));
    let folded = |from: usize, to: usize| {
        let retract = |s: &&plan::Segment| {
            s.kind == SegmentKind::Retract && s.pair.as_ref() == Some(name) && s.from >= from && s.to <= to
        };
        trajectory.knots[trajectory.segments.iter().rfind(retract).unwrap().to].t
    };
    let start = || match problem.pairs_of_robot(robot).take_while(|other| *other != pair).last() {
        Some(before) => time_of(toy, plan, before, Point::Done),
        None => 0.0,
    };
    match point {
        Point::Start => start(),
        Point::AtPick => arrival(trajectory, attach.knot).max(start()),
        Point::Grasp => attach.t,
        Point::Carry => folded(attach.knot, detach.knot),
        Point::AtPlace => arrival(trajectory, detach.knot).max(folded(attach.knot, detach.knot)),
        Point::Release => detach.t,
        Point::Done => folded(detach.knot, usize::MAX),
    }
}

/// When the base came to where it is at a knot (s).
fn arrival(trajectory: &RobotTrajectory, knot: usize) -> f64 {
    let stand = &trajectory.knots[knot].q[..3];
    let first = (0..=knot).rev().take_while(|k| trajectory.knots[*k].q[..3] == *stand).last().unwrap();
    trajectory.knots[first].t
}

/// Plans with one ordering; `None` if it cannot be.
fn plan_with(world: &World, before: (PairId, Point), after: (PairId, Point)) -> Option<(Toy, Plan)> {
    let mut world = world.clone();
    world.orderings = vec![GivenOrdering { before, after }];
    let toy = world.build();
    let (prefix, _) = toy.commit_all(|_| ());
    let prefix = prefix.filter(|prefix| toy.is_complete(Some(*prefix)))?;
    let plan = toy.assemble(prefix);
    assert_free(&toy, &toy.commitments(prefix), &format!("{before:?} before {after:?}"));
    Some((toy, plan))
}

#[test]
fn every_ordering_of_points_of_armed_robots_is_kept_in_the_plan() {
    let mut binding = 0;
    for (grip_time, before_pair, after_pair) in [(0.0, 1, 2), (0.5, 1, 3), (0.5, 0, 3)] {
        let world = two_robots(true, grip_time);
        for first in Point::ALL {
            for second in Point::ALL {
                let (before, after) = ((pair(before_pair), first), (pair(after_pair), second));
                let Some((toy, plan)) = plan_with(&world, before, after) else {
                    assert!(after_pair == 2 && second == Point::Start, "{before:?} before {after:?} was not planned");
                    continue;
                };
                let (before_s, after_s) =
                    (time_of(&toy, &plan, before.0, first), time_of(&toy, &plan, after.0, second));
                assert!(before_s + 1e-9 < after_s, "{before:?} at {before_s} s, {after:?} at {after_s} s");
                binding += usize::from(!plan.dependencies.is_empty());
            }
        }
    }
    assert!(binding > 100, "{binding} plans needed an arc");
}

#[test]
fn orderings_of_grasps_and_releases_are_kept_by_robots_without_arms() {
    let world = two_robots(false, 0.5);
    for first in [Point::Grasp, Point::Release, Point::Done] {
        for second in [Point::Grasp, Point::Release] {
            let (before, after) = ((pair(1), first), (pair(2), second));
            let (toy, plan) = plan_with(&world, before, after).unwrap();
            let (before_s, after_s) = (time_of(&toy, &plan, before.0, first), time_of(&toy, &plan, after.0, second));
            assert!(before_s + 1e-9 < after_s, "{first:?} at {before_s} s, {second:?} at {after_s} s");
        }
    }
}

#[test]
fn what_others_count_on_in_a_tail_is_kept_by_the_next_commitment() {
    let mut world = two_robots(true, 0.5);
    world.objects[1] = 6;
    world.errands[1].from = 6;
    let (before, after) = ((pair(0), Point::Done), (pair(2), Point::Grasp));
    world.orderings = vec![GivenOrdering { before, after }];
    let toy = world.build();
    // From where robot 1 places it can also go straight to where it picks next, its hand down all the way.
    let shortcut = |roadmap: &mut contract::ModeRoadmap| {
        if roadmap.mode == mode(0, 2) {
            let (a, b, allowed) = (roadmap.start, roadmap.goal, Default::default());
            let kind = contract::EdgeKind::Base;
            roadmap.edges.push(contract::Edge { a, b, kind, allowed, duration_s: 0.7, blockers: vec![] });
        }
    };
    let commit = |prefix, mode| {
        let outcome = toy.ask(&toy.commit_job(prefix, mode, shortcut)).unwrap();
        let Ok(contract::Answer::Committed { prefix, .. }) = outcome.result else { panic!("{outcome:?}") };
        Some(prefix)
    };
    let prefix = commit(commit(None, mode(0, 0)), mode(0, 1));
    let tail = toy.commitments(prefix.unwrap())[1].tail.clone();
    let moves = |prefix: Option<ProductRef>| toy.commitments(prefix.unwrap()).last().unwrap().moves.clone();
    let folded_s =
        |moves: &[Move]| moves.iter().find(|step| step.from[3] != 0.0 && step.to[3] == 0.0).map(|step| step.ends_s);
    let alone = commit(prefix, mode(0, 2));
    assert_eq!(folded_s(&moves(alone)), None, "nobody counts on it, and the hand stays down");
    let both = commit(commit(prefix, mode(1, 0)), mode(0, 2));
    assert!(folded_s(&tail).is_some());
    assert_eq!(folded_s(&moves(both)), folded_s(&tail), "the grasp of r2.1 was committed after `done` of r1.1");
}

#[test]
fn a_tail_that_comes_too_early_for_its_own_orderings_is_not_counted_on() {
    let mut world = two_robots(true, 0.0);
    world.errands[2].to = 15;
    let order = |before, after| GivenOrdering { before, after };
    let (late, done, next) = ((pair(2), Point::Release), (pair(0), Point::Done), (pair(3), Point::Grasp));
    world.orderings = vec![order(late, done), order(done, next)];
    let toy = world.build();
    let (prefix, failures) = toy.commit_all(|commitments| assert_free(&toy, commitments, "early tail"));
    assert!(toy.is_complete(prefix), "{failures:?}");
    let plan = toy.assemble(prefix.unwrap());
    let times = [late, done, next].map(|(pair, point)| time_of(&toy, &plan, pair, point));
    assert!(times[0] + 1e-9 < times[1] && times[1] + 1e-9 < times[2], "{times:?}");
}

#[test]
fn a_chain_of_orderings_round_a_robot_that_waits_is_kept() {
    let mut world = two_robots(true, 0.0);
    let order = |before, after| GivenOrdering { before, after };
    world.orderings = vec![
        order((pair(0), Point::Release), (pair(2), Point::Grasp)),
        order((pair(2), Point::Carry), (pair(1), Point::AtPick)),
        order((pair(1), Point::AtPlace), (pair(3), Point::Start)),
    ];
    let orderings = world.orderings.clone();
    let toy = world.build();
    let (prefix, failures) = toy.commit_all(|commitments| assert_free(&toy, commitments, "chain"));
    assert!(toy.is_complete(prefix), "{failures:?}");
    let plan = toy.assemble(prefix.unwrap());
    for GivenOrdering { before, after } in orderings {
        let times = [before, after].map(|(pair, point)| time_of(&toy, &plan, pair, point));
        assert!(times[0] + 1e-9 < times[1], "{before:?} {after:?} {times:?}");
    }
}
