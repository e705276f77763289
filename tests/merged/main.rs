//! Merged steps: the three pipelines accept the same placements, plan the same everywhere, and prove nothing alone.

#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used, reason = "a test fails by panicking")]

mod acceptance;
mod brute;
#[allow(dead_code, reason = "large problems are for other tests")]
#[path = "../ladder/generator.rs"]
mod generator;
#[path = "../../services/placement/tests/common/orders.rs"]
mod orders;
mod same_set;
mod whole_runs;

use model::{DiskFiles, Levels, Problem, load_problem};

/// A scene of the project.
fn scene(name: &str) -> Problem {
    load_problem(&DiskFiles, &format!("{}/launch/scenes/{name}.yaml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// A problem at one coarse level, small enough to enumerate.
fn coarse(mut problem: Problem, [placements, grasps, stands]: [u32; 3]) -> Problem {
    problem.levels = Levels { placements, grasps, stands, vertices: 12, highest: 0, ..problem.levels };
    problem
}
