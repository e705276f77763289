//! What somebody meets who brings a robot or a problem: `init`, `robot`, ROS packages, bad input.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod bad_input;
mod init;
mod packages;
mod readme;
mod robot;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;

/// Runs the program in a folder, with these environment variables and without ROS's.
fn mrtamp(arguments: &[&str], folder: &Path, variables: &[(&str, &str)]) -> Output {
    let mut command = Command::cargo_bin("mrtamp").unwrap();
    command.args(arguments).current_dir(folder).env_remove("ROS_PACKAGE_PATH").env_remove("AMENT_PREFIX_PATH");
    command.envs(variables.iter().copied()).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn said(output: &Output) -> String {
    format!("{}\n{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

fn launch_folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("launch")
}

/// All files below a folder with their bytes.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(contents(&path));
        } else {
            found.insert(path.clone(), std::fs::read(&path).unwrap());
        }
    }
    found
}

/// Copies a robot's file.
fn copy_robot(file: &str, to: &Path) {
    std::fs::create_dir_all(to.parent().unwrap()).unwrap();
    std::fs::copy(launch_folder().join("robots").join(file), to).unwrap();
}

/// The smallest scene with other robot files.
fn t00_with(urdf: &str, srdf: &str) -> String {
    let scene = std::fs::read_to_string(launch_folder().join("scenes/t00_one_arm.yaml")).unwrap();
    scene.replace("../robots/fa7.urdf", urdf).replace("../robots/fa7.srdf", srdf)
}
