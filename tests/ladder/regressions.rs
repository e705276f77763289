//! Faults that other implementations of the paper have, planted on real geometry.

use std::cell::Cell;

use contract::CompositeMethod::Prioritised;
use contract::{CauseTally, Composition, Decision, Job, LedgerEntry, Outcome, RandomStream, Request, StageKind};
use model::{GivenOrdering, Point, Problem};
use plan::{Cause, EventKind, Plan};
use validation::{Rule, check_plan, delayed_execution};

use crate::facts::{discovered, time_of};
use crate::generator::load_text;
use crate::run::{Instead, Run, UNLIMITED, run, run_with};
use crate::scene;

fn certified(problem: &Problem, found: &Run) -> Plan {
    let plan = found.plan.clone().unwrap_or_else(|| panic!("{} has no plan: {:?}", problem.name, found.end));
    check_plan(problem, &plan).unwrap();
    plan
}

fn pair(problem: &Problem, name: &str) -> model::PairId {
    model::PairId::at(problem.pairs.iter().position(|pair| pair.name == name).unwrap())
}

/// A scene's text with some of it replaced.
pub fn edited(name: &str, edits: &[(&str, &str)]) -> Problem {
    let path = format!("{}/launch/scenes/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    let mut text = std::fs::read_to_string(path).unwrap();
    for (old, new) in edits {
        assert!(text.contains(old), "{name} has no `{old}`");
        text = text.replace(old, new);
    }
    load_text(&text).unwrap()
}

fn no_budget(job: &Job) -> Outcome {
    let mut causes = CauseTally::default();
    causes.count(Cause::Budget { stage: job.stage().name().to_owned() });
    Outcome::soft_failure(causes, 0, 1)
}

#[test]
fn an_ordering_that_was_taken_back_leaves_no_trace_in_the_plan() {
    let problem =
        edited("t18_parked_in_the_door", &[("orderings:\n  - {before: r2.1 release, after: r1.1 release}", "")]);
    let first_branch = |job: &Job| match &job.request {
        Request::Compose(compose) => {
            let refused = compose.assignment.orders.iter().any(|order| order.after.point == Point::Release);
            refused.then(|| no_budget(job))
        }
        _ => None,
    };
    let found = run_with(&problem, 0, Prioritised, UNLIMITED, Some(&first_branch as Instead<'_>));
    let taken_back = |entry: &LedgerEntry| matches!(entry, LedgerEntry::Backtrack { decision: Decision::Order(_), .. });
    assert!(found.ledger.entries.iter().any(taken_back), "no ordering was tried and taken back");
    let plan = certified(&problem, &found);
    assert!(discovered(&plan).iter().all(|order| !order.contains("< release")), "{:?}", discovered(&plan));
}

#[test]
fn of_two_predecessors_of_one_robot_the_later_one_binds() {
    let mut problem = scene("t04_spacious_region");
    let after = (pair(&problem, "r2.1"), Point::Grasp);
    for before in ["r1.1", "r1.2"] {
        problem.orderings.push(GivenOrdering { before: (pair(&problem, before), Point::Release), after });
    }
    let plan = certified(&problem, &run(&problem, 0, Prioritised));
    assert!(time_of(&plan, "r1.2", EventKind::Detach) < time_of(&plan, "r2.1", EventKind::Attach));
}

#[test]
fn two_objects_that_pass_a_buffer_for_one_are_in_it_one_after_the_other() {
    let edits = [
        ("on: table_b, size: [0.4, 0.4]", "on: table_b, size: [0.09, 0.07]"),
        (
            "pose: {xyz: [-2.0, 0.0, 0.675]}}",
            "pose: {xyz: [-2.0, -0.1, 0.675]}}\n  - {name: m2, shape: {box: [0.07, 0.05, 0.15]}, pose: {xyz: [-2.0, 0.1, 0.675]}}",
        ),
        ("from: a, to: b}", "from: a, to: b}\n    - {object: m2, from: a, to: b}"),
        ("from: b, to: c}", "from: b, to: c}\n    - {object: m2, from: b, to: c}"),
    ];
    let problem = edited("t03_relay", &edits);
    let plan = certified(&problem, &run(&problem, 0, Prioritised));
    assert_eq!(discovered(&plan), ["grasp r2.1 < release r1.2"]);
}

#[test]
fn an_object_comes_back_to_a_region_where_another_one_stands_by_now() {
    let edits = [
        ("on: pedestal_a, size: [0.09, 0.07]", "on: pedestal_a, size: [0.28, 0.09]"),
        ("from: buffer, to: b}", "from: buffer, to: a}"),
    ];
    let problem = edited("t10_swap_with_buffer", &edits);
    let plan = certified(&problem, &run(&problem, 0, Prioritised));
    let last = |object: &str| {
        let placed = plan.events.iter().rfind(|e| e.object == object && e.kind == EventKind::Detach);
        placed.unwrap().world_from_object.xyz
    };
    let ([x, y, _], [other_x, other_y, _]) = (last("x"), last("y"));
    assert!((x - other_x).hypot(y - other_y) > 0.05, "they stand in one another");
}

#[test]
fn a_composite_budget_that_is_used_up_leads_to_other_alternatives_and_not_to_the_end() {
    let problem = scene("t05_tiny_region");
    let refused = Cell::new(0);
    let twice = |job: &Job| match &job.request {
        Request::Compose(compose) if refused.get() < 2 => {
            refused.set(refused.get() + u32::from(matches!(compose.composition, Composition::Drrt { .. })));
            Some(no_budget(job))
        }
        _ => None,
    };
    let found = run_with(&problem, 0, Prioritised, UNLIMITED, Some(&twice as Instead<'_>));
    certified(&problem, &found);
    let back = |entry: &LedgerEntry| {
        matches!(entry, LedgerEntry::Backtrack { decision: Decision::Drrt | Decision::Alternative { .. }, .. })
    };
    assert!(refused.get() == 2 && found.ledger.entries.iter().any(back));
}

/// Delays of 0.1 to 60 s at some random knots of every robot.
fn random_pauses(plan: &Plan, pattern: u64) -> Vec<Vec<f64>> {
    let mut values = RandomStream::new(11, StageKind::Composite, &["delays"], "ladder").values(pattern);
    let of_robot = |robot: &plan::RobotTrajectory| {
        let mut pauses = vec![0.0; robot.knots.len()];
        for _ in 0..1 + values.next_index(5) {
            pauses[values.next_index(robot.knots.len())] += 0.1 * 600_f64.powf(values.next_unit());
        }
        pauses
    };
    plan.robots.iter().map(of_robot).collect()
}

/// Long loads, a door that two have to share, a bay: whoever is late is run into by nobody, and by nothing that is carried.
#[test]
fn late_robots_with_and_without_loads_are_run_into_by_nobody() {
    for name in ["t19_passing_bay", "t22_both_jambs", "t26_home_in_the_door"] {
        let problem = scene(name);
        let plan = certified(&problem, &run(&problem, 0, Prioritised));
        for pattern in 0..10 {
            let delayed = delayed_execution(&plan, &random_pauses(&plan, pattern)).unwrap();
            let wrong = check_plan(&problem, &delayed).err().unwrap_or_default();
            // A late plan is longer than it says, and an ordering may no longer be needed.
            let of_delay = |rule: Rule| matches!(rule, Rule::V14 | Rule::V15);
            assert!(wrong.iter().all(|v| of_delay(v.rule)), "{name}, delay pattern {pattern}: {wrong:?}");
        }
    }
}
