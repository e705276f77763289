//! The house rules that a program can check: which room may name which, where a dependency is named, how long a file is.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What each crate may name, directly or through another.
const ARROWS: [(&str, &[&str]); 15] = [
    ("model", &[]),
    ("skeleton", &["model"]),
    ("plan", &["skeleton"]),
    ("kinematics", &["model"]),
    ("collision", &["kinematics", "plan"]),
    ("contract", &["plan"]),
    ("validation", &["plan"]),
    ("bus", &["contract"]),
    ("placement", &["contract", "collision"]),
    ("transition", &["contract", "collision", "kinematics"]),
    ("roadmap", &["contract", "collision", "kinematics"]),
    ("composite", &["contract", "collision", "kinematics"]),
    ("refiner", &["contract"]),
    ("mrtamp", &["bus", "validation", "placement", "transition", "roadmap", "composite", "refiner"]),
    ("robot-tests", &["mrtamp"]),
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn reachable(from: &str) -> BTreeSet<String> {
    let arrows: BTreeMap<&str, &[&str]> = ARROWS.into_iter().collect();
    let (mut seen, mut stack) = (BTreeSet::new(), vec![from]);
    while let Some(name) = stack.pop() {
        for next in arrows.get(name).copied().unwrap_or_default() {
            if seen.insert((*next).to_owned()) {
                stack.push(next);
            }
        }
    }
    seen
}

#[test]
fn every_crate_names_only_crates_that_the_design_allows() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(root())
        .output()
        .unwrap();
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let ours: BTreeSet<&str> = packages.iter().map(|package| package["name"].as_str().unwrap()).collect();
    assert!(ours.contains("mrtamp") && ours.len() >= 14, "{ours:?}");
    for package in packages {
        let name = package["name"].as_str().unwrap();
        let allowed = reachable(name);
        for dependency in package["dependencies"].as_array().unwrap() {
            let named = dependency["name"].as_str().unwrap();
            assert!(!ours.contains(named) || allowed.contains(named), "{name} may not name {named}");
        }
    }
}

fn sources() -> Vec<(PathBuf, String)> {
    let (mut found, mut folders) =
        (Vec::new(), ["shared", "services", "launch", "tests"].map(|f| root().join(f)).to_vec());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                if path.file_name().is_some_and(|name| name != "target") {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                found.push((path.strip_prefix(root()).unwrap().to_owned(), text));
            }
        }
    }
    found.sort();
    found
}

/// Files whose code (comments apart) names a crate.
fn files_naming(name: &str) -> Vec<PathBuf> {
    let is_code = |line: &&str| !line.trim_start().starts_with("//");
    let names = |text: &str| text.lines().filter(is_code).any(|line| line.contains(&format!("{name}::")));
    sources()
        .into_iter()
        .filter(|(path, text)| path != Path::new("tests/tidy.rs") && names(text))
        .map(|(path, _)| path)
        .collect()
}

fn assert_only_within(name: &str, places: &[&str]) {
    let files = files_naming(name);
    assert!(!files.is_empty(), "{name} is named nowhere");
    for file in files {
        let within = places.iter().any(|place| file.starts_with(place));
        assert!(within, "{} names {name}, which belongs to {places:?}", file.display());
    }
}

#[test]
fn each_library_is_named_only_in_its_own_room() {
    // `lib.rs` re-exports the transport, whose module has the library's name.
    assert_only_within("iceoryx2", &["shared/bus/src/iceoryx2.rs", "shared/bus/src/lib.rs"]);
    assert_only_within("parry3d_f64", &["shared/collision", "shared/validation"]);
    assert_only_within("urdf_rs", &["shared/model"]);
    assert_only_within("bincode", &["shared/contract/src/codec.rs"]);
}

#[test]
fn no_source_file_is_longer_than_six_hundred_lines() {
    for (path, text) in sources() {
        let lines = text.lines().count();
        assert!(lines <= 600, "{} has {lines} lines: perhaps two rooms in one", path.display());
    }
}

#[test]
fn no_code_is_left_unfinished_or_skipped() {
    let marks = ["todo!(", "unimplemented!(", "TO\u{44}O", "FIX\u{4d}E", "#[ignore"];
    for (path, text) in sources().iter().filter(|(path, _)| path != Path::new("tests/tidy.rs")) {
        for mark in marks {
            assert!(!text.contains(mark), "{} contains {mark}", path.display());
        }
    }
}
