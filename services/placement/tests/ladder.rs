//! The rungs of the test ladder that the placement stage alone decides.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod common;

use common::{ONE_SLOT, Scene, WIDE, candidates, failure, first_candidate, job, orders, shipped, stage};
use contract::{Literal, Soundness};
use model::{Point, Problem};
use plan::{Cause, Certificate, CycleOrigin, PairPoint};
use skeleton::Event;

fn cycle_points(causes: &[(Cause, u64)]) -> Vec<PairPoint> {
    let points = |cause: &Cause| match cause {
        Cause::Cycle { points } => Some(points.clone()),
        _ => None,
    };
    causes.iter().find_map(|(cause, _)| points(cause)).unwrap_or_else(|| panic!("no cycle in {causes:?}"))
}

fn unplaced(causes: &[(Cause, u64)]) -> Vec<(String, String)> {
    let names = |cause: &Cause| match cause {
        Cause::NoPlacement { object, region } => Some((object.clone(), region.clone())),
        _ => None,
    };
    causes.iter().filter_map(|(cause, _)| names(cause)).collect()
}

fn point(pair: &str, point: Point) -> PairPoint {
    PairPoint { pair: pair.into(), point }
}

#[test]
fn t04_a_spacious_region_needs_no_order() {
    let problem = shipped("t04_spacious_region");
    let candidate = first_candidate(&problem);
    assert!(candidate.orders.is_empty(), "{:?}", orders(&problem, &candidate));
}

#[test]
fn t05_a_region_for_one_box_needs_exactly_the_order_that_the_old_one_leaves_first() {
    let problem = shipped("t05_tiny_region");
    let candidate = first_candidate(&problem);
    assert_eq!(orders(&problem, &candidate), ["grasp of r2.1 < release of r1.1"]);
    let overlap = Cause::Overlap { region: "tiny".into(), leaves: "old".into(), comes: "new".into() };
    assert_eq!(candidate.orders[0].cause, overlap);
}

#[test]
fn t06_an_order_that_contradicts_the_needed_one_is_proven_to_be_a_cycle() {
    let mut problem = shipped("t05_tiny_region");
    let [new, old] = ["r1.1", "r2.1"].map(|name| common::pair_id(&problem, name));
    problem.orderings.push(model::GivenOrdering { before: (new, Point::Release), after: (old, Point::Grasp) });
    let report = failure(&problem);
    assert_eq!(report.soundness, Soundness::Hard);
    let mut points = cycle_points(&report.causes);
    points.sort();
    assert_eq!(points, [point("r1.1", Point::Release), point("r2.1", Point::Grasp)]);
    let Some(Certificate::Cycle { exclusions, cycles }) = report.proof() else { panic!("{report:?}") };
    assert_eq!((exclusions.len(), exclusions[0].region.as_str()), (1, "tiny"));
    let origins: Vec<CycleOrigin> = cycles[0].iter().map(|arc| arc.origin).collect();
    assert_eq!(origins, [CycleOrigin::Given, CycleOrigin::Excluded { exclusion: 0 }]);
    assert_eq!(unplaced(&report.causes), [("new".to_owned(), "tiny".to_owned())]);
}

#[test]
fn given_orders_that_contradict_one_another_are_a_proven_cycle() {
    let scene = two_robot_swap().before(("r1.1", Point::Release), ("r2.1", Point::Grasp));
    let report = failure(&scene.before(("r2.1", Point::Release), ("r1.1", Point::Grasp)).0);
    assert_eq!(report.soundness, Soundness::Hard);
    assert!(cycle_points(&report.causes).contains(&point("r2.1", Point::Release)));
}

