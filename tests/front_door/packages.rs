//! ROS packages: by name, by environment, beside the file; and what is told where there is none.

use std::path::Path;

use crate::{code, copy_robot, mrtamp, said, t00_with};

/// A scene whose robot is in package `arms`, which lies in `folder`.
fn scene_and_package(root: &Path, folder: &str) {
    for file in ["fa7.urdf", "fa7.srdf"] {
        copy_robot(file, &root.join(folder).join("descriptions").join(file));
    }
    let scene = t00_with("package://arms/descriptions/fa7.urdf", "package://arms/descriptions/fa7.srdf");
    std::fs::create_dir_all(root.join("scenes")).unwrap();
    std::fs::write(root.join("scenes/scene.yaml"), scene).unwrap();
}

const PLAN: [&str; 5] = ["plan", "scenes/scene.yaml", "--in-process", "--out", "out"];

#[test]
fn a_package_is_found_by_the_folder_that_is_named_for_it() {
    let root = tempfile::tempdir().unwrap();
    scene_and_package(root.path(), "elsewhere/my_arms");
    let planned = mrtamp(&[&PLAN[..], &["--package", "arms=elsewhere/my_arms"]].concat(), root.path(), &[]);
    assert_eq!(code(&planned), 0, "{}", said(&planned));
    let check = ["check", "scenes/scene.yaml", "out/plan.json"];
    assert_eq!(code(&mrtamp(&check, root.path(), &[])), 2, "without the folder the problem cannot be read");
    let checked = mrtamp(&[&check[..], &["--package", "arms=elsewhere/my_arms"]].concat(), root.path(), &[]);
    assert_eq!(code(&checked), 0, "{}", said(&checked));
    for command in [&["view"][..], &["export", "csv"]] {
        let shows = [command, &["out/plan.json", "--problem", "scenes/scene.yaml"]].concat();
        assert_eq!(code(&mrtamp(&shows, root.path(), &[])), 2, "{command:?} without the folder");
        let shown = mrtamp(&[&shows[..], &["--package", "arms=elsewhere/my_arms"]].concat(), root.path(), &[]);
        assert_eq!(code(&shown), 0, "{}", said(&shown));
    }
}

#[test]
fn packages_are_found_where_the_environment_of_ros_says() {
    for (folder, variable, value) in [
        ("ws/src/arms", "ROS_PACKAGE_PATH", "/nowhere:ws/src"),
        ("ws/src/arms", "ROS_PACKAGE_PATH", "ws/src/arms"),
        ("install/share/arms", "AMENT_PREFIX_PATH", "install:/nowhere"),
        ("arms", "AMENT_PREFIX_PATH", ""),
    ] {
        let root = tempfile::tempdir().unwrap();
        scene_and_package(root.path(), folder);
        let planned = mrtamp(&PLAN, root.path(), &[(variable, value)]);
        assert_eq!(code(&planned), 0, "{folder} by {variable}: {}", said(&planned));
    }
}

#[test]
fn where_a_package_is_missing_every_path_tried_is_told() {
    let root = tempfile::tempdir().unwrap();
    scene_and_package(root.path(), "elsewhere/arms");
    let refused = mrtamp(
        &[&PLAN[..], &["--package", "arms=first"]].concat(),
        root.path(),
        &[("ROS_PACKAGE_PATH", "second"), ("AMENT_PREFIX_PATH", "third")],
    );
    assert_eq!(code(&refused), 2);
    // Lines are broken anywhere.
    let told = said(&refused).split_whitespace().collect::<String>();
    let tried = ["first", "second/arms", "third/share/arms", "scenes/arms", "arms"]
        .map(|folder| format!("{folder}/descriptions/fa7.urdf"))
        .join(",");
    assert!(told.contains(&tried), "no {tried} in {told}");
    assert!(told.contains("--packagearms=FOLDER"), "{told}");
}

#[test]
fn a_package_without_a_folder_is_refused() {
    let root = tempfile::tempdir().unwrap();
    let refused = mrtamp(&["plan", "t00_one_arm", "--package", "arms"], root.path(), &[]);
    assert_eq!(code(&refused), 2);
    assert!(said(&refused).contains("NAME=FOLDER"), "{}", said(&refused));
}
