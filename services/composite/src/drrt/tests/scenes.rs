//! Planted situations: what must be possible, what must not, and what the search must do for it.

use contract::{Commitment, FailureReport, Interrupted, VertexId, encode_canonical};
use model::{ObjectId, Point};
use plan::{BodyRef, Cause};
use skeleton::Occupancy;

use super::super::drrt_with;
use super::stepper::replay;
use super::toy::{Places, Toy, place};

const BUDGET: u64 = 20_000;

fn path(length: usize) -> Vec<(usize, usize, f64)> {
    (1..length).map(|b| (b - 1, b, 1.0)).collect()
}

fn places(edges: Vec<(usize, usize, f64)>, starts: &[usize], tasks: &[(usize, usize, usize, usize)]) -> Places {
    let objects = tasks.iter().map(|task| task.1 + 1).max().unwrap_or(0);
    let (starts, tasks) = (starts.to_vec(), tasks.to_vec());
    Places { edges, starts, tasks, objects, orders: Vec::new(), blocks: Vec::new(), grip_time: 0.5 }
}

fn occupancy(object: usize, hop: u32) -> Occupancy {
    Occupancy { object: ObjectId::at(object), hop }
}

fn solved(toy: &Toy) -> Vec<Commitment> {
    let commitments = toy.solve(BUDGET).unwrap_or_else(|report| panic!("{report:?}"));
    replay(toy, &commitments).unwrap_or_else(|wrong| panic!("{wrong}"));
    commitments
}

fn refused(toy: &Toy) -> FailureReport {
    match toy.solve(200_000) {
        Ok(commitments) => panic!("solved: {commitments:?}"),
        Err(report) => *report,
    }
}

/// Places that a robot passes in a mode, repetitions left out.
fn passed(commitments: &[Commitment], robot: usize, step: u32) -> Vec<usize> {
    let of_mode = commitments.iter().find(|c| c.mode.robot.index() == robot && c.mode.step == step).unwrap();
    let mut places: Vec<usize> = of_mode.moves.iter().flat_map(|m| [place(&m.from), place(&m.to)]).collect();
    places.dedup();
    places
}

fn event_s(commitments: &[Commitment], robot: usize, step: u32) -> f64 {
    commitments.iter().find(|c| c.mode.robot.index() == robot && c.mode.step == step).unwrap().event_s
}

#[test]
fn robots_swap_the_ends_of_a_corridor_by_its_bay() {
    let mut corridor = path(9);
    corridor.push((4, 9, 1.0));
    for seed in 0..20 {
        let toy = places(corridor.clone(), &[0, 8], &[(0, 0, 0, 8), (1, 1, 8, 0)]).toy(seed);
        let commitments = solved(&toy);
        let uses_bay = |robot| (0..3).any(|step| passed(&commitments, robot, step).contains(&9));
        assert!(uses_bay(0) || uses_bay(1), "seed {seed}");
    }
}

#[test]
fn a_corridor_without_a_bay_is_a_definite_no_that_names_both_robots() {
    let toy = places(path(6), &[0, 5], &[(0, 0, 0, 5), (1, 1, 5, 0)]).toy(0);
    let report = refused(&toy);
    let robots = vec!["r0".to_owned(), "r1".to_owned()];
    assert!(report.causes.iter().any(|(cause, _)| *cause == Cause::Deadlock { robots: robots.clone() }), "{report:?}");
    assert!(!report.causes.iter().any(|(cause, _)| matches!(cause, Cause::Budget { .. })), "{report:?}");
}

#[test]
fn robots_swap_rooms_through_a_door() {
    // Rooms 0-3 and 5-8, each a square; 4 is the door.
    let rooms = [(0, 1), (1, 3), (3, 2), (2, 0), (3, 4), (4, 5), (5, 6), (6, 8), (8, 7), (7, 5)];
    let edges: Vec<_> = rooms.iter().map(|(a, b)| (*a, *b, 1.0)).collect();
    for seed in 0..20 {
        solved(&places(edges.clone(), &[0, 8], &[(0, 0, 2, 7), (1, 1, 6, 1)]).toy(seed));
    }
}

#[test]
fn a_robot_backs_out_when_it_shuts_another_in() {
    // 0 is a pocket behind 1; robot 1 has come to 1 on its way into the pocket, where robot 0 is.
    let mut edges = path(4);
    edges.push((2, 4, 1.0));
    let toy = places(edges, &[0, 1], &[(0, 0, 0, 3), (1, 1, 0, 4)]).toy(1);
    let commitments = solved(&toy);
    let way = passed(&commitments, 1, 0);
    assert_eq!(way[..2], [1, 2], "{way:?}");
    assert_eq!(way.last(), Some(&0), "{way:?}");
}

#[test]
fn the_second_of_a_relay_waits_until_the_first_has_released_and_left() {
    let toy = places(path(5), &[0, 4], &[(0, 0, 0, 2), (1, 0, 2, 4)]).toy(3);
    let commitments = solved(&toy);
    let (released, grasped) = (event_s(&commitments, 0, 1), event_s(&commitments, 1, 0));
    // Robot 0 rests 0.5 s, folds its arm and leaves; only then can robot 1 come and reach out.
    assert!(grasped >= released + 0.5 + 0.4 + 1.0 + 1.0 + 0.4 - 1e-9, "{released} {grasped}");
}

#[test]
fn a_finished_robot_moves_aside() {
    // Robot 0 lives in the middle and is done long before robot 1, whose work waits for it, has to pass.
    let mut edges = path(5);
    edges.push((2, 5, 1.0));
    let mut scene = places(edges, &[2, 0], &[(0, 0, 2, 2), (1, 1, 4, 0)]);
    scene.orders = vec![((0, Point::Release), (1, Point::Grasp))];
    for seed in 0..10 {
        let commitments = solved(&scene.toy(seed));
        let home = commitments.iter().find(|c| c.mode.robot.index() == 0 && c.mode.step == 2).unwrap();
        assert!(passed(&commitments, 0, 2).contains(&5) || passed(&commitments, 0, 0).contains(&5));
        assert_eq!(home.moves.last().map(|m| place(&m.to)), Some(2));
    }
}

