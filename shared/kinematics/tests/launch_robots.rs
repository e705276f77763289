//! The robots of the scenes that come with the program.

mod common;

use common::{Random, pose_error, turn_difference, within_limits};
use kinematics::{ArmSolver, link_pose};
use model::{DiskFiles, Pose, Robot, load_problem};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

fn robots(scene: &str) -> Vec<Robot> {
    let path = format!("{}/../../launch/scenes/{scene}", env!("CARGO_MANIFEST_DIR"));
    let problem = load_problem(&DiskFiles, &path).expect("the scene loads");
    assert!(!problem.robots.is_empty());
    problem.robots
}

fn hand(robot: &Robot, q: &[f64]) -> Pose {
    link_pose(robot, q, robot.end_effector.parent_link)
}

#[test]
fn arms_on_fixed_and_moving_bases_are_solved_in_closed_form() {
    for robot in [robots("t00_one_arm.yaml"), robots("figure1.yaml")].concat() {
        let solver = ArmSolver::for_robot(&robot);
        let ArmSolver::Srs(closed) = &solver else { panic!("{} is not recognised", robot.name) };
        let mut random = Random(41);
        for i in 0..3_000 {
            let q = random.configuration(&robot);
            let (base, arm) = q.split_at(robot.base_len());
            let (target, note) = (hand(&robot, &q), format!("{}, seed 41, configuration {i}", robot.name));
            let redundancy = closed.swivel_of(arm) / std::f64::consts::TAU;
            let solutions = solver.solve(&robot, base, &target, redundancy);
            assert!(solutions.iter().any(|s| turn_difference(s, arm) < 1e-6), "{note}");
            for solution in &solutions {
                assert!(within_limits(&robot, solution), "{note}");
                assert!(pose_error(&hand(&robot, &[base, solution].concat()), &target) < 1e-9, "{note}");
            }
        }
    }
}

#[test]
fn an_arm_at_home_holds_the_hand_level_and_stays_there_when_followed() {
    for robot in [robots("t00_one_arm.yaml"), robots("figure1.yaml")].concat() {
        let q = [&robot.start[..robot.base_len()], &robot.home].concat();
        let pose = hand(&robot, &q);
        assert!((pose * Vector3::z()).z.abs() < 1e-5, "{}: approach axis not level", robot.name);
        let solver = ArmSolver::for_robot(&robot);
        let next = solver.follow(&robot, &robot.start[..robot.base_len()], &pose, &robot.home, 1e-6);
        assert!(next.is_some(), "{}", robot.name);
    }
}

#[test]
fn level_grasps_in_front_of_the_shoulder_can_be_approached_straight() {
    let robot = &robots("t00_one_arm.yaml")[0];
    let solver = ArmSolver::for_robot(robot);
    let shoulder = robot.world_from_base * solver.reach(robot).root_from_shoulder;
    let mut random = Random(42);
    let (mut solved, mut approached, mut poses) = (0, 0, 0);
    for _ in 0..300 {
        // Approach axis level, within 60 degrees of straight away from the robot; closing axis level.
        let (bearing, aside) = (random.between(-3.0, 3.0), random.between(-1.0, 1.0));
        let away = Vector3::new(bearing.cos(), bearing.sin(), 0.0);
        let approach = Vector3::new((bearing + aside).cos(), (bearing + aside).sin(), 0.0);
        let axes = Matrix3::from_columns(&[-Vector3::z(), Vector3::z().cross(&approach), approach]);
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let place = shoulder.coords + away * random.between(0.5, 0.65) + Vector3::z() * random.between(-0.3, 0.1);
        let pose = Isometry3::from_parts(place.into(), turn);
        let mut any = false;
        for arm in (0..16).flat_map(|k| solver.solve(robot, &[], &pose, f64::from(k) / 16.0)) {
            solved += 1;
            let back = |step: u32| Translation3::from(approach * (-0.005 * f64::from(step))) * pose;
            let whole_way =
                (1..=20).try_fold(arm, |arm, step| solver.follow(robot, &[], &back(step), &arm, 0.2)).is_some();
            approached += u32::from(whole_way);
            any |= whole_way;
        }
        poses += u32::from(any);
    }
    println!("{poses} of 300 grasps approached, {approached} of {solved} arm configurations");
    assert!(poses >= 285, "only {poses} of 300 grasps can be approached");
}
