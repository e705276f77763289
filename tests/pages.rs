//! The commands that show and export plans, as a user calls them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;

fn mrtamp(arguments: &[&str], folder: &Path) -> Output {
    Command::cargo_bin("mrtamp").unwrap().args(arguments).current_dir(folder).output().unwrap()
}

fn succeed(arguments: &[&str], folder: &Path) -> String {
    let ended = mrtamp(arguments, folder);
    assert_eq!(ended.status.code(), Some(0), "{}", String::from_utf8_lossy(&ended.stderr));
    String::from_utf8_lossy(&ended.stdout).into_owned()
}

fn refuse(arguments: &[&str], folder: &Path) -> String {
    let ended = mrtamp(arguments, folder);
    assert_eq!(ended.status.code(), Some(2), "{}", String::from_utf8_lossy(&ended.stdout));
    String::from_utf8_lossy(&ended.stderr).split_whitespace().collect::<Vec<_>>().join(" ")
}

fn out_of_reach() -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/browser/out_of_reach.yaml");
    path.to_string_lossy().into_owned()
}

fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_page_stands_beside_every_result_and_none_beside_another_runs() {
    let folder = tempfile::tempdir().unwrap();
    let (here, out) = (folder.path(), folder.path().join("out"));
    let said = succeed(&["plan", "t00_one_arm", "--in-process", "--out", "out"], here);
    assert!(said.contains("out/plan.html"), "{said}");
    assert_eq!(files(&out), ["plan.html", "plan.json"]);
    let failed = mrtamp(&["plan", &out_of_reach(), "--in-process", "--out", "out"], here);
    assert_eq!(failed.status.code(), Some(3), "proven");
    assert!(String::from_utf8_lossy(&failed.stderr).contains("out/failure.html"));
    assert_eq!(files(&out), ["failure.html", "failure.json", "plan.previous.html", "plan.previous.json"]);
    assert!(String::from_utf8_lossy(&failed.stderr).contains("out/plan.previous.json"));
    succeed(&["plan", "t00_one_arm", "--in-process", "--out", "out"], here);
    assert_eq!(files(&out), ["plan.html", "plan.json", "plan.previous.html", "plan.previous.json"]);
}

#[test]
fn equal_plans_have_equal_pages() {
    let folder = tempfile::tempdir().unwrap();
    let page = |out: &str| {
        succeed(&["plan", "t05_tiny_region", "--in-process", "--out", out], folder.path());
        std::fs::read(folder.path().join(out).join("plan.html")).unwrap()
    };
    assert!(page("a") == page("b"));
}

#[test]
fn view_writes_the_page_of_a_plan_or_a_failure_again() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    succeed(&["plan", "t00_one_arm", "--in-process", "--out", "."], here);
    std::fs::remove_file(here.join("plan.html")).unwrap();
    assert_eq!(succeed(&["view", "plan.json"], here).trim(), "plan.html");
    let page = std::fs::read_to_string(here.join("plan.html")).unwrap();
    assert!(page.contains("<title>t00_one_arm: plan</title>") && page.contains("\"violations\":[]"));
    mrtamp(&["plan", &out_of_reach(), "--in-process", "--out", "."], here);
    succeed(&["view", "failure.json", "--problem", &out_of_reach(), "--out", "pages/why.html"], here);
    let page = std::fs::read_to_string(here.join("pages/why.html")).unwrap();
    assert_eq!(page, std::fs::read_to_string(here.join("failure.html")).unwrap());
}

#[test]
fn exports_lie_beside_the_plan_unless_told_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    succeed(&["plan", "t00_one_arm", "--in-process", "--out", "out"], here);
    for (format, name) in [("glb", "plan.glb"), ("csv", "plan.csv"), ("ros2", "plan.ros2.json")] {
        assert_eq!(succeed(&["export", format, "out/plan.json"], here).trim(), format!("out/{name}"));
        assert!(std::fs::metadata(here.join("out").join(name)).unwrap().len() > 1000);
    }
    let rows = |arguments: &[&str]| {
        succeed(&[&["export", "csv", "out/plan.json", "--out", "deep/table.csv"], arguments].concat(), here);
        std::fs::read_to_string(here.join("deep/table.csv")).unwrap().lines().count()
    };
    assert!(rows(&["--rate", "100"]) > 10 * rows(&["--rate", "5"]));
}

#[test]
fn a_plan_is_shown_and_exported_with_its_own_problem_only() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    succeed(&["plan", "t00_one_arm", "--in-process", "--out", "."], here);
    for command in [&["view"][..], &["export", "csv"], &["export", "glb"], &["export", "ros2"]] {
        let said = refuse(&[command, &["plan.json", "--problem", "t03_relay"]].concat(), here);
        assert!(said.contains("plan.json was made from another problem than t03_relay"), "{said}");
        assert!(refuse(&[command, &["nowhere.json"]].concat(), here).contains("nowhere.json"));
    }
    assert!(refuse(&["export", "csv", "plan.json", "--rate", "0"], here).contains("--rate"));
    std::fs::write(here.join("broken.json"), "{}").unwrap();
    assert!(refuse(&["view", "broken.json"], here).contains("mrtamp schema plan"));
}
