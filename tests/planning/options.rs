//! Policies and limits as a user gives them: in the problem, in the launch file, on the command line. Gates and removals.

use std::path::Path;

use assert_cmd::Command;
use contract::CompositeMethod::{Drrt, Prioritised};
use model::{Gate, Removal};
use plan::{Cause, Certificate, Origin, ResultKind};
use refiner::End;
use validation::{Rule, check_plan};

use crate::failure::failure;
use crate::{certified, scene, scene_path, try_plan};

/// Exit code, and bytes of the result.
fn plan(arguments: &[&str], folder: &Path) -> (Option<i32>, Vec<u8>) {
    let mut command = Command::cargo_bin("mrtamp").unwrap();
    let ended = command.arg("plan").args(arguments).args(["--out", "out"]).current_dir(folder).output().unwrap();
    let code = ended.status.code();
    let file = if code == Some(0) { "out/plan.json" } else { "out/failure.json" };
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    (code, std::fs::read(folder.join(file)).unwrap_or_else(|error| panic!("{code:?} {error}: {said}")))
}

#[test]
fn runs_cut_short_by_a_limit_on_work_leave_equal_bytes_in_one_process_and_in_several() {
    let folder = tempfile::tempdir().unwrap();
    for limit in ["placement=1", "transition=100", "roadmap=2000", "composite=50"] {
        let arguments = ["t03_relay", "--limit", limit];
        let (code, alone) = plan(&[&arguments[..], &["--in-process"]].concat(), folder.path());
        assert_eq!(code, Some(5), "{limit}");
        let failure = plan::read_failure(&alone).unwrap();
        assert_eq!(failure.result, ResultKind::LimitReached);
        let stage = limit.split_once('=').unwrap().0;
        assert!(failure.causes.iter().any(|(cause, _)| *cause == Cause::Budget { stage: stage.into() }), "{limit}");
        assert!(failure.stages.iter().any(|count| count.stage == stage && count.jobs > 0), "{limit}");
        assert!(plan(&arguments, folder.path()) == (Some(5), alone), "{limit}");
    }
}

#[test]
fn runs_with_policies_leave_equal_bytes_in_one_process_and_in_several() {
    let folder = tempfile::tempdir().unwrap();
    let policies =
        ["--policy", "placement=more:2:1", "--policy", "transition=more:2:1", "--policy", "roadmap=more:2:1"];
    for (scene, expected) in [("t05_tiny_region", 0), ("t14_blocked_for_ever", 4)] {
        let arguments = [&[scene][..], &policies].concat();
        let alone = plan(&[&arguments[..], &["--in-process"]].concat(), folder.path());
        assert_eq!(alone.0, Some(expected), "{scene}");
        assert!(plan(&arguments, folder.path()) == alone, "{scene}");
    }
}

#[test]
fn the_command_line_wins_over_the_launch_file_and_that_over_the_problem() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let scenes = scene_path("t03_relay");
    let text = std::fs::read_to_string(&scenes).unwrap();
    let robots = scenes.parent().unwrap().join("../robots");
    let text = text.replace("../robots", &robots.to_string_lossy());
    write("problem.yaml", &format!("{text}\nsearch: {{limit: {{placement: 1}}}}\n"));
    write("set.yaml", "search: {limit: {placement: 1000000, transition: 1}}\n");
    let of_problem = ["problem.yaml", "--in-process"];
    let of_set = [&of_problem[..], &["--set", "set.yaml"]].concat();
    let of_user = [&of_set[..], &["--limit", "transition=1000000"]].concat();
    let exceeded = |arguments: &[&str]| match plan(arguments, folder.path()) {
        (Some(5), bytes) => plan::read_failure(&bytes).unwrap().stages.last().unwrap().stage.clone(),
        (code, _) => format!("{code:?}"),
    };
    assert_eq!(exceeded(&of_problem), "placement");
    assert_eq!(exceeded(&of_set), "transition");
    assert_eq!(exceeded(&of_user), "Some(0)");
}

#[test]
fn words_that_mean_nothing_are_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [["--policy", "transition=maybe"], ["--limit", "drrt=0"], ["--limit", "arm=3"]] {
        let mut command = Command::cargo_bin("mrtamp").unwrap();
        let ended = command.args(["plan", "t03_relay"]).args(arguments).current_dir(folder.path()).output().unwrap();
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn a_relay_takes_longer_where_whole_actions_gate_one_another() {
    let mut problem = scene("t03_relay");
    for method in [Prioritised, Drrt] {
        problem.settings.gate = Gate::Grasp;
        let by_grasp = certified(&problem, 0, method);
        problem.settings.gate = Gate::Action;
        let by_action = certified(&problem, 0, method);
        let (short, long) = (by_grasp.makespan.task_s, by_action.makespan.task_s);
        println!("{short} s by grasps, {long} s by actions, {:.1} % more", 100.0 * (long / short - 1.0));
        assert!(short < long, "{short} s, {long} s");
        let broken = check_plan(&problem, &by_grasp).unwrap_err();
        assert!(broken.iter().all(|violation| violation.rule == Rule::V10), "{broken:?}");
    }
}

#[test]
fn the_last_action_of_a_robot_that_stays_opens_its_gate() {
    let mut problem = scene("t25_stays_after_its_last");
    problem.settings.gate = Gate::Action;
    for method in [Prioritised, Drrt] {
        certified(&problem, 0, method);
    }
}

#[test]
fn a_swap_of_two_robots_is_proven_a_cycle_where_removals_have_to_be_completed() {
    let mut problem = scene("t09_swap");
    certified(&problem, 0, Prioritised);
    problem.settings.removal = Removal::Completed;
    let end = try_plan(&problem, 0, Prioritised).unwrap_err();
    let End::Failed { result: ResultKind::InfeasibleProven, certificate: Some(certificate), .. } = end else {
        panic!("no proof: {end:?}")
    };
    assert!(matches!(certificate, Certificate::Cycle { .. }));
    let failure = failure(&problem, Some(certificate));
    assert_eq!(validation::check_failure(&problem, &failure), Ok(()));
    problem.settings.removal = Removal::Grasp;
    assert!(validation::check_failure(&problem, &failure).is_err());
}

#[test]
fn a_place_is_free_when_the_removal_is_completed_if_the_problem_says_so() {
    let mut problem = scene("t05_tiny_region");
    problem.settings.removal = Removal::Completed;
    for method in [Prioritised, Drrt] {
        let plan = certified(&problem, 0, method);
        let found = plan.orderings.iter().filter(|ordering| ordering.origin == Origin::Discovered);
        let ends: Vec<_> =
            found.map(|o| (o.before.pair.as_str(), o.before.point.name(), o.after.pair.as_str())).collect();
        assert_eq!(ends, [("r2.1", "release", "r1.1")]);
    }
}