#[test]
fn t07_three_objects_that_stay_in_a_region_for_two_are_proven_too_many() {
    let crowd = |size| {
        let scene = Scene::new(1).table("from", WIDE).table("to", size);
        let scene = ["a", "b", "c"].into_iter().enumerate().fold(scene, |scene, (i, name)| {
            scene.carton(name, "from", [0.15 * i as f64 - 0.15, 0.0]).moves(1, name, "from", "to")
        });
        scene.0
    };
    let report = failure(&crowd([0.17, 0.07]));
    assert_eq!(report.soundness, Soundness::Hard);
    let all = ["a", "b", "c"].map(|name| (name.to_owned(), "to".to_owned()));
    assert_eq!(unplaced(&report.causes), all);
    let Some(Certificate::Area { stays, together, .. }) = report.proof() else { panic!("{report:?}") };
    assert_eq!((stays.len(), together.len()), (3, 0), "none of them leaves");
    first_candidate(&crowd([0.26, 0.07]));
    // By area alone three would fit here; that no sample shows it is no proof.
    let report = failure(&crowd([0.2, 0.07]));
    assert_eq!(report.soundness, Soundness::Soft { level: 0 });
    assert!(report.causes.iter().any(|(cause, _)| matches!(cause, Cause::Collision { .. })), "{report:?}");
}

#[test]
fn an_object_larger_than_its_region_is_proven_so() {
    let scene = Scene::new(1).table("from", WIDE).table("narrow", [0.5, 0.055]);
    let report = failure(&scene.carton("m", "from", [0.0, 0.0]).moves(1, "m", "from", "narrow").0);
    assert_eq!(report.soundness, Soundness::Hard);
    assert_eq!(unplaced(&report.causes), [("m".to_owned(), "narrow".to_owned())]);
    let certificate = Certificate::ObjectTooLarge { object: "m".into(), region: "narrow".into() };
    assert_eq!(report.proof(), Some(&certificate));
}

fn two_robot_swap() -> Scene {
    let scene = Scene::new(2).table("A", ONE_SLOT).table("B", ONE_SLOT);
    let scene = scene.carton("x", "A", [0.0, 0.0]).carton("y", "B", [0.0, 0.0]);
    scene.moves(1, "x", "A", "B").moves(2, "y", "B", "A")
}

#[test]
fn t09_two_robots_swap_two_objects_by_orders_on_grasps_and_releases() {
    let problem = two_robot_swap().0;
    let candidate = first_candidate(&problem);
    let both = ["grasp of r1.1 < release of r2.1", "grasp of r2.1 < release of r1.1"];
    assert_eq!(orders(&problem, &candidate), both);
}

fn one_robot_swap() -> Scene {
    let scene = Scene::new(1).table("A", ONE_SLOT).table("B", ONE_SLOT).table("C", WIDE);
    scene.carton("x", "A", [0.0, 0.0]).carton("y", "B", [0.0, 0.0])
}

#[test]
fn t10_one_robot_swaps_two_objects_over_a_buffer() {
    let scene = one_robot_swap().moves(1, "x", "A", "C").moves(1, "y", "B", "A").moves(1, "x", "C", "B");
    let candidate = first_candidate(&scene.0);
    // The robot's own course already has every object leave before the next one comes.
    assert!(candidate.orders.is_empty());

    let scene = Scene::new(2).table("A", ONE_SLOT).table("B", ONE_SLOT).table("C", WIDE);
    let scene = scene.carton("x", "A", [0.0, 0.0]).carton("y", "B", [0.0, 0.0]);
    let problem = scene.moves(1, "x", "A", "C").moves(1, "x", "C", "B").moves(2, "y", "B", "A").0;
    let candidate = first_candidate(&problem);
    let both = ["grasp of r1.1 < release of r2.1", "grasp of r2.1 < release of r1.2"];
    assert_eq!(orders(&problem, &candidate), both);
}

#[test]
fn t11_one_robot_cannot_swap_two_objects_without_a_buffer() {
    let report = failure(&one_robot_swap().moves(1, "x", "A", "B").moves(1, "y", "B", "A").0);
    assert_eq!(report.soundness, Soundness::Hard);
    let mut points = cycle_points(&report.causes);
    points.sort();
    assert_eq!(points, [point("r1.1", Point::Release), point("r1.2", Point::Grasp)]);
}

