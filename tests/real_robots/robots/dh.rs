//! Forward kinematics against the makers' Denavit-Hartenberg tables.

use std::f64::consts::FRAC_PI_2;

use model::{Pose, Robot};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::{configurations, panda, ur5};

fn turn(axis: &Vector3<f64>, angle: f64) -> Pose {
    Pose::from_parts(Translation3::identity(), UnitQuaternion::new(axis * angle))
}

fn shift(x: f64, z: f64) -> Pose {
    Translation3::new(x, 0.0, z).into()
}

/// Panda: pose of the flange in the base. Table of Craig's convention (Franka Control Interface, "Denavit-Hartenberg
/// parameters"): turn about x by alpha, along x by a, along z by d, turn about z by theta.
pub fn panda_flange(q: &[f64]) -> Pose {
    let table = [
        (0.0, 0.333, 0.0),
        (0.0, 0.0, -FRAC_PI_2),
        (0.0, 0.316, FRAC_PI_2),
        (0.0825, 0.0, FRAC_PI_2),
        (-0.0825, 0.384, -FRAC_PI_2),
        (0.0, 0.0, FRAC_PI_2),
        (0.088, 0.0, FRAC_PI_2),
    ];
    let joints = table.iter().zip(q).map(|((a, d, alpha), theta)| {
        turn(&Vector3::x(), *alpha) * shift(*a, 0.0) * shift(0.0, *d) * turn(&Vector3::z(), *theta)
    });
    joints.fold(Pose::identity(), |pose, joint| pose * joint) * shift(0.0, 0.107)
}

/// UR5: pose of the tool flange in the base. Table of the classical convention (Universal Robots, "DH parameters for
/// calculations of kinematics and dynamics"): turn about z by theta, along z by d, along x by a, turn about x by alpha.
pub fn ur5_flange(q: &[f64]) -> Pose {
    let table = [
        (0.0, 0.089_159, FRAC_PI_2),
        (-0.425, 0.0, 0.0),
        (-0.392_25, 0.0, 0.0),
        (0.0, 0.109_15, FRAC_PI_2),
        (0.0, 0.094_65, -FRAC_PI_2),
        (0.0, 0.0823, 0.0),
    ];
    let joints = table.iter().zip(q).map(|((a, d, alpha), theta)| {
        turn(&Vector3::z(), *theta) * shift(0.0, *d) * shift(*a, 0.0) * turn(&Vector3::x(), *alpha)
    });
    joints.fold(Pose::identity(), |pose, joint| pose * joint)
}

/// Pose of one link in another.
pub fn between(robot: &Robot, q: &[f64], from: &str, to: &str) -> Pose {
    let poses = kinematics::link_poses(robot, q, robot.end_effector.max_opening);
    let pose = |name: &str| poses[robot.links.iter().position(|link| link.name == name).unwrap()];
    pose(from).inverse() * pose(to)
}

/// Greater of metres and radians.
pub fn difference(a: &Pose, b: &Pose) -> f64 {
    (a.translation.vector - b.translation.vector).norm().max(a.rotation.angle_to(&b.rotation))
}

#[test]
fn the_pandas_flange_is_where_its_dh_table_says() {
    let robot = panda();
    for q in configurations(&robot, 1, 2_000) {
        let error = difference(&between(&robot, &q, "panda_link0", "panda_link8"), &panda_flange(&q));
        assert!(error < 1e-7, "seed 1, {q:?}: {error}");
    }
}

#[test]
fn the_ur5s_flange_is_where_its_dh_table_says() {
    let robot = ur5();
    for q in configurations(&robot, 2, 2_000) {
        let error = difference(&between(&robot, &q, "base", "tool0"), &ur5_flange(&q));
        assert!(error < 1e-7, "seed 2, {q:?}: {error}");
    }
}

#[test]
fn at_home_the_pandas_fingers_are_half_a_metre_up_and_point_down() {
    let robot = panda();
    let tcp = between(&robot, &robot.home, "panda_link0", "panda_hand_tcp");
    assert!((tcp.translation.vector - Vector3::new(0.30689, 0.0, 0.48688)).norm() < 1e-4, "{tcp}");
    assert!((tcp * Vector3::z() + Vector3::z()).norm() < 1e-5);
}

#[test]
fn at_home_the_ur5s_flange_points_down_and_its_upper_arm_stands() {
    let robot = ur5();
    let flange = between(&robot, &robot.home, "base_link", "tool0");
    assert!((flange * Vector3::z() + Vector3::z()).norm() < 1e-5);
    let elbow = between(&robot, &robot.home, "base_link", "forearm_link").translation.vector;
    assert!((elbow.z - (0.089_159 + 0.425)).abs() < 1e-6, "{elbow}");
}

#[test]
fn the_pandas_fingers_open_eight_centimetres_and_the_ur5_has_none() {
    assert!((panda().end_effector.max_opening - 0.08).abs() < 1e-12);
    let robot = panda();
    let gap = |opening: f64| {
        let poses = kinematics::link_poses(&robot, &robot.home, opening);
        let finger = |name: &str| poses[robot.links.iter().position(|link| link.name == name).unwrap()].translation;
        (finger("panda_leftfinger").vector - finger("panda_rightfinger").vector).norm()
    };
    assert!((gap(0.08) - 0.08).abs() < 1e-12 && (gap(0.05) - 0.05).abs() < 1e-12 && gap(0.0) < 1e-12);
    assert_eq!(ur5().end_effector.max_opening, 0.0);
}
