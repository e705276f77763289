//! Products far too large to search through.

use super::super::composite_roadmap::{CompositeRoadmap, RobotRoadmap};
use super::stepper::replay;
use super::toy::{Dice, Places, Toy};

/// A grid of places with some missing, robots with pairs at random places; neighbours of starts are kept free.
fn warehouse(seed: u64, side: usize, robots: usize, pairs_each: usize) -> Places {
    let mut dice = Dice::new(seed);
    let mut cells: Vec<usize> = (0..side * side).collect();
    (0..cells.len()).for_each(|i| cells.swap(i, dice.below(side * side)));
    let starts = cells[..robots].to_vec();
    let stands = cells[robots..2 * robots + 4].to_vec();
    let (missing, _) = cells[2 * robots + 4..].split_at(side * side / 8);
    let mut edges = Vec::new();
    for a in 0..side * side {
        let right = (a % side + 1 < side).then_some(a + 1);
        for b in right.into_iter().chain((a + side < side * side).then_some(a + side)) {
            if !missing.contains(&a) && !missing.contains(&b) {
                edges.push((a, b, 1.0));
            }
        }
    }
    let mut at: Vec<usize> = stands.clone();
    let mut tasks = Vec::new();
    for _ in 0..pairs_each {
        for robot in 0..robots {
            let object = dice.below(at.len());
            let to = stands[dice.below(stands.len())];
            tasks.push((robot, object, at[object], to));
            at[object] = to;
        }
    }
    Places { edges, starts, tasks, objects: stands.len(), orders: Vec::new(), blocks: Vec::new(), grip_time: 0.5 }
}

/// Whether all places that are used hang together.
fn is_connected(scene: &Places) -> bool {
    let mut reached = vec![scene.starts[0]];
    for i in 0.. {
        let Some(here) = reached.get(i).copied() else { break };
        for (a, b, _) in &scene.edges {
            for (from, to) in [(*a, *b), (*b, *a)] {
                if from == here && !reached.contains(&to) {
                    reached.push(to);
                }
            }
        }
    }
    let stops = scene.tasks.iter().flat_map(|task| [task.2, task.3]);
    stops.chain(scene.starts.iter().copied()).all(|place| reached.contains(&place))
}

/// Least time of the critical path, other robots' gates counted, conflicts not (s).
fn least(toy: &Toy) -> f64 {
    let roadmap = CompositeRoadmap::new(&toy.statement.problem, &toy.skeleton, &toy.roadmaps).unwrap();
    let first = |robot: &RobotRoadmap<'_>| {
        robot.phases[0].cost_to_go_s[robot.modes[0].roadmap.start.index()] + robot.phases[0].remaining_s
    };
    roadmap.robots.iter().map(first).fold(0.0, f64::max)
}

fn successes(side: usize, robots: usize, pairs_each: usize, seeds: u64, budget: u64) -> (usize, usize) {
    let (mut tried, mut solved, mut spent) = (0, 0, 0);
    let mut ratios = 0.0;
    for seed in 0..seeds {
        let scene = warehouse(seed, side, robots, pairs_each);
        if !is_connected(&scene) {
            continue;
        }
        tried += 1;
        let toy = scene.toy(seed);
        let (outcome, units) = toy.solve_after(&[], budget);
        spent += units;
        if let Ok(commitments) = outcome.unwrap() {
            let end = replay(&toy, &commitments).unwrap_or_else(|wrong| panic!("seed {seed}: {wrong}"));
            ratios += end / least(&toy);
            solved += 1;
        } else {
            println!("seed {seed} of {side}, {robots}: not solved");
        }
    }
    let mean = ratios / f64::from(solved.max(1) as u32);
    println!("{robots} robots, {pairs_each} pairs each, {side} x {side}: {solved} of {tried}, {spent} work units");
    println!("  composite time over critical path {mean:.2}");
    (solved, tried)
}

#[test]
fn warehouses_with_three_and_four_robots_are_solved() {
    for (side, robots, pairs) in [(5, 3, 3), (6, 4, 3), (8, 6, 2)] {
        let (solved, tried) = successes(side, robots, pairs, 25, 20_000);
        assert!(tried >= 10 && solved == tried, "{robots} robots: {solved} of {tried}");
    }
}