/// Orders of one region each allow, but together forbid.
#[test]
fn a_contradiction_between_regions_is_proven() {
    let scene = two_robot_swap().before(("r1.1", Point::Release), ("r2.1", Point::Release));
    // y must leave B before x comes there, and x leaves A before that: nothing contradicts so far.
    first_candidate(&scene.0);
    let scene = two_robot_swap().before(("r1.1", Point::Carry), ("r2.1", Point::Start));
    first_candidate(&scene.0);
    let report = failure(&scene.before(("r1.1", Point::Release), ("r2.1", Point::AtPick)).0);
    assert_eq!(report.soundness, Soundness::Hard);
}

fn one_slot_buffer(objects: usize) -> Problem {
    let mut scene = Scene::new(2).table("from", WIDE).table("buffer", ONE_SLOT).table("to", WIDE);
    let names: Vec<String> = (0..objects).map(|i| format!("m{i}")).collect();
    for (i, name) in names.iter().enumerate() {
        scene = scene.carton(name, "from", [0.11 * (i % 5) as f64 - 0.22, 0.15 * (i / 5) as f64 - 0.1]);
    }
    let scene = names.iter().fold(scene, |scene, name| scene.moves(1, name, "from", "buffer"));
    names.iter().fold(scene, |scene, name| scene.moves(2, name, "buffer", "to")).0
}

#[test]
fn objects_that_pass_one_after_another_through_a_buffer_never_stand_in_it_together() {
    let problem = one_slot_buffer(2);
    let candidate = first_candidate(&problem);
    assert_eq!(orders(&problem, &candidate), ["grasp of r2.1 < release of r1.2"]);

    let problem = one_slot_buffer(8);
    let candidate = first_candidate(&problem);
    let expected: Vec<String> = (1..8).map(|i| format!("grasp of r2.{i} < release of r1.{}", i + 1)).collect();
    assert_eq!(orders(&problem, &candidate), expected);
}

#[test]
fn an_object_that_returns_to_a_region_gets_a_pose_of_its_own_each_time() {
    let scene = Scene::new(2).table("A", WIDE).table("B", WIDE);
    let scene = scene.carton("x", "A", [0.0, 0.0]).carton("y", "A", [0.2, 0.1]);
    let scene = scene.moves(1, "x", "A", "B").moves(1, "x", "B", "A").moves(1, "x", "A", "B");
    let problem = scene.moves(2, "y", "A", "B").0;
    let candidate = first_candidate(&problem);
    assert!(candidate.orders.is_empty());
    let pose = |i: usize| candidate.placements[i].world_from_object;
    assert!((pose(0).translation.vector - pose(2).translation.vector).norm() > 0.05, "{:?}", candidate.placements);
}

#[test]
fn an_object_that_returns_to_a_full_region_waits_until_there_is_room() {
    let scene = Scene::new(2).table("A", ONE_SLOT).table("B", WIDE);
    let scene = scene.carton("x", "A", [0.0, 0.0]).carton("y", "B", [0.1, 0.1]);
    let scene = scene.moves(1, "x", "A", "B").moves(1, "x", "B", "A");
    let problem = scene.moves(2, "y", "B", "A").moves(2, "y", "A", "B").0;
    let candidate = first_candidate(&problem);
    let both = ["grasp of r1.1 < release of r2.1", "grasp of r2.2 < release of r1.2"];
    assert_eq!(orders(&problem, &candidate), both);
}

