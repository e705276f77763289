//! The closed-form solver for arms with spherical shoulder, elbow and spherical wrist.

mod common;

use common::{
    Axis, Random, add_arm, add_base, add_coordinate, add_joint, arm, bare, offset_srs_axes, offset_wrist_axes,
    pose_error, six_axes, sliding, srs_axes, turn_difference, with_other_zero, within_limits,
};
use kinematics::{ArmSolver, SrsArm, link_pose};
use model::{JointMotion, LinkId, Pose, Robot};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::{PI, TAU};

const TOLERANCE: f64 = 1e-9;

fn hand(robot: &Robot, q: &[f64]) -> Pose {
    link_pose(robot, q, robot.end_effector.parent_link)
}

/// Solves for the hand pose of `q` at its own swivel and checks all that a solution promises; returns the solutions.
fn check_configuration(robot: &Robot, solver: &SrsArm, q: &[f64], note: &str) -> Vec<Vec<f64>> {
    let target = hand(robot, q);
    let swivel = solver.swivel_of(q);
    let solutions = solver.solve(&target, swivel);
    assert!(solutions.len() <= 8, "{note}: {} solutions", solutions.len());
    for (i, solution) in solutions.iter().enumerate() {
        let error = pose_error(&hand(robot, solution), &target);
        assert!(error < TOLERANCE, "{note}: solution {i} misses by {error:e}");
        assert!(within_limits(robot, solution), "{note}: solution {i} breaks a limit");
        let turned = turn_difference(&[solver.swivel_of(solution)], &[swivel]);
        assert!(turned < 1e-6, "{note}: solution {i} has another swivel, by {turned:e}");
        let again = solutions[..i].iter().any(|other| turn_difference(other, solution) < 1e-9);
        assert!(!again, "{note}: solution {i} comes twice");
    }
    solutions
}

/// As [`check_configuration`], and `q` itself must be among the solutions.
fn check_round_trip(robot: &Robot, solver: &SrsArm, q: &[f64], note: &str) -> usize {
    let solutions = check_configuration(robot, solver, q, note);
    let nearest = solutions.iter().map(|s| turn_difference(s, q)).fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-6, "{note}: {q:?} not among its solutions, nearest {nearest:e}");
    solutions.len()
}

#[test]
fn every_solution_reproduces_its_target_and_the_generating_configuration_is_one() {
    let robot = arm("srs", srs_axes());
    let solver = SrsArm::recognise(&robot).unwrap();
    let mut random = Random(7);
    let mut found = 0;
    for i in 0..20_000 {
        let q = random.configuration(&robot);
        found += check_round_trip(&robot, &solver, &q, &format!("seed 7, configuration {i}"));
    }
    println!("{:.2} solutions per swivel", f64::from(u32::try_from(found).unwrap()) / 20_000.0);
}

#[test]
fn swivels_other_than_the_generating_one_give_exact_solutions_too() {
    let robot = arm("srs", srs_axes());
    let solver = SrsArm::recognise(&robot).unwrap();
    let mut random = Random(8);
    let mut found = 0;
    for i in 0..5_000 {
        let target = hand(&robot, &random.configuration(&robot));
        let swivel = random.between(-PI, PI);
        for solution in solver.solve(&target, swivel) {
            found += 1;
            let note = format!("seed 8, target {i}");
            assert!(pose_error(&hand(&robot, &solution), &target) < TOLERANCE, "{note}");
            assert!(within_limits(&robot, &solution), "{note}");
            assert!(turn_difference(&[solver.swivel_of(&solution)], &[swivel]) < 1e-6, "{note}");
        }
    }
    assert!(found > 5_000, "only {found} solutions for 5000 targets");
}

