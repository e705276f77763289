//! The scenes that come with the program.

use model::{DiskFiles, Problem, load_problem};

fn scene(name: &str) -> Problem {
    let path = format!("{}/../../launch/scenes/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    load_problem(&DiskFiles, &path).unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)))
}

#[test]
fn every_scene_loads() {
    let folder = format!("{}/../../launch/scenes", env!("CARGO_MANIFEST_DIR"));
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter_map(|name| name.strip_suffix(".yaml").map(str::to_owned))
        .collect();
    names.sort();
    for name in &names {
        assert_eq!(&scene(name).name, name);
    }
    assert!(names.len() >= 8, "{names:?}");
}
