//! The ladder: scenes with planted answers, each harder than the one before; regressions; random problems.

#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used, reason = "a test fails by panicking")]

mod causes;
mod facts;
mod generator;
mod random;
mod regressions;
mod rounds;
mod run;
mod rungs;
mod table;

use model::{DiskFiles, Problem, load_problem};

/// A scene of the project.
fn scene(name: &str) -> Problem {
    load_problem(&DiskFiles, &format!("{}/launch/scenes/{name}.yaml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}