/// The arm with other zero angles, frames anywhere on the axes and some axes reversed; limits move with the zero angles.
fn variant(random: &mut Random, (axes, tool, limits): (Vec<Axis>, Pose, Vec<[f64; 2]>)) -> Robot {
    let zero: Vec<f64> = limits.iter().map(|[lower, upper]| random.between(*lower, *upper)).collect();
    let (axes, tool) = with_other_zero(&axes, tool, &zero);
    let limits: Vec<[f64; 2]> = limits.iter().zip(&zero).map(|([l, u], z)| [l - z, u - z]).collect();
    let flipped: Vec<bool> = axes.iter().map(|_| random.unit() < 0.5).collect();
    let mut robot = bare("variant");
    add_arm(&mut robot, &axes, tool, &limits, &flipped, Some(random));
    robot
}

#[test]
fn other_zero_angles_frames_and_axis_signs_are_solved_too() {
    for seed in 0..200 {
        let mut random = Random(seed);
        let axes = if seed % 2 == 0 { srs_axes() } else { offset_srs_axes() };
        let robot = variant(&mut random, axes);
        let Some(solver) = SrsArm::recognise(&robot) else { panic!("seed {seed} is not recognised") };
        for i in 0..50 {
            let q = random.configuration_in_full(&robot);
            check_round_trip(&robot, &solver, &q, &format!("seed {seed}, configuration {i}"));
        }
    }
}

impl Random {
    /// A configuration within limits that may lie beyond ±3.
    fn configuration_in_full(&mut self, robot: &Robot) -> Vec<f64> {
        robot.coordinates.iter().map(|c| self.between(c.lower.max(-9.0), c.upper.min(9.0))).collect()
    }
}

#[test]
fn axes_that_miss_each_other_by_rounded_numbers_are_polished() {
    let (mut axes, tool, limits) = srs_axes();
    // What 1.5708 for a quarter turn does to the axes.
    axes[1].direction = Vector3::new(3.7e-6, 1.0, -3.7e-6).normalize();
    axes[4].point.x += 1.5e-6;
    axes[5].point.z -= 2.0e-6;
    let robot = arm("rounded", (axes, tool, limits));
    let solver = SrsArm::recognise(&robot).unwrap();
    let mut random = Random(11);
    let mut recovered = 0;
    for i in 0..2_000 {
        let q = random.configuration(&robot);
        let target = hand(&robot, &q);
        let solutions = solver.solve(&target, solver.swivel_of(&q));
        for solution in &solutions {
            assert!(pose_error(&hand(&robot, solution), &target) < TOLERANCE, "seed 11, configuration {i}");
            assert!(within_limits(&robot, solution), "seed 11, configuration {i}");
        }
        recovered += usize::from(solutions.iter().any(|s| turn_difference(s, &q) < 1e-2));
    }
    assert!(recovered >= 1_980, "only {recovered} of 2000 configurations recovered");
}

#[test]
fn joints_without_limits_or_with_wide_ones_get_the_turn_nearest_to_zero() {
    let (axes, tool, mut limits) = srs_axes();
    limits[0] = [f64::NEG_INFINITY, f64::INFINITY];
    limits[4] = [-TAU, TAU];
    limits[6] = [PI, 3.5 * PI];
    let robot = arm("wide", (axes, tool, limits));
    let solver = SrsArm::recognise(&robot).unwrap();
    let mut random = Random(12);
    for i in 0..2_000 {
        let q = random.configuration_in_full(&robot);
        let note = format!("seed 12, configuration {i}");
        check_round_trip(&robot, &solver, &q, &note);
        for solution in solver.solve(&hand(&robot, &q), solver.swivel_of(&q)) {
            assert!(solution[0].abs() <= PI + 1e-9 && solution[4].abs() <= PI + 1e-9, "{note}");
            assert!(solution[6] < 3.0 * PI + 1e-9, "{note}: {} is a turn too far", solution[6]);
        }
    }
}

