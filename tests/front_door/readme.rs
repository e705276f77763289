//! What the README shows must be so.

use std::path::Path;

use crate::{code, mrtamp, said};

fn readme() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap()
}

/// The first block of a kind.
fn block<'a>(text: &'a str, kind: &str) -> &'a str {
    let (_, rest) = text.split_once(&format!("```{kind}\n")).unwrap();
    rest.split_once("```").unwrap().0
}

#[test]
fn the_first_problem_of_the_readme_is_planned_and_certified() {
    let folder = tempfile::tempdir().unwrap();
    let made = mrtamp(&["init", "cell"], folder.path(), &[]);
    assert_eq!(code(&made), 0, "{}", said(&made));
    std::fs::write(folder.path().join("cell/first.yaml"), block(&readme(), "yaml")).unwrap();
    let planned = mrtamp(&["plan", "cell/first.yaml", "--in-process"], folder.path(), &[]);
    assert_eq!(code(&planned), 0, "{}", said(&planned));
    let checked = mrtamp(&["check", "cell/first.yaml", "mrtamp-out/plan.json"], folder.path(), &[]);
    assert_eq!(code(&checked), 0, "{}", said(&checked));
}

#[test]
fn what_the_readme_links_to_is_there_and_its_commands_exist() {
    let readme = readme();
    for (at, _) in readme.match_indices("](") {
        let target = readme[at + 2..].split_once(')').unwrap().0;
        assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join(target).exists(), "{target}");
    }
    let folder = tempfile::tempdir().unwrap();
    let help = said(&mrtamp(&["--help"], folder.path(), &[]));
    let (_, commands) = readme.split_once("## Commands").unwrap();
    let lines: Vec<&str> = block(commands, "sh").lines().collect();
    assert!(lines.len() >= 10, "{lines:?}");
    for line in lines {
        let command = line.split_whitespace().nth(1).unwrap();
        assert!(help.lines().any(|told| told.trim_start().starts_with(&format!("{command} "))), "{command}");
        for option in line.split_whitespace().filter(|word| word.starts_with("--")) {
            let told = said(&mrtamp(&[command, "--help"], folder.path(), &[]));
            assert!(told.contains(option), "{command} {option}");
        }
    }
}
