//! What `--json` writes on stdout: one object a line, while things happen.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::scene_path;

fn plan(scene: &str, folder: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mrtamp"));
    command.arg("plan").arg(scene_path(scene)).args(["--json", "--out", "out"]).args(more).current_dir(folder);
    command
}

/// All lines without what the clock says.
fn events(scene: &str, more: &[&str]) -> Vec<Value> {
    let folder = tempfile::tempdir().unwrap();
    let ended = plan(scene, folder.path(), more).output().unwrap();
    let text = String::from_utf8(ended.stdout).unwrap();
    let mut lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    for line in &mut lines {
        let fields = line.as_object_mut().unwrap();
        assert!(fields.remove("elapsed_s").is_some_and(|time| time.as_f64().unwrap() >= 0.0));
        for stage in fields.get_mut("stages").and_then(Value::as_array_mut).into_iter().flatten() {
            stage.as_object_mut().unwrap().remove("busy_s");
        }
    }
    lines
}

fn names(events: &[Value]) -> Vec<&str> {
    events.iter().map(|event| event["event"].as_str().unwrap()).collect()
}

#[test]
fn every_line_is_an_event_and_the_last_is_the_result() {
    let solved = events("t13_occluded", &["--in-process"]);
    let of_name = |name: &str| solved.iter().filter(|event| event["event"] == name).count();
    assert_eq!((solved[0]["event"].as_str(), solved[0]["problem"].as_str()), (Some("start"), Some("t13_occluded")));
    assert_eq!((of_name("start"), of_name("level"), of_name("solved"), of_name("result")), (1, 1, 1, 1));
    assert!(of_name("ordering") > 0 && of_name("committed") >= 6, "{:?}", names(&solved));
    let result = solved.last().unwrap();
    assert_eq!((&result["result"], &result["event"]), (&"solved".into(), &"result".into()));
    assert!(result["plan"]["task_s"].as_f64().unwrap() >= result["plan"]["lower_bound_s"].as_f64().unwrap());
    let failed = events("t14_blocked_for_ever", &["--in-process"]);
    let job = solved.iter().find(|event| event["event"] == "job").unwrap();
    assert!(job["stage"].is_string() && job["cause"].is_object() && job["words"].is_string(), "{job}");
    let backtrack = failed.iter().find(|event| event["event"] == "backtrack").unwrap();
    assert!(backtrack["words"].as_str().unwrap().contains("m2 in the way"), "{backtrack}");
    assert_eq!(failed.last().unwrap()["result"], "samples_exhausted");
    assert!(!failed.last().unwrap()["causes"].as_array().unwrap().is_empty());
}

#[test]
fn equal_seeds_give_equal_events_and_processes_the_same_decisions() {
    let [first, second] = [(); 2].map(|()| events("t05_tiny_region", &["--in-process"]));
    assert_eq!(first, second);
    let of_search = |events: Vec<Value>| -> Vec<Value> {
        let besides = ["job", "note", "result"];
        events.into_iter().filter(|event| !besides.contains(&event["event"].as_str().unwrap())).collect()
    };
    assert_eq!(of_search(events("t05_tiny_region", &[])), of_search(first));
}

#[test]
fn a_reader_that_goes_away_does_not_end_the_planning() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = plan("t01_one_robot", folder.path(), &["--in-process"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.contains("start"), "{line}");
    assert!(child.wait().unwrap().success());
    assert!(folder.path().join("out/plan.json").exists());
}

#[test]
fn bench_reads_the_results_of_its_runs() {
    let folder = tempfile::tempdir().unwrap();
    let bench = ["bench", "t00_one_arm", "--seeds", "2", "--in-process"];
    let ended = Command::new(env!("CARGO_BIN_EXE_mrtamp")).args(bench).current_dir(folder.path()).output().unwrap();
    let said = String::from_utf8_lossy(&ended.stdout);
    assert!(ended.status.success() && said.contains("solved 2 of 2"), "{said}");
    assert!(said.lines().any(|line| line.starts_with("task makespan s") && line.contains("median")), "{said}");
}