#[test]
fn a_moving_base_and_coordinates_beside_the_chain_are_left_alone() {
    let mut robot = bare("mobile with a head");
    let stand = Isometry3::from_parts(Translation3::new(1.0, -2.0, 0.3), UnitQuaternion::new(Vector3::z() * 0.7));
    add_base(&mut robot, stand);
    let value = add_coordinate(&mut robot, [0.2, 0.9]);
    let up = [0.0, 0.0, 1.0];
    add_joint(&mut robot, LinkId(0), Pose::identity(), JointMotion::Revolute { axis: up }, value);
    let (axes, tool, limits) = srs_axes();
    add_arm(&mut robot, &axes, tool, &limits, &[], None);
    let solver = ArmSolver::for_robot(&robot);
    assert!(matches!(solver, ArmSolver::Srs(_)));
    let head = robot.home[0];
    let mut random = Random(13);
    let mut found = 0;
    for i in 0..500 {
        let q = random.configuration(&robot);
        let (base, target) = (&q[..3], hand(&robot, &q));
        for solution in solver.solve(&robot, base, &target, random.unit()) {
            found += 1;
            assert_eq!(solution[0], head, "seed 13, configuration {i}");
            let whole = [base, &solution].concat();
            assert!(pose_error(&hand(&robot, &whole), &target) < TOLERANCE, "seed 13, configuration {i}");
        }
    }
    assert!(found > 500, "only {found} solutions");
}

#[test]
fn unreachable_and_meaningless_targets_give_no_solution() {
    let robot = arm("srs", srs_axes());
    let solver = SrsArm::recognise(&robot).unwrap();
    let mut random = Random(14);
    for _ in 0..500 {
        let away = random.direction() * random.between(0.927, 50.0) + Vector3::z() * 0.34;
        let target = Isometry3::from_parts(away.into(), random.rotation());
        assert!(solver.solve(&target, random.between(-PI, PI)).is_empty());
        // The elbow bends by 120 degrees at most: the wrist stays 0.4 from the shoulder.
        let wrist = random.direction() * random.between(0.0, 0.399) + Vector3::z() * 0.34;
        let turn = random.rotation();
        let target = Isometry3::from_parts((wrist + turn * (Vector3::z() * 0.126)).into(), turn);
        assert!(solver.solve(&target, random.between(-PI, PI)).is_empty());
    }
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        assert!(solver.solve(&Pose::translation(bad, 0.0, 0.5), 0.0).is_empty());
        assert!(solver.nearest(&Pose::translation(bad, 0.0, 0.5), &[0.0; 7]).is_none());
    }
    let twisted = Pose::rotation(Vector3::new(f64::NAN, 0.0, 0.0));
    assert!(solver.solve(&(Pose::translation(0.4, 0.1, 0.6) * twisted), 0.0).is_empty());
    assert!(solver.solve(&hand(&robot, &[0.3; 7]), f64::NAN).is_empty());
}

#[test]
fn singular_configurations_are_solved_exactly() {
    let robot = arm("srs", srs_axes());
    let solver = SrsArm::recognise(&robot).unwrap();
    let mut random = Random(15);
    for i in 0..4_000 {
        let mut q = random.configuration(&robot);
        // Straight elbow, aligned wrist, aligned shoulder and all their combinations, exactly or almost.
        let almost = [0.0, 0.0, 1e-15, 1e-12, 1e-10, 1e-9, 1e-8, 1e-6][i / 8 % 8];
        for (bit, joint) in [3, 5, 1].into_iter().enumerate() {
            if i >> bit & 1 == 1 {
                q[joint] = almost;
            }
        }
        if q[5] == 0.0 && i >= 2_000 {
            q[4] = 0.0;
        }
        let solutions = check_configuration(&robot, &solver, &q, &format!("seed 15, configuration {i}, {q:?}"));
        let aligned = q[1].abs() < 1e-5 || q[5].abs() < 1e-5;
        let own = solutions.iter().any(|s| turn_difference(s, &q) < 1e-4);
        assert!(own || aligned, "seed 15, configuration {i}: {q:?} not among {solutions:?}");
    }
    for q in [[0.0; 7], [0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0], [0.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0]] {
        assert!(!check_configuration(&robot, &solver, &q, "upright").is_empty());
    }
}