#[test]
fn a_robot_without_work_stands_where_it_is() {
    let tasks = [(0, 0, 0, 2)];
    let report = refused(&places(path(3), &[0, 1], &tasks).toy(0));
    assert!(
        matches!(&report.causes[0].0, Cause::Deadlock { robots } if robots.contains(&"r0".to_owned())),
        "{report:?}"
    );
    let mut round = path(3);
    round.extend([(0, 3, 1.0), (3, 2, 1.0)]);
    solved(&places(round, &[0, 1], &tasks).toy(0));
}

#[test]
fn a_way_opens_when_the_object_in_it_is_taken() {
    // Object 1 stands in the door at 2 until robot 1 takes it.
    let mut scene = places(path(6), &[0, 4], &[(0, 0, 1, 3), (1, 1, 5, 5)]);
    scene.blocks = vec![(occupancy(1, 0), 2)];
    let commitments = solved(&scene.toy(0));
    assert!(event_s(&commitments, 1, 0) < event_s(&commitments, 0, 1));
}

#[test]
fn an_object_that_never_leaves_the_only_way_is_named() {
    let mut scene = places(path(5), &[0], &[(0, 0, 1, 3)]);
    scene.objects = 2;
    scene.blocks = vec![(occupancy(1, 0), 2)];
    let report = refused(&scene.toy(0));
    let blocking = vec![BodyRef::Object("m1".to_owned())];
    let no_path = Cause::NoPath { pair: Some("p0".to_owned()), robot: "r0".to_owned(), blocking };
    assert!(report.causes.iter().any(|(cause, _)| *cause == no_path), "{report:?}");
}

#[test]
fn nothing_is_placed_on_a_robot() {
    // Robot 0 waits at 1, where its work is, for the very release that would put object 0 on it.
    let mut scene = places(path(4), &[1, 2], &[(1, 0, 2, 3), (1, 0, 3, 2), (0, 1, 1, 0)]);
    scene.blocks = vec![(occupancy(0, 1), 1)];
    scene.orders = vec![((1, Point::Release), (0, Point::Grasp))];
    let commitments = solved(&scene.toy(0));
    let released = event_s(&commitments, 1, 1);
    let mut moves = commitments.iter().filter(|c| c.mode.robot.index() == 0).flat_map(|c| &c.moves);
    let there = moves.find(|m| m.begins_s <= released && released < m.ends_s).unwrap();
    assert_eq!(place(&there.to), 0);
}

#[test]
fn an_order_that_comes_before_the_beginning_is_a_definite_no() {
    let mut scene = places(path(4), &[0, 3], &[(0, 0, 0, 1), (1, 1, 3, 2)]);
    scene.orders = vec![((0, Point::Grasp), (1, Point::Start))];
    let report = refused(&scene.toy(0));
    assert!(!report.causes.iter().any(|(cause, _)| matches!(cause, Cause::Budget { .. })), "{report:?}");
}

#[test]
fn equal_seeds_give_equal_bytes_and_the_budget_is_kept() {
    let mut corridor = path(9);
    corridor.push((4, 9, 1.0));
    let toy = |seed| places(corridor.clone(), &[0, 8], &[(0, 0, 0, 8), (1, 1, 8, 0)]).toy(seed);
    for seed in 0..5 {
        let (first, second) = (toy(seed).solve(BUDGET).unwrap(), toy(seed).solve(BUDGET).unwrap());
        assert_eq!(encode_canonical(&first), encode_canonical(&second));
    }
    for budget in [0, 1, 3, 10, 30] {
        let (outcome, spent) = toy(0).solve_after(&[], budget);
        // The steps of the last connection may go beyond it.
        assert!(spent <= budget + 100, "{spent} of {budget}");
        if let Err(report) = outcome.unwrap() {
            assert!(report.causes.iter().any(|(cause, _)| matches!(cause, Cause::Budget { .. })), "{report:?}");
        }
    }
    let (outcome, _) = toy(0).solve_after(&[], 0);
    assert!(outcome.unwrap().is_err());
}

#[test]
fn a_cancelled_search_has_no_outcome() {
    let toy = places(path(6), &[0, 5], &[(0, 0, 0, 2), (1, 1, 5, 3)]).toy(0);
    let outcome = toy.with_flag(BUDGET, true, |context| {
        drrt_with(&toy.statement, &toy.skeleton, &crate::CommittedMotion::default(), &toy.roadmaps, &toy.table, context)
    });
    assert_eq!(outcome.unwrap_err(), Interrupted::Cancelled);
}

#[test]
fn roadmaps_that_are_not_the_modes_are_refused() {
    let good = || places(path(4), &[0, 3], &[(0, 0, 0, 1)]).toy(0);
    let spoiled: [fn(&mut Toy); 4] = [
        |toy| toy.roadmaps[0].truncate(1),
        |toy| toy.roadmaps[0][1].goal = VertexId(99),
        |toy| toy.roadmaps[0][0].edges[0].duration_s = f64::NAN,
        |toy| toy.roadmaps[0][0].edges[0].blockers = vec![77],
    ];
    for (i, spoil) in spoiled.into_iter().enumerate() {
        let mut toy = good();
        spoil(&mut toy);
        let outcome = toy.solve_after(&[], BUDGET).0;
        assert!(matches!(outcome, Err(Interrupted::Unfit(_))), "{i}");
    }
}
