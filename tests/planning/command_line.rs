//! The program as a user calls it, in one process.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

use crate::scene_path;

fn mrtamp(arguments: &[&str], folder: &Path) -> Output {
    Command::cargo_bin("mrtamp").unwrap().args(arguments).current_dir(folder).output().unwrap()
}

fn plan_in_process(scene: &str, seed: &str, folder: &Path) -> Vec<u8> {
    let ended = mrtamp(&["plan", scene, "--in-process", "--seed", seed, "--out", "out"], folder);
    assert_eq!(ended.status.code(), Some(0), "{}", String::from_utf8_lossy(&ended.stderr));
    std::fs::read(folder.join("out/plan.json")).unwrap()
}

#[test]
fn a_written_plan_passes_check_and_a_corrupted_copy_is_rejected_by_rule() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = plan_in_process("t03_relay", "0", folder.path());
    let scene = scene_path("t03_relay");
    let check = |file: &str| mrtamp(&["check", &scene.to_string_lossy(), file], folder.path());
    assert_eq!(check("out/plan.json").status.code(), Some(0));
    let mut plan = plan::read_plan(&bytes).unwrap();
    for knot in &mut plan.robots[1].knots {
        knot.t += 0.7;
    }
    std::fs::write(folder.path().join("late.json"), plan::write_plan(&plan).unwrap()).unwrap();
    let rejected = check("late.json");
    assert_eq!(rejected.status.code(), Some(6));
    assert!(String::from_utf8_lossy(&rejected.stdout).contains("V"), "{rejected:?}");
}

#[test]
fn equal_seeds_give_equal_bytes_and_other_seeds_other_plans() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, c] = ["1", "1", "2"].map(|seed| plan_in_process("t01_one_robot", seed, folder.path()));
    assert!(a == b && a != c);
}

#[test]
fn bad_input_ends_with_code_2_names_the_place_and_touches_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("out")).unwrap();
    std::fs::write(folder.path().join("out/plan.json"), "mine").unwrap();
    std::fs::write(folder.path().join("bad.yaml"), "robots: []\nfixt: []\n").unwrap();
    let ended = mrtamp(&["plan", "bad.yaml", "--in-process", "--out", "out"], folder.path());
    assert_eq!(ended.status.code(), Some(2));
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(said.contains("bad.yaml:2") && said.contains("fixt"), "{said}");
    assert_eq!(std::fs::read(folder.path().join("out/plan.json")).unwrap(), b"mine");
    let missing = mrtamp(&["plan", "nowhere.yaml", "--in-process"], folder.path());
    assert_eq!(missing.status.code(), Some(2));
    let no_plan = mrtamp(&["check", "t00_one_arm", "bad.yaml"], folder.path());
    assert_eq!(no_plan.status.code(), Some(2));
}
