//! The ladder's scenes with their planted answers.

use contract::CompositeMethod::{self, Drrt, Prioritised, Shorter, SyncGreedy, SyncOpt};
use plan::{Cause, Origin};

use crate::facts::{discovered, time_of};
use crate::{certified, scene, try_plan};

const SMALL: [&str; 6] =
    ["t00_one_arm", "t01_one_robot", "t02_far_apart", "t03_relay", "t04_spacious_region", "t05_tiny_region"];

fn every_small_scene_is_planned(composite: CompositeMethod) {
    for name in SMALL {
        let plan = certified(&scene(name), 0, composite);
        let expected: &[&str] = if name == "t05_tiny_region" { &["grasp r2.1 < release r1.1"] } else { &[] };
        assert_eq!(discovered(&plan), expected, "{name}");
        assert!(plan.makespan.task_s >= plan.lower_bound.seconds - 1e-9, "{name} is quicker than its bound");
    }
}

#[test]
fn t00_to_t05_are_planned_with_exactly_the_orderings_that_geometry_forces() {
    every_small_scene_is_planned(Prioritised);
}

#[test]
fn t00_to_t05_are_planned_by_the_composite_search_alone_with_the_same_orderings() {
    every_small_scene_is_planned(Drrt);
}

#[test]
fn small_scenes_are_planned_in_rounds_with_the_same_orderings() {
    every_small_scene_is_planned(SyncGreedy);
    every_small_scene_is_planned(SyncOpt);
}

#[test]
fn figure_1_takes_longer_in_rounds_and_the_optimal_choice_is_no_longer_than_the_greedy_one() {
    let [free, greedy, best, shorter] =
        [Prioritised, SyncGreedy, SyncOpt, Shorter].map(|composite| certified(&scene("figure1"), 0, composite));
    // From the same placements, grasps, configurations and roadmaps.
    assert!([&greedy, &best, &shorter].iter().all(|plan| plan.lower_bound == free.lower_bound));
    assert!(shorter.makespan.task_s <= free.makespan.task_s.min(best.makespan.task_s));
    let total_s = [free, best, greedy].map(|plan| plan.makespan.total_s);
    assert!(total_s.is_sorted(), "{total_s:?}");
    assert!(total_s[1] > total_s[0] + 1.0, "{total_s:?}");
}

#[test]
fn both_versions_of_figure_1_are_planned_without_any_discovered_ordering() {
    for name in ["figure1", "figure1_slots"] {
        let plan = certified(&scene(name), 0, Prioritised);
        assert_eq!(discovered(&plan), [""; 0], "{name}");
        assert_eq!(plan.events.len(), 16, "{name}");
        assert_eq!(plan.orderings.iter().filter(|o| o.origin == Origin::Given).count(), 4, "{name}");
    }
}

#[test]
fn robots_far_apart_need_no_arcs_and_are_as_quick_as_each_alone() {
    let problem = scene("t02_far_apart");
    let plan = certified(&problem, 0, Prioritised);
    assert_eq!(plan.dependencies, []);
    let alone: Vec<f64> = (0..problem.robots.len())
        .map(|robot| {
            let end = plan.robots[robot].segments.iter().rfind(|s| s.pair.is_some()).map(|s| s.to);
            plan.robots[robot].knots[end.unwrap()].t
        })
        .collect();
    assert!((plan.makespan.task_s - alone.iter().copied().fold(0.0, f64::max)).abs() < 1e-9);
    // Nobody waits: every robot's motion is as long as its own shortest ways.
    assert!(
        plan.robots
            .iter()
            .all(|r| r.segments.iter().all(|s| s.kind != plan::SegmentKind::Wait || resting(&problem, s)))
    );
}

/// Pauses of the hand are waits too.
fn resting(problem: &model::Problem, segment: &plan::Segment) -> bool {
    problem.settings.grip_time > 0.0 && segment.to == segment.from + 1
}

#[test]
fn in_the_relay_the_object_is_released_before_it_is_grasped_again() {
    let plan = certified(&scene("t03_relay"), 0, Prioritised);
    let [first, second] = ["r1.1", "r2.1"];
    assert!(time_of(&plan, first, plan::EventKind::Detach) < time_of(&plan, second, plan::EventKind::Attach));
}

#[test]
fn a_discovered_ordering_names_the_region_and_both_objects() {
    let plan = certified(&scene("t05_tiny_region"), 0, Prioritised);
    let ordering = plan.orderings.iter().find(|o| o.origin == Origin::Discovered).unwrap();
    assert!(matches!(&ordering.cause, Some(Cause::Overlap { region, leaves, comes })
        if region == "tiny" && leaves == "old" && comes == "new"));
    assert!(time_of(&plan, "r2.1", plan::EventKind::Attach) < time_of(&plan, "r1.1", plan::EventKind::Detach));
}

#[test]
fn a_region_out_of_reach_is_named_and_proven_so() {
    let mut problem = scene("t00_one_arm");
    let region = problem.pairs[0].to.index();
    let support = problem.regions[region].support.index();
    let away = nalgebra::Translation3::new(0.0, 3.0, 0.0);
    problem.fixed[support].world_from_object = away * problem.fixed[support].world_from_object;
    problem.regions[region].world_from_region = away * problem.regions[region].world_from_region;
    problem.levels.highest = 0;
    let Err(refiner::End::Failed { result, causes, certificate }) = try_plan(&problem, 0, Prioritised) else {
        panic!("planned, or a fault");
    };
    assert_eq!(result, plan::ResultKind::InfeasibleProven);
    let named = problem.regions[region].name.clone();
    assert!(causes.iter().any(|(cause, _)| matches!(cause, Cause::Unreachable { region, .. } if *region == named)));
    assert!(matches!(certificate, Some(plan::Certificate::Reach { region, .. }) if region == named));
}
