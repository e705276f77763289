//! `mrtamp init`.

use crate::{code, contents, mrtamp, said};

#[test]
fn a_new_problem_is_planned_at_once_and_certified() {
    let folder = tempfile::tempdir().unwrap();
    let made = mrtamp(&["init", "cell"], folder.path(), &[]);
    assert_eq!(code(&made), 0, "{}", said(&made));
    let planned = mrtamp(&["plan", "cell/problem.yaml", "--in-process", "--out", "out"], folder.path(), &[]);
    assert_eq!(code(&planned), 0, "{}", said(&planned));
    let checked = mrtamp(&["check", "cell/problem.yaml", "out/plan.json"], folder.path(), &[]);
    assert_eq!(code(&checked), 0, "{}", said(&checked));
}

#[test]
fn a_new_problem_lists_its_files_and_explains_every_part() {
    let folder = tempfile::tempdir().unwrap();
    let made = mrtamp(&["init"], folder.path(), &[]);
    let listed = String::from_utf8_lossy(&made.stdout).into_owned();
    let files = contents(&folder.path().join("my-problem"));
    assert_eq!(listed.lines().count(), files.len());
    assert!(listed.lines().all(|file| folder.path().join(file).is_file()), "{listed}");
    let problem = std::fs::read_to_string(folder.path().join("my-problem/problem.yaml")).unwrap();
    let lines: Vec<&str> = problem.lines().collect();
    for key in ["robots:", "fixed:", "movable:", "regions:", "task:", "orderings:", "settings:"] {
        let at = lines.iter().position(|line| line.starts_with(key)).unwrap_or_else(|| panic!("{key}"));
        assert!(lines[at - 1].starts_with("# "), "{key} is not explained");
    }
    let schema: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("my-problem/problem.schema.json")).unwrap()).unwrap();
    assert!(schema["properties"]["robots"].is_object());
}

#[test]
fn nothing_that_is_there_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("mine")).unwrap();
    std::fs::write(folder.path().join("mine/problem.yaml"), "mine").unwrap();
    std::fs::write(folder.path().join("file"), "mine").unwrap();
    let before = contents(folder.path());
    for name in ["mine", "file"] {
        let refused = mrtamp(&["init", name], folder.path(), &[]);
        assert_eq!(code(&refused), 2, "{}", said(&refused));
        assert!(said(&refused).contains(name));
    }
    assert_eq!(contents(folder.path()), before);
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    assert_eq!(code(&mrtamp(&["init", "empty"], folder.path(), &[])), 0);
}
