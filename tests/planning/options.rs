//! Policies and limits as a user gives them: in the problem, in the launch file, on the command line. Gates and removals.

use std::path::Path;

use assert_cmd::Command;
use contract::CompositeMethod::{Drrt, Prioritised};
use model::{FailurePolicy, Gate, Removal};
use plan::{Cause, Certificate, Origin, ResultKind, StoppedBy};
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
        let spent = failure.stages.iter().find(|count| count.stage == stage && count.jobs > 0).unwrap().work;
        let of = (stage.to_owned(), limit.split_once('=').unwrap().1.parse().unwrap());
        assert!(spent > of.1, "{limit}: {spent}");
        assert_eq!(failure.stopped_by, Some(StoppedBy::WorkLimit { of: of.0, limit: of.1, spent }), "{limit}");
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
fn what_stopped_a_search_is_in_its_failure_and_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        (&["t14_blocked_for_ever", "--policy", "transition=stop"][..], 4, "ended by the policy of transition, `stop`"),
        (&["t19b_no_bay", "--policy", "composite=stop"], 4, "ended by the policy of composite, `stop`"),
        (&["t03_relay", "--limit", "drrt=1", "--composite", "drrt"], 5, "ended by the limit on work of drrt: 1 units"),
        (&["t06_contradiction"], 3, ""),
    ];
    for (arguments, code, words) in cases {
        let mut command = Command::cargo_bin("mrtamp").unwrap();
        let command = command.args(["plan", "--in-process", "--json", "--out", "out"]).args(arguments);
        let ended = command.current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(code), "{said}");
        assert!(said.contains(words) && words.is_empty() != said.contains("ended by"), "{said}");
        let failure = plan::read_failure(&std::fs::read(folder.path().join("out/failure.json")).unwrap()).unwrap();
        assert_eq!(failure.stopped_by.as_ref().map(launch::words::stopped_by).is_some(), !words.is_empty());
        if words.contains("policy") {
            let stage = words.split([' ', ',']).nth(5).unwrap().to_owned();
            assert_eq!(failure.stopped_by, Some(StoppedBy::Policy { stage, policy: FailurePolicy::Stop }));
        }
        let told = serde_json::to_value(&failure).unwrap();
        let last: serde_json::Value =
            serde_json::from_str(String::from_utf8_lossy(&ended.stdout).lines().last().unwrap()).unwrap();
        assert_eq!(last["stopped_by"], told["stopped_by"]);
    }
}

#[test]
fn a_plan_is_made_again_from_what_it_says_of_the_search() {
    let folder = tempfile::tempdir().unwrap();
    let (code, by_default) = plan(&["t05_tiny_region", "--in-process", "--policy", "roadmap=backtrack"], folder.path());
    assert_eq!(code, Some(0));
    assert!(!String::from_utf8_lossy(&by_default).contains("\"search\""), "the defaults are not said");
    let asked = ["--composite", "shorter", "--merge", "1-2", "--policy", "transition=more:2:3"];
    let asked =
        [&["t05_tiny_region", "--in-process"][..], &asked, &["--limit", "drrt=90000", "--policy", "composite=stop"]];
    let (code, made) = plan(&asked.concat(), folder.path());
    assert_eq!(code, Some(0));
    let search = plan::read_plan(&made).unwrap().provenance.search;
    let mut again = vec!["t05_tiny_region".to_owned(), "--in-process".to_owned()];
    let mut say = |option: &str, value: String| again.extend([option.to_owned(), value]);
    say("--composite", search.composite.clone().unwrap());
    say("--merge", search.merge.clone().unwrap());
    search.policy.iter().for_each(|(stage, policy)| say("--policy", format!("{stage}={policy}")));
    search.limit.iter().for_each(|(work, units)| say("--limit", format!("{work}={units}")));
    assert_eq!(again.len(), 12, "{again:?}");
    let (code, made_again) = plan(&again.iter().map(String::as_str).collect::<Vec<_>>(), folder.path());
    assert!((code, made_again) == (Some(0), made));
}

#[test]
fn a_bench_keeps_the_time_limit_of_its_problem_unless_it_is_given_one() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = scene_path("t00_one_arm");
    let text = std::fs::read_to_string(&scenes).unwrap();
    let text = text.replace("../robots", &scenes.parent().unwrap().join("../robots").to_string_lossy());
    std::fs::write(folder.path().join("problem.yaml"), format!("{text}\nsearch: {{time_limit: 0}}\n")).unwrap();
    for (more, code, end) in [(&[][..], 4, "limit_reached"), (&["--time-limit", "60"], 0, "solved")] {
        let mut command = Command::cargo_bin("mrtamp").unwrap();
        let bench = command.args(["bench", "problem.yaml", "--seeds", "1", "--in-process"]).args(more);
        let ended = bench.current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&ended.stdout);
        assert_eq!(ended.status.code(), Some(code), "{more:?}: {said}");
        assert!(said.lines().nth(1).unwrap().ends_with(end), "{more:?}: {said}");
    }
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
