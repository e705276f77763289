//! Plans under delay: whoever is late, arcs keep everybody safe; without an arc somebody is not.

use contract::{CompositeMethod::Prioritised, RandomStream, StageKind};
use model::Problem;
use plan::Plan;
use validation::{Rule, check_plan, delayed_execution};

use crate::{certified, scene};

/// Delays of 0.1 to 60 s at a few random knots of every robot.
fn random_pauses(plan: &Plan, pattern: u64) -> Vec<Vec<f64>> {
    let mut values = RandomStream::new(7, StageKind::Composite, &["delays"], "test").values(pattern);
    plan.robots
        .iter()
        .map(|robot| {
            let mut pauses = vec![0.0; robot.knots.len()];
            for _ in 0..1 + values.next_index(6) {
                let knot = values.next_index(robot.knots.len());
                pauses[knot] += 0.1 * 600_f64.powf(values.next_unit());
            }
            pauses
        })
        .collect()
}

fn no_pauses(plan: &Plan) -> Vec<Vec<f64>> {
    plan.robots.iter().map(|robot| vec![0.0; robot.knots.len()]).collect()
}

/// Delayed plans need not be as short as they say; everything else must hold.
fn is_safe(problem: &Problem, plan: &Plan) -> bool {
    match check_plan(problem, plan) {
        Ok(_) => true,
        Err(violations) => violations.iter().all(|violation| violation.rule == Rule::V14),
    }
}

fn assert_safe_under_delays(name: &str, patterns: u64) {
    let problem = scene(name);
    let plan = certified(&problem, 0, Prioritised);
    for pattern in 0..patterns {
        let delayed = delayed_execution(&plan, &random_pauses(&plan, pattern)).unwrap();
        assert!(is_safe(&problem, &delayed), "{name}: delay pattern {pattern} leads to a violation");
        assert!(delayed.makespan.total_s >= plan.makespan.total_s - 1e-9);
    }
}

#[test]
fn figure_1_stays_collision_free_under_two_hundred_random_delay_patterns() {
    assert_safe_under_delays("figure1", 200);
}

#[test]
fn small_scenes_stay_collision_free_under_random_delay_patterns() {
    for name in ["t03_relay", "t04_spacious_region", "t05_tiny_region"] {
        assert_safe_under_delays(name, 30);
    }
}

/// Arcs whose absence lets a late robot be run into: the arc is dropped and its first robot delayed just before it.
fn arcs_that_matter(problem: &Problem, plan: &Plan) -> usize {
    (0..plan.dependencies.len())
        .filter(|arc| {
            let mut without = plan.clone();
            let dropped = without.dependencies.remove(*arc);
            let late = plan.robots.iter().position(|robot| robot.name == dropped.before.robot).unwrap();
            let mut pauses = no_pauses(plan);
            pauses[late][dropped.before.knot.saturating_sub(1)] = 60.0;
            let delayed = delayed_execution(&without, &pauses).unwrap();
            !is_safe(problem, &delayed)
        })
        .count()
}

#[test]
fn dropping_single_arcs_of_figure_1_lets_violations_happen() {
    let problem = scene("figure1");
    let plan = certified(&problem, 0, Prioritised);
    let matter = arcs_that_matter(&problem, &plan);
    println!("{matter} of {} arcs, dropped one at a time, let a violation happen", plan.dependencies.len());
    assert!(matter * 10 >= plan.dependencies.len(), "{matter} of {} arcs matter", plan.dependencies.len());
}