#[test]
fn an_aligned_wrist_shares_its_turn_between_the_outer_joints() {
    let robot = arm("srs", srs_axes());
    let solver = SrsArm::recognise(&robot).unwrap();
    let q = [0.1, 0.5, 0.2, 0.9, 0.3, 0.0, 0.5];
    let solutions = check_configuration(&robot, &solver, &q, "aligned wrist");
    let shared = [0.1, 0.5, 0.2, 0.9, 0.4, 0.0, 0.4];
    assert!(solutions.iter().any(|s| turn_difference(s, &shared) < 1e-9), "{solutions:?}");
}

#[test]
fn limits_themselves_are_within_limits() {
    let robot = arm("srs", srs_axes());
    let solver = SrsArm::recognise(&robot).unwrap();
    let mut random = Random(16);
    for corner in 0..128 {
        let mut q: Vec<f64> = random.configuration(&robot);
        for (joint, value) in q.iter_mut().enumerate() {
            let coordinate = &robot.coordinates[joint];
            match (corner + joint) % 3 {
                0 => *value = coordinate.upper,
                1 => *value = coordinate.lower,
                _ => {}
            }
        }
        check_round_trip(&robot, &solver, &q, &format!("seed 16, corner {corner}"));
    }
}

#[test]
fn a_wrist_on_the_shoulders_axis_or_in_the_shoulder_gives_numbers_or_nothing() {
    let (axes, tool, mut limits) = srs_axes();
    limits[3] = [-PI, PI];
    limits[1] = [-PI, PI];
    limits[5] = [-PI, PI];
    let robot = arm("folding", (axes, tool, limits));
    let solver = SrsArm::recognise(&robot).unwrap();
    let mut random = Random(17);
    let mut found = 0;
    for height in [-0.8, -0.5, -1e-3, -1e-7, -1e-12, 0.0, 1e-300, 1e-12, 1e-7, 1e-3, 0.5, 0.8] {
        for aside in [0.0, 1e-300, 1e-16, 1e-13, 1e-9, 1e-6] {
            for _ in 0..20 {
                let turn = random.rotation();
                let wrist = Vector3::new(aside, 0.0, 0.34 + height);
                let target = Isometry3::from_parts((wrist + turn * (Vector3::z() * 0.126)).into(), turn);
                for solution in solver.solve(&target, random.between(-PI, PI)) {
                    found += 1;
                    assert!(pose_error(&hand(&robot, &solution), &target) < TOLERANCE, "{height} {aside}");
                }
            }
        }
    }
    assert!(found > 1_000, "only {found} solutions");
    let folded = [0.3, 0.2, 0.1, PI, 0.4, 0.5, 0.6];
    assert!(solver.swivel_of(&folded).is_finite());
    assert!(solver.nearest(&hand(&robot, &folded), &folded).is_none_or(|s| s.iter().all(|x| x.is_finite())));
}

#[test]
fn arms_of_other_kinds_are_refused() {
    let robot = arm("offset wrist", offset_wrist_axes());
    assert!(SrsArm::recognise(&robot).is_none());
    assert!(SrsArm::recognise(&arm("six joints", six_axes())).is_none());
    assert!(SrsArm::recognise(&bare("no arm")).is_none());
    let changed = |change: fn(&mut Vec<Axis>)| {
        let (mut axes, tool, mut limits) = srs_axes();
        change(&mut axes);
        limits.resize(axes.len(), [-1.0, 1.0]);
        SrsArm::recognise(&arm("changed", (axes, tool, limits))).is_some()
    };
    assert!(changed(|_| {}));
    assert!(!changed(|axes| axes[1].point.x += 0.01), "shoulder axes that do not meet");
    assert!(!changed(|axes| axes[5].point.x += 0.01), "wrist axes that do not meet");
    assert!(!changed(|axes| axes[1] = axes[0]), "parallel shoulder axes");
    assert!(!changed(|axes| axes[3].point.z = 0.34), "elbow in the shoulder");
    assert!(!changed(|axes| axes[2] = sliding([0.0, 0.0, 1.0])), "a sliding joint");
    assert!(!changed(|axes| axes.push(axes[1])), "eight joints");
}