#[test]
fn both_ways_round_are_offered_and_a_forbidden_one_leaves_no_trace() {
    // Two objects pass through one slot; either may be the first.
    let scene = Scene::new(4).table("from", WIDE).table("slot", ONE_SLOT).table("to", WIDE);
    let scene = scene.carton("x", "from", [0.0, 0.0]).carton("y", "from", [0.2, 0.0]);
    let scene = scene.moves(1, "x", "from", "slot").moves(2, "y", "from", "slot");
    let problem = scene.moves(3, "x", "slot", "to").moves(4, "y", "slot", "to").0;
    let first = first_candidate(&problem);
    assert_eq!(orders(&problem, &first), ["grasp of r3.1 < release of r2.1"]);
    let literal = Literal::Order { before: first.orders[0].before, after: first.orders[0].after };
    let other = candidates(&stage(&problem, 0), &job(0, 0, 1, vec![vec![literal]]));
    assert_eq!(orders(&problem, &other[0]), ["grasp of r4.1 < release of r1.1"]);
    let exchanged = Literal::Order { before: other[0].orders[0].before, after: other[0].orders[0].after };
    let literal = Literal::Order { before: first.orders[0].before, after: first.orders[0].after };
    let none = common::ask(&stage(&problem, 0), &job(0, 0, 1, vec![vec![literal], vec![exchanged]])).unwrap();
    assert_eq!(none.result.unwrap_err().soundness, Soundness::Soft { level: 0 });
}

#[test]
fn the_only_combination_that_nogoods_leave_is_found_off_the_diagonal() {
    let scene = Scene::new(2).table("from", WIDE).table("A", WIDE).table("B", WIDE);
    let scene = scene.carton("x", "from", [-0.1, 0.0]).carton("y", "from", [0.1, 0.0]);
    let mut problem = scene.moves(1, "x", "from", "A").moves(2, "y", "from", "B").0;
    problem.levels.placements = 5;
    let skeleton = skeleton::Skeleton::of_problem(&problem).unwrap();
    let [x, y] = [0, 1].map(|pair| skeleton.placed(&problem, problem_pair(pair)));
    let pose = |occupancy, sample| Literal::Pose { occupancy, sample };
    let all = (0..5).flat_map(|i| (0..5).map(move |j| (i, j)));
    let nogoods = all.filter(|at| *at != (4, 1)).map(|(i, j)| vec![pose(x, i), pose(y, j)]).collect();
    let found = candidates(&stage(&problem, 0), &job(0, 0, 9, nogoods));
    assert_eq!(found.len(), 1);
    assert_eq!([0, 1].map(|i| found[0].placements[i].sample), [4, 1]);
}

fn problem_pair(index: usize) -> model::PairId {
    model::PairId::at(index)
}

#[test]
fn a_start_pose_that_is_never_left_is_avoided_by_everybody() {
    let scene = Scene::new(1).table("from", WIDE).table("to", [0.3, 0.09]);
    let scene = scene.carton("rest", "to", [0.0, 0.0]).carton("m", "from", [0.0, 0.0]);
    let problem = scene.moves(1, "m", "from", "to").0;
    let candidate = first_candidate(&problem);
    assert!(candidate.placements[0].sample > 0, "its middle is taken");
    assert!(candidate.orders.is_empty());
    assert_eq!(Event::release(candidate.placements[0].pair).point, Point::Release);
}

#[test]
fn where_removals_have_to_be_completed_the_old_box_is_released_elsewhere_before_the_new_one_comes() {
    let mut problem = shipped("t05_tiny_region");
    problem.settings.removal = model::Removal::Completed;
    assert_eq!(orders(&problem, &first_candidate(&problem)), ["release of r2.1 < release of r1.1"]);
}

#[test]
fn where_removals_have_to_be_completed_two_robots_cannot_swap_two_objects() {
    let mut problem = two_robot_swap().0;
    problem.settings.removal = model::Removal::Completed;
    let report = failure(&problem);
    let mut points = cycle_points(&report.causes);
    points.sort();
    assert_eq!(points, [point("r1.1", Point::Release), point("r2.1", Point::Release)]);
    assert!(matches!(report.proof(), Some(Certificate::Cycle { exclusions, .. }) if exclusions.len() == 2));
}
