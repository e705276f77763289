//! The shipped robots and scenes; and a plan of the size of the paper's Figure 1: three mobile manipulators, about a
//! thousand knots each, several minutes.

use std::path::PathBuf;

use model::{DiskFiles, Problem, load_problem};
use plan::{Plan, SegmentKind};
use validation::{Rule, Verdict};

use crate::fixture::{Writer, accepted, finish, rules};
use crate::numbers::Random;

fn scenes() -> Vec<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../launch/scenes"));
    let entries = std::fs::read_dir(folder).expect("scenes are shipped");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "yaml"));
    // Its robots are not part of this project; `tests/real_robots` has it.
    paths.retain(|path| !path.ends_with("two_real_arms.yaml"));
    paths.sort();
    paths
}

/// A shipped scene with nothing to do.
fn idle(path: &std::path::Path) -> Problem {
    let mut problem = load_problem(&DiskFiles, path.to_str().expect("plain text")).expect("a valid problem");
    problem.pairs.clear();
    problem.orderings.clear();
    problem
}

#[test]
fn in_every_shipped_scene_standing_still_is_a_valid_plan() {
    let paths = scenes();
    assert!(paths.len() >= 5, "{paths:?}");
    for path in paths {
        let problem = idle(&path);
        let writers = (0..problem.robots.len()).map(|robot| Writer::new(&problem, robot)).collect();
        accepted(&problem, &finish(&problem, writers));
    }
}

/// Whether one robot's straight motion is free, by the checker itself.
fn is_free(problem: &Problem, robot: usize, from: &[f64], to: &[f64]) -> bool {
    let mut alone = problem.clone();
    alone.robots = vec![problem.robots[robot].clone()];
    alone.robots[0].start = from.to_vec();
    let mut writer = Writer::new(&alone, 0);
    writer.go(SegmentKind::Reach, to);
    let plan = finish(&alone, vec![writer]);
    !rules(&alone, &plan).contains(&Rule::V11)
}

/// Wanders about its start, base and arm in turn, along motions that are free of what stands; comes back by the same way.
fn wander<'a>(problem: &'a Problem, robot: usize, knots: usize, random: &mut Random) -> Writer<'a> {
    let (start, coordinates) = (&problem.robots[robot].start, &problem.robots[robot].coordinates);
    let mut way = vec![start.clone()];
    while way.len() < knots / 2 {
        let from = &way[way.len() - 1];
        let mut to = from.clone();
        if way.len() % 8 < 2 {
            (0..3).for_each(|i| to[i] = start[i] + random.between(-0.6, 0.6));
        } else {
            (3..to.len()).for_each(|i| to[i] = from[i] + random.between(-0.3, 0.3));
        }
        to.iter_mut().zip(coordinates).for_each(|(q, limits)| *q = q.clamp(limits.lower, limits.upper));
        if is_free(problem, robot, from, &to) {
            way.push(to);
        }
    }
    let mut writer = Writer::new(problem, robot);
    for q in way.iter().chain(way.iter().rev()).skip(1) {
        writer.go(SegmentKind::Reach, q);
    }
    writer
}

fn wandering(knots: usize) -> (Problem, Plan) {
    let figure = scenes().into_iter().find(|path| path.ends_with("figure1.yaml")).expect("it is shipped");
    let mut problem = idle(&figure);
    // In the figure two robots share a room: apart, so that they may wander without looking at one another.
    problem.robots[2].world_from_base.translation.x += 1.0;
    problem.robots[1].world_from_base.translation.x -= 0.5;
    let robots = 0..problem.robots.len();
    let writers = robots.map(|robot| wander(&problem, robot, knots, &mut Random(robot as u64))).collect();
    let plan = finish(&problem, writers);
    (problem, plan)
}

#[test]
fn a_plan_of_the_size_of_figure_one_is_checked_with_little_work() {
    let (problem, plan) = wandering(1000);
    assert!(plan.makespan.total_s > 120.0, "{}", plan.makespan.total_s);
    let verdict: Verdict = accepted(&problem, &plan);
    println!("{:.1} s of motion: {verdict:?}", plan.makespan.total_s);
    // About 0.1 µs per pair and 1 µs per distance on the machines it was written on.
    assert!(verdict.distances < 500_000 && verdict.pairs_tested < 5_000_000, "{verdict:?}");
    let least = verdict.least_clearance;
    assert!(least.robot_fixed.is_some_and(|d| d < 0.05) && least.own.is_some_and(|d| d < 0.05), "{least:?}");
}
