//! The numeric solver for chains without a closed form.

mod common;

use common::{
    Random, add_arm, add_base, add_coordinate, add_joint, arm, bare, offset_wrist_axes, pose_error, six_axes, sliding,
    srs_axes, within_limits,
};
use kinematics::{ArmSolver, NumericArm, link_pose};
use model::{JointId, JointMotion, JointValue, LinkId, Pose, Robot};
use nalgebra::Translation3;

const TOLERANCE: f64 = 1e-6;
const TARGETS: usize = 1_000;
const REDUNDANCIES: usize = 20;

fn hand(robot: &Robot, q: &[f64]) -> Pose {
    link_pose(robot, q, robot.end_effector.parent_link)
}

/// Shares of random reachable hand poses solved with one and with up to twenty redundancy values; checks every solution.
fn success(robot: &Robot, seed: u64) -> (f64, f64) {
    let solver = ArmSolver::for_robot(robot);
    assert!(matches!(solver, ArmSolver::Numeric(_)));
    let mut random = Random(seed);
    let (mut at_once, mut at_all) = (0, 0);
    for i in 0..TARGETS {
        let q = random.configuration(robot);
        let (base, target) = (&q[..robot.base_len()], hand(robot, &q));
        for k in 0..REDUNDANCIES {
            let solutions = solver.solve(robot, base, &target, k as f64 / REDUNDANCIES as f64);
            for solution in &solutions {
                let error = pose_error(&hand(robot, &[base, solution].concat()), &target);
                assert!(error < TOLERANCE, "seed {seed}, target {i}: misses by {error:e}");
                assert!(within_limits(robot, solution), "seed {seed}, target {i}");
            }
            if !solutions.is_empty() {
                at_once += usize::from(k == 0);
                at_all += 1;
                break;
            }
        }
    }
    (at_once as f64 / TARGETS as f64, at_all as f64 / TARGETS as f64)
}

fn check_success(name: &str, robot: &Robot, seed: u64) {
    let (once, all) = success(robot, seed);
    println!("{name}: {:.1} % with one redundancy value, {:.2} % within {REDUNDANCIES}", 100.0 * once, 100.0 * all);
    assert!(all >= 0.98, "{name}: solved only {all} of the targets");
}

#[test]
fn nearly_all_reachable_poses_of_a_six_joint_arm_are_solved() {
    check_success("six joints", &arm("six joints", six_axes()), 21);
}

#[test]
fn nearly_all_reachable_poses_of_a_seven_joint_arm_with_offsets_are_solved() {
    check_success("seven joints", &arm("seven joints", offset_wrist_axes()), 22);
}

#[test]
fn nearly_all_reachable_poses_of_an_arm_on_a_lift_and_a_moving_base_are_solved() {
    let mut robot = bare("lift");
    add_base(&mut robot, Pose::translation(0.4, 0.2, 0.0));
    let (mut axes, tool, mut limits) = six_axes();
    axes.insert(0, sliding([0.0, 0.0, 1.0]));
    limits.insert(0, [0.0, 0.4]);
    add_arm(&mut robot, &axes, tool, &limits, &[], Some(&mut Random(23)));
    check_success("lift and six joints", &robot, 23);
}

#[test]
fn an_arm_whose_forearm_stays_level_by_mimicking_is_solved() {
    let mut robot = bare("palletiser");
    let z = JointMotion::Revolute { axis: [0.0, 0.0, 1.0] };
    let y = JointMotion::Revolute { axis: [0.0, 1.0, 0.0] };
    let value = add_coordinate(&mut robot, [-3.0, 3.0]);
    let column = add_joint(&mut robot, LinkId(0), Pose::identity(), z.clone(), value);
    let value = add_coordinate(&mut robot, [-1.0, 1.5]);
    let upper = add_joint(&mut robot, column, Pose::translation(0.1, 0.0, 0.4), y.clone(), value);
    let level = JointValue::Mimic { of: JointId(1), multiplier: -1.0, offset: 0.0 };
    let forearm = add_joint(&mut robot, upper, Pose::translation(0.0, 0.0, 0.5), y, level);
    let value = add_coordinate(&mut robot, [-3.0, 3.0]);
    let tool = add_joint(&mut robot, forearm, Pose::translation(0.3, 0.0, 0.0), z, value);
    robot.end_effector.parent_link = tool;
    check_success("mimic", &robot, 24);
}

