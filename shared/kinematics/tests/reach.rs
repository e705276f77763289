//! Bounds on the distance between shoulder and hand.

mod common;

use common::{
    Axis, Random, add_arm, add_coordinate, add_joint, arm, bare, offset_srs_axes, offset_wrist_axes, six_axes, sliding,
    srs_axes,
};
use kinematics::{ArmSolver, Reach, link_pose};
use model::{JointMotion, LinkId, Pose, Robot};
use nalgebra::Point3;
use std::f64::consts::PI;

/// Least and greatest distance of the hand from the shoulder over random configurations.
fn seen(robot: &Robot, reach: &Reach, seed: u64) -> (f64, f64) {
    let mut random = Random(seed);
    (0..20_000).fold((f64::INFINITY, 0.0), |(least, greatest), _| {
        let q = random.configuration(robot);
        let hand = link_pose(robot, &q, robot.end_effector.parent_link).translation.vector;
        let distance = (hand - reach.root_from_shoulder.coords).norm();
        (least.min(distance), greatest.max(distance))
    })
}

#[test]
fn an_arm_with_spherical_joints_reaches_from_its_shoulder_as_far_as_its_elbow_lets_it() {
    for seed in 0..20 {
        let mut robot = bare("srs");
        let (axes, tool, limits) = srs_axes();
        let random = &mut Random(seed);
        add_arm(&mut robot, &axes, tool, &limits, &[], (seed > 0).then_some(random));
        let reach = ArmSolver::for_robot(&robot).reach(&robot);
        assert!((reach.root_from_shoulder - Point3::new(0.0, 0.0, 0.34)).norm() < 1e-6, "seed {seed}: {reach:?}");
        assert!((reach.greatest - 0.926).abs() < 1e-6, "seed {seed}: {reach:?}");
        // Bent by 120 degrees, the wrist is 0.4 from the shoulder.
        assert!((reach.least - (0.4 - 0.126)).abs() < 1e-6, "seed {seed}: {reach:?}");
    }
}

#[test]
fn no_configuration_leaves_the_bounds_and_the_bounds_are_not_far_off() {
    let with_lift = || {
        let (mut axes, tool, mut limits): (Vec<Axis>, Pose, Vec<[f64; 2]>) = offset_srs_axes();
        axes.insert(3, sliding([0.0, 0.6, 0.8]));
        limits.insert(3, [-0.1, 0.3]);
        (axes, tool, limits)
    };
    let arms = [srs_axes(), offset_srs_axes(), offset_wrist_axes(), six_axes(), with_lift()];
    for (i, axes) in arms.into_iter().enumerate() {
        let robot = arm("arm", axes);
        let reach = Reach::of(&robot);
        let (least, greatest) = seen(&robot, &reach, 31);
        println!("arm {i}: bounds {:.3}..{:.3}, seen {least:.3}..{greatest:.3}", reach.least, reach.greatest);
        assert!(least >= reach.least - 1e-9 && greatest <= reach.greatest + 1e-9, "arm {i}");
        assert!(reach.greatest <= 1.25 * greatest, "arm {i}: {} for {greatest}", reach.greatest);
    }
}

#[test]
fn a_limited_hinge_bounds_the_distance_exactly() {
    for [lower, upper] in [[0.5, 1.0], [-0.2, 0.3], [2.0, 4.0], [3.0, 9.0], [f64::NEG_INFINITY, f64::INFINITY]] {
        let mut robot = bare("hinge");
        let axis = [0.0, 0.0, 1.0];
        let value = add_coordinate(&mut robot, [-3.0, 3.0]);
        let bar = add_joint(&mut robot, LinkId(0), Pose::identity(), JointMotion::Revolute { axis }, value);
        let value = add_coordinate(&mut robot, [lower, upper]);
        let elbow = Pose::translation(0.7, 0.0, 0.0);
        let lower_bar = add_joint(&mut robot, bar, elbow, JointMotion::Revolute { axis }, value);
        let value = add_coordinate(&mut robot, [-3.0, 3.0]);
        let tip = Pose::translation(0.4, 0.0, 0.0);
        robot.end_effector.parent_link = add_joint(&mut robot, lower_bar, tip, JointMotion::Revolute { axis }, value);
        let reach = Reach::of(&robot);
        let distance = |q: f64| (0.7_f64.powi(2) + 0.4_f64.powi(2) + 2.0 * 0.7 * 0.4 * q.cos()).sqrt();
        let samples =
            (0..=100_000).map(|i| lower.max(-PI) + (upper.min(2.0 * PI) - lower.max(-PI)) * f64::from(i) / 1e5);
        let (least, greatest) = samples
            .map(distance)
            .fold((f64::INFINITY, 0.0_f64), |(least, greatest), d| (least.min(d), greatest.max(d)));
        assert!((reach.least - least).abs() < 1e-6, "{lower}..{upper}: {reach:?}, seen {least}");
        assert!((reach.greatest - greatest).abs() < 1e-6, "{lower}..{upper}: {reach:?}, seen {greatest}");
    }
}

#[test]
fn a_robot_without_an_arm_reaches_its_own_hand_only() {
    let mut robot = bare("post");
    robot.end_effector.parent_link = add_joint(
        &mut robot,
        LinkId(0),
        Pose::translation(0.0, 0.0, 0.7),
        JointMotion::Fixed,
        model::JointValue::Constant(0.0),
    );
    let reach = Reach::of(&robot);
    assert!((reach.least, reach.greatest) == (0.0, 0.0));
    assert!(reach.contains(&Pose::translation(0.0, 0.0, 0.7)) && !reach.contains(&Pose::identity()));
}
