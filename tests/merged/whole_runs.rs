//! Whole runs with merged steps.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use contract::{CompositeMethod, Merge, ProblemStatement};
use launch::ending::finished_plan;
use launch::in_process;
use launch::in_process::RunEnd;
use launch::processes::{Members, run};
use launch::progress::{Progress, Show};
use launch::set::launch_file;
use model::{FailurePolicy, Problem};
use plan::{Certificate, ResultKind};
use refiner::End;

use crate::scene;

/// No run of these tests takes this long; one that does hangs.
const WATCHDOG: Duration = Duration::from_secs(180);

fn statement(problem: Problem, merge: Merge, causes: bool) -> Arc<ProblemStatement> {
    let mut statement = ProblemStatement::new(problem, 0, CompositeMethod::Prioritised);
    statement.options.merge = merge;
    statement.options.policies.transition = Some(FailurePolicy::Backtrack { causes });
    Arc::new(statement)
}

fn by_direct_calls(statement: &Arc<ProblemStatement>) -> RunEnd {
    let (progress, cancelled) = (Progress::new(statement.clone(), Show::Nothing), Arc::new(AtomicBool::new(false)));
    in_process::run(statement, Some(WATCHDOG), &cancelled, &progress).unwrap()
}

fn plan_bytes(statement: &ProblemStatement, run: &RunEnd) -> Vec<u8> {
    let plan = run.plan.as_ref().unwrap_or_else(|| panic!("no plan but {:?}", run.refinement.end));
    let plan = finished_plan(statement, &run.refinement.ledger, plan).unwrap();
    if let Err(violations) = validation::check_plan(&statement.problem, &plan) {
        panic!("the checker refuses it: {violations:?}");
    }
    plan::write_plan(&plan).unwrap()
}

#[test]
fn merged_runs_have_equal_bytes_by_direct_calls_channels_and_processes() {
    let statement = statement(scene("t05_tiny_region"), Merge::PlacementToRoadmap, true);
    let expected = plan_bytes(&statement, &by_direct_calls(&statement));
    let (progress, stop) = (Progress::new(statement.clone(), Show::Nothing), Arc::new(AtomicBool::new(false)));
    let launch = launch_file::load(None).unwrap();
    let (end, _) = run(&statement, &launch, Members::Threads, Some(WATCHDOG), &stop, &progress).unwrap();
    assert!(plan_bytes(&statement, &end) == expected, "over channels");
    let folder = tempfile::tempdir().unwrap();
    assert_cmd::Command::new(env!("CARGO_BIN_EXE_mrtamp"))
        .args(["plan", "t05_tiny_region", "--merge", "1-3", "--out", "out"])
        .current_dir(folder.path())
        .timeout(WATCHDOG)
        .assert()
        .success();
    assert!(std::fs::read(folder.path().join("out/plan.json")).unwrap() == expected, "over processes");
}

#[test]
fn what_the_placement_stage_would_prove_merged_steps_only_exhaust() {
    for name in ["t06_contradiction", "t11_swap_without_buffer"] {
        let mut problem = scene(name);
        problem.levels.highest = 0;
        for merge in [Merge::PlacementAndTransition, Merge::PlacementToRoadmap] {
            for causes in [true, false] {
                let end = by_direct_calls(&statement(problem.clone(), merge, causes)).refinement.end;
                let End::Failed { result, causes, certificate } = end else { panic!("{name}, {merge:?}: {end:?}") };
                assert_eq!((result, certificate), (ResultKind::SamplesExhausted, None), "{name}, {merge:?}");
                assert!(!causes.is_empty());
            }
        }
    }
}

#[test]
fn what_the_transition_stage_proves_is_proven_with_merged_steps_too() {
    for merge in [Merge::PlacementAndTransition, Merge::PlacementToRoadmap] {
        let end = by_direct_calls(&statement(scene("t15_no_common_grasp"), merge, true)).refinement.end;
        let End::Failed { result, certificate, .. } = end else { panic!("{merge:?}: {end:?}") };
        assert_eq!(result, ResultKind::InfeasibleProven);
        assert!(matches!(certificate, Some(Certificate::NoCommonGrasp { .. })), "{certificate:?}");
    }
}
