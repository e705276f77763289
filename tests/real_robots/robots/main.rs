//! Real robots: Franka Panda and Universal Robots UR5, as their makers' packages describe them. `tests/real_robots/fetch`
//! downloads them; without them every test here fails.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod commands;
mod dh;
mod hulls;
mod inverse_kinematics;
mod planning;

use std::path::PathBuf;

use model::{DiskFiles, Robot, load_robot};

/// Folder of the package `example-robot-data`.
fn package() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("cache/example-robot-data");
    assert!(folder.is_dir(), "{} is missing: run tests/real_robots/fetch", folder.display());
    folder
}

fn launch_folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../launch")
}

fn panda_urdf() -> PathBuf {
    package().join("robots/panda_description/urdf/panda.urdf")
}

fn ur5_urdf() -> PathBuf {
    package().join("robots/ur_description/urdf/ur5_robot.urdf")
}

fn load(urdf: &std::path::Path, srdf: &str) -> Robot {
    let srdf = launch_folder().join("robots").join(srdf);
    load_robot(&DiskFiles, &urdf.to_string_lossy(), &srdf.to_string_lossy()).unwrap()
}

fn panda() -> Robot {
    load(&panda_urdf(), "panda.srdf")
}

fn ur5() -> Robot {
    load(&ur5_urdf(), "ur5.srdf")
}

/// `count` configurations within the limits, by seed.
fn configurations(robot: &Robot, seed: u64, count: u64) -> Vec<Vec<f64>> {
    let stream = contract::RandomStream::new(seed, contract::StageKind::Transition, &[&robot.name], "test");
    (0..count)
        .map(|index| {
            let mut values = stream.values(index);
            robot.coordinates.iter().map(|c| c.lower + (c.upper - c.lower) * values.next_unit()).collect()
        })
        .collect()
}