#[test]
fn the_same_question_has_the_same_answer_and_other_redundancies_have_others() {
    let robot = arm("seven joints", offset_wrist_axes());
    let target = hand(&robot, &[0.3, 0.2, -0.4, -1.5, 0.1, 1.6, 0.5]);
    let answers = |u: f64| ArmSolver::for_robot(&robot).solve(&robot, &[], &target, u);
    let all: Vec<_> = (0..REDUNDANCIES).map(|k| answers(k as f64 / REDUNDANCIES as f64)).collect();
    for (k, answer) in all.iter().enumerate() {
        assert_eq!(*answer, answers(k as f64 / REDUNDANCIES as f64));
    }
    let mut different: Vec<_> = all.into_iter().flatten().collect();
    different.dedup();
    assert!(different.len() > REDUNDANCIES, "only {} different solutions", different.len());
}

#[test]
fn a_pose_out_of_reach_or_without_numbers_is_refused() {
    let robot = arm("six joints", six_axes());
    let solver = ArmSolver::for_robot(&robot);
    for (x, u) in [(5.0, 0.3), (f64::NAN, 0.3), (f64::INFINITY, 0.3), (0.4, f64::NAN)] {
        assert!(solver.solve(&robot, &[], &Pose::translation(x, 0.0, 0.0), u).is_empty());
    }
    let twisted = Pose::rotation(nalgebra::Vector3::new(f64::NAN, 0.0, 0.0));
    for redundancy in [0.0, 0.3] {
        assert!(solver.solve(&robot, &[], &(Pose::translation(0.4, 0.1, 0.3) * twisted), redundancy).is_empty());
    }
    assert!(solver.follow(&robot, &[], &Pose::translation(f64::NAN, 0.0, 0.0), &[0.1; 6], 9.0).is_none());
    assert!(solver.follow(&robot, &[], &Pose::translation(5.0, 0.0, 0.0), &[0.1; 6], 9.0).is_none());
    let bare = bare("no arm");
    assert!(NumericArm::of(&bare).solve(&Pose::translation(0.1, 0.0, 0.0), 0.0).is_empty());
}

#[test]
fn straight_hand_paths_are_followed_in_short_steps() {
    for (name, axes) in [("six joints", six_axes()), ("seven joints", offset_wrist_axes())] {
        let robot = arm(name, axes);
        let solver = ArmSolver::for_robot(&robot);
        let mut random = Random(25);
        let mut followed = 0;
        for i in 0..200 {
            let mut q = random.configuration(&robot);
            let (start, way) = (hand(&robot, &q), random.direction() * 0.1);
            let arrived = (1..=50).all(|step| {
                let target = Translation3::from(way * (f64::from(step) / 50.0)) * start;
                let Some(next) = solver.follow(&robot, &[], &target, &q, 0.1) else { return false };
                assert!(pose_error(&hand(&robot, &next), &target) < TOLERANCE, "{name}, seed 25, path {i}");
                assert!(within_limits(&robot, &next), "{name}, seed 25, path {i}");
                assert!(next.iter().zip(&q).all(|(a, b)| (a - b).abs() <= 0.1), "{name}, seed 25, path {i}");
                q = next;
                true
            });
            followed += u32::from(arrived);
        }
        println!("{name}: {followed} of 200 random straight paths followed");
        assert!(followed >= 120, "{name}: only {followed} of 200 paths followed");
    }
}

#[test]
fn descent_and_closed_form_agree_on_an_arm_that_both_can_solve() {
    let robot = arm("srs", srs_axes());
    let numeric = NumericArm::of(&robot);
    let mut random = Random(26);
    for i in 0..200 {
        let q = random.configuration(&robot);
        let target = hand(&robot, &q);
        let solved = (0..REDUNDANCIES).flat_map(|k| numeric.solve(&target, k as f64 / REDUNDANCIES as f64)).next();
        let Some(solution) = solved else { continue };
        let ArmSolver::Srs(closed) = ArmSolver::for_robot(&robot) else { panic!("not recognised") };
        let exact = closed.nearest(&target, &solution).unwrap_or_else(|| panic!("seed 26, target {i}"));
        assert!(exact.iter().zip(&solution).all(|(a, b)| (a - b).abs() < 1e-2), "seed 26, target {i}");
    }
}
