//! What a user is told: why there is no plan and what to try, why a plan is as it is.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use assert_cmd::Command;
use contract::{CompositeMethod, ProblemStatement};
use launch::ending::finished_plan;
use launch::explain::failure_text;
use launch::explain::plan_reasons::plan_text;
use launch::in_process;
use launch::progress::{Progress, Show};

use crate::{scene, scene_path};

/// Numbers that stand alone change with every improvement; names, words and their order are what is told.
fn without_numbers(text: &str) -> String {
    let hidden = |word: &str| {
        let bare = word.trim_matches(|c: char| c == ',' || c == ':');
        if bare.parse::<f64>().is_ok() { word.replacen(bare, "#", 1) } else { word.to_owned() }
    };
    let line = |line: &str| line.split(' ').filter(|word| !word.is_empty()).map(hidden).collect::<Vec<_>>().join(" ");
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

/// What is told of a scene that has no plan, as it is told on stderr.
fn told_of_failure(name: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::cargo_bin("mrtamp").unwrap();
    let path = scene_path(name);
    let ended = command.arg("plan").arg(&path).args(["--in-process", "--out", "."]).current_dir(folder.path());
    let stderr = String::from_utf8(ended.output().unwrap().stderr).unwrap();
    let failure = plan::read_failure(&std::fs::read(folder.path().join("failure.json")).unwrap()).unwrap();
    let text = failure_text(&scene(name), &failure);
    assert!(stderr.contains(&text), "{stderr}");
    let page = std::fs::read_to_string(folder.path().join("failure.html")).unwrap();
    for remedy in launch::explain::remedies::of_failure(&scene(name), &failure) {
        assert!(page.contains(&serde_json::to_string(&remedy).unwrap().replace('<', "\\u003c")), "{remedy}");
    }
    without_numbers(&text)
}

fn told_of_plan(name: &str) -> String {
    let problem = scene(name);
    let statement = Arc::new(ProblemStatement::new(problem.clone(), 0, CompositeMethod::default()));
    let progress = Progress::new(statement.clone(), Show::Nothing);
    let run = in_process::run(&statement, None, &Arc::new(AtomicBool::new(false)), &progress).unwrap();
    let ledger = &run.refinement.ledger;
    let plan = finished_plan(&statement, ledger, &run.plan.unwrap()).unwrap();
    without_numbers(&plan_text(&problem, &plan, Some(ledger)))
}

fn assert_told(name: &str, told: &str) {
    insta::with_settings!({omit_expression => true}, { insta::assert_snapshot!(name, told) });
}

#[test]
fn a_scene_without_a_plan_is_explained_with_names_and_remedies() {
    for name in ["t07_three_in_two", "t14_blocked_for_ever", "t16_out_of_reach", "t19b_no_bay"] {
        assert_told(name, &told_of_failure(name));
    }
}

#[test]
fn a_plan_is_explained_by_its_orderings_its_search_and_its_waits() {
    for name in ["t05_tiny_region", "t13_occluded"] {
        assert_told(name, &told_of_plan(name));
    }
}

#[test]
fn plan_and_check_explain_where_they_are_asked_to() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = Command::cargo_bin("mrtamp").unwrap().args(arguments).current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap())
    };
    let heading = "Orderings that the geometry forces";
    let plan = ["plan", "t05_tiny_region", "--in-process", "--out", "."];
    let [quiet, _] = run(&plan);
    let [told, _] = run(&[&plan[..], &["--explain"]].concat());
    assert!(!quiet.contains(heading) && told.contains(heading) && told.contains("Given up on the way"));
    let [events, told] = run(&[&plan[..], &["--explain", "--json"]].concat());
    assert!(told.contains(heading) && !events.contains(heading), "{told}");
    let [told, _] = run(&["check", &scene_path("t05_tiny_region").to_string_lossy(), "plan.json", "--explain"]);
    assert!(told.contains(heading) && !told.contains("Given up"), "{told}");
}