#[test]
fn straight_hand_paths_are_followed_with_constant_swivel() {
    const STEPS: u32 = 60;
    let robot = arm("srs", srs_axes());
    let solver = ArmSolver::for_robot(&robot);
    let ArmSolver::Srs(closed) = &solver else { panic!("not recognised") };
    let mut random = Random(18);
    let (mut possible, mut followed) = (0, 0);
    for i in 0..1_000 {
        let mut q = random.configuration(&robot);
        let (start, swivel) = (hand(&robot, &q), closed.swivel_of(&q));
        let way = random.direction() * 0.12;
        let at = |part: f64| Isometry3::from_parts(Translation3::from(way * part) * start.translation, start.rotation);
        possible += u32::from(!closed.solve(&at(1.0), swivel).is_empty());
        let mut arrived = true;
        for step in 1..=STEPS {
            let target = at(f64::from(step) / f64::from(STEPS));
            let Some(next) = solver.follow(&robot, &[], &target, &q, 0.1) else {
                arrived = false;
                break;
            };
            let note = format!("seed 18, path {i}, step {step}");
            assert!(pose_error(&hand(&robot, &next), &target) < TOLERANCE, "{note}");
            assert!(within_limits(&robot, &next), "{note}");
            assert!(next.iter().zip(&q).all(|(a, b)| (a - b).abs() <= 0.1), "{note}");
            assert!(turn_difference(&[closed.swivel_of(&next)], &[swivel]) < 1e-8, "{note}");
            q = next;
        }
        followed += u32::from(arrived);
    }
    println!("{followed} of {possible} possible paths followed");
    assert!(followed * 10 >= possible * 8, "only {followed} of {possible} possible paths followed");
}

#[test]
fn a_path_through_straight_elbow_and_aligned_joints_is_followed_without_a_jump() {
    let robot = arm("srs", srs_axes());
    let solver = ArmSolver::for_robot(&robot);
    // Straight up and down the pole: shoulder, elbow and wrist are all aligned at the top.
    let mut q = vec![0.0, 0.4, 0.0, 0.8, 0.0, 0.4, 0.0];
    let start = hand(&robot, &q);
    for step in 1..=100 {
        let target = Translation3::new(0.0, 0.0, 5e-4 * f64::from(step)) * start;
        q = solver.follow(&robot, &[], &target, &q, 0.05).unwrap();
        assert!(pose_error(&hand(&robot, &q), &target) < TOLERANCE);
        assert!([0, 2, 4, 6].iter().all(|i: &usize| q[*i].abs() < 1e-7), "{q:?}");
    }
}

#[test]
fn a_continuation_keeps_its_turn_and_refuses_a_longer_step_than_allowed() {
    let (axes, tool, mut limits) = srs_axes();
    limits[6] = [-3.0 * PI, 3.0 * PI];
    let robot = arm("wide", (axes, tool, limits));
    let solver = ArmSolver::for_robot(&robot);
    let q = vec![0.3, 0.6, -0.4, 1.0, 0.2, 0.7, 7.5];
    let same = solver.follow(&robot, &[], &hand(&robot, &q), &q, 1e-6).unwrap();
    assert!(same.iter().zip(&q).all(|(a, b)| (a - b).abs() < 1e-9));
    let target = Translation3::new(0.0, 0.0, 0.02) * hand(&robot, &q);
    assert!(solver.follow(&robot, &[], &target, &q, 1e-3).is_none());
    assert!(solver.follow(&robot, &[], &target, &q, 0.3).is_some());
    let beyond = Translation3::new(0.0, 0.0, 9.0) * hand(&robot, &q);
    assert!(solver.follow(&robot, &[], &beyond, &q, 10.0).is_none());
}
