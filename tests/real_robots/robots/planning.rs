//! Two real arms pass objects to each other.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use contract::{CompositeMethod, ProblemStatement, RandomStream, StageKind};
use launch::ending::finished_plan;
use launch::in_process;
use launch::progress::{Progress, Show};
use model::{DiskFiles, Problem, load_problem};
use nalgebra::Translation3;
use plan::{EventKind, Plan};

use crate::{launch_folder, package};

fn scene() -> Problem {
    package();
    load_problem(&DiskFiles, &launch_folder().join("scenes/two_real_arms.yaml").to_string_lossy()).unwrap()
}

/// A plan that the checker accepts.
fn certified(problem: &Problem, seed: u64) -> Plan {
    let started = Instant::now();
    let statement = Arc::new(ProblemStatement::new(problem.clone(), seed, CompositeMethod::Prioritised));
    let progress = Progress::new(statement.clone(), Show::Nothing);
    let run = in_process::run(&statement, None, &Arc::new(AtomicBool::new(false)), &progress).unwrap();
    let Some(product) = run.plan else { panic!("seed {seed} has no plan: {:?}", run.refinement.end) };
    let plan = finished_plan(&statement, &run.refinement.ledger, &product).unwrap();
    let elapsed = started.elapsed().as_secs_f64();
    if let Err(violations) = validation::check_plan(problem, &plan) {
        panic!("the checker refuses seed {seed}: {violations:?}");
    }
    println!("{elapsed:.2} s, makespan {:.2} s, bound {:.2} s", plan.makespan.task_s, plan.lower_bound.seconds);
    plan
}

fn times(plan: &Plan, object: &str, kind: EventKind) -> Vec<(String, f64)> {
    let of_object = plan.events.iter().filter(|event| event.object == object && event.kind == kind);
    of_object.map(|event| (event.robot.clone(), event.t)).collect()
}

#[test]
fn panda_and_ur5_pass_three_objects_to_each_other_with_ten_seeds() {
    let problem = scene();
    for seed in 0..10 {
        let plan = certified(&problem, seed);
        for (object, giver, taker) in [("red", "panda", "ur5"), ("green", "panda", "ur5"), ("blue", "ur5", "panda")] {
            let (taken, given) = (times(&plan, object, EventKind::Attach), times(&plan, object, EventKind::Detach));
            let names: Vec<&str> = taken.iter().map(|(robot, _)| robot.as_str()).collect();
            assert_eq!(names, [giver, taker], "seed {seed}, {object}");
            assert!(given[0].1 < taken[1].1, "seed {seed}: {object} is taken before it is given");
        }
    }
}

/// Moves each object within its first region.
fn moved(problem: &Problem, layout: u64) -> Problem {
    let mut moved = problem.clone();
    let mut values = RandomStream::new(layout, StageKind::Placement, &["two_real_arms"], "test").values(0);
    for object in &mut moved.movable {
        let mut by = || 0.06 * values.next_unit() - 0.03;
        let shift = Translation3::new(by(), by(), 0.0);
        object.world_from_start = shift * object.world_from_start;
    }
    moved
}

#[test]
fn the_same_is_planned_when_the_objects_stand_elsewhere() {
    let problem = scene();
    for layout in 0..10 {
        let moved = moved(&problem, layout);
        let plan = certified(&moved, layout);
        assert_eq!(plan.events.len(), 12, "layout {layout}");
    }
}
