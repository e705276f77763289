//! Numeric inverse kinematics of both arms.

use std::time::Instant;

use kinematics::{ArmSolver, link_pose};
use model::{Pose, Robot};

use crate::dh::{between, difference, panda_flange, ur5_flange};
use crate::{configurations, panda, ur5};

const POSES: u64 = 2_000;
/// One value of the redundancy parameter stands for four starts of the descent: twenty starts in all.
const VALUES: u64 = 5;

/// Solves random reachable poses; checks each solution by `flange`, the maker's table, at the end effector's parent link.
fn share_solved(robot: &Robot, seed: u64, flange: impl Fn(&[f64]) -> Pose) -> f64 {
    let solver = ArmSolver::for_robot(robot);
    assert!(matches!(solver, ArmSolver::Numeric(_)), "{} has no closed form here", robot.name);
    let link = robot.end_effector.parent_link;
    let targets: Vec<Vec<f64>> = configurations(robot, seed, POSES);
    let (mut solved, mut at_once, started) = (0, 0, Instant::now());
    for (i, q) in targets.iter().enumerate() {
        let target = link_pose(robot, q, link);
        let mut values = (0..VALUES).map(|k| solver.solve(robot, &[], &target, contract::halton(k, 2)));
        let first = values.next().unwrap();
        at_once += u64::from(!first.is_empty());
        let solutions = if first.is_empty() { values.find(|found| !found.is_empty()) } else { Some(first) };
        solved += u64::from(solutions.is_some());
        for solution in solutions.into_iter().flatten() {
            let error = difference(&flange(&solution), &flange(q));
            assert!(error < 2e-6, "seed {seed}, pose {i}: misses by {error}");
            let within = solution.iter().zip(&robot.coordinates).all(|(x, c)| (c.lower..=c.upper).contains(x));
            assert!(within, "seed {seed}, pose {i}: {solution:?} is outside the limits");
        }
    }
    let us = started.elapsed().as_secs_f64() * 1e6 / POSES as f64;
    let share = solved as f64 / POSES as f64;
    println!(
        "{}: {:.2} % of {POSES} poses within {} starts, {:.2} % within 4, {us:.0} us a pose",
        robot.name,
        100.0 * share,
        4 * VALUES,
        100.0 * at_once as f64 / POSES as f64
    );
    share
}

#[test]
fn nearly_all_reachable_poses_of_the_panda_are_solved_within_twenty_starts() {
    let robot = panda();
    assert!(share_solved(&robot, 11, panda_flange) >= 0.98);
}

#[test]
fn nearly_all_reachable_poses_of_the_ur5_are_solved_within_twenty_starts() {
    let robot = ur5();
    assert!(share_solved(&robot, 12, ur5_flange) >= 0.98);
}

#[test]
fn the_way_from_wrist_to_flange_is_rigid() {
    // Lets the tests above compare flanges although the solver is asked for the parent link.
    let (panda, ur5) = (panda(), ur5());
    for (robot, parent, flange) in [(&panda, "panda_link8", "panda_link8"), (&ur5, "wrist_3_link", "tool0")] {
        let [a, b] = [3, 4].map(|seed| between(robot, &configurations(robot, seed, 1)[0], parent, flange));
        assert!(difference(&a, &b) < 1e-9);
        assert_eq!(robot.links[robot.end_effector.parent_link.index()].name, parent);
    }
}
