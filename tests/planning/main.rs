//! Whole plans: every scene through every stage, the checker as judge.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod command_line;
mod delays;
mod events;
#[allow(dead_code, reason = "the ladder uses the rest")]
#[path = "../ladder/facts.rs"]
mod facts;
#[path = "../../shared/validation/tests/checker/certificates/failure.rs"]
mod failure;
mod foreign_placement;
mod interruption;
mod options;
mod processes;
mod reasons;
mod scenes;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use contract::{CompositeMethod, ProblemStatement};
use launch::ending::finished_plan;
use launch::in_process;
use launch::progress::{Progress, Show};
use model::{DiskFiles, Problem, load_problem};
use plan::Plan;
use refiner::End;

/// A scene of the project.
fn scene(name: &str) -> Problem {
    load_problem(&DiskFiles, &scene_path(name).to_string_lossy()).unwrap()
}

fn scene_path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("launch/scenes").join(format!("{name}.yaml"))
}

/// Plans by direct calls; the end if there is no plan.
fn try_plan(problem: &Problem, seed: u64, composite: CompositeMethod) -> Result<Plan, End> {
    let statement = Arc::new(ProblemStatement::new(problem.clone(), seed, composite));
    let progress = Progress::new(statement.clone(), Show::Nothing);
    let run = in_process::run(&statement, None, &Arc::new(AtomicBool::new(false)), &progress).unwrap();
    match run.plan {
        Some(product) => Ok(finished_plan(&statement, &run.refinement.ledger, &product).unwrap()),
        None => Err(run.refinement.end),
    }
}

/// A plan that the checker accepts.
fn certified(problem: &Problem, seed: u64, composite: CompositeMethod) -> Plan {
    let plan = try_plan(problem, seed, composite)
        .unwrap_or_else(|end| panic!("{} with seed {seed} has no plan: {end:?}", problem.name));
    if let Err(violations) = validation::check_plan(problem, &plan) {
        panic!("the checker refuses {} with seed {seed}: {violations:?}", problem.name);
    }
    plan
}
