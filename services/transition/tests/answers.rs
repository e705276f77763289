//! What failures rest on, and that answers and work do not depend on what was asked before.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod common;

use common::{Random, ask, between, first_hops, job, middle_of_target, scene, statement};
use contract::{Choice, Job, Outcome, ProblemStatement, Request};
use model::{ObjectId, PairId, Pose, Problem};
use nalgebra::Translation3;
use skeleton::Occupancy;
use transition::TransitionStage;

/// Where the object of the first pair may be: mostly within reach at both ends, or not.
fn random_ends(problem: &Problem, random: &mut Random, by: f64) -> [Pose; 2] {
    let pair = PairId(0);
    let from = problem.movable[problem.pair(pair).object.index()].world_from_start;
    [from, middle_of_target(problem, pair)].map(|pose| random.beside(&pose, by))
}

fn pose(hop: u32) -> Choice {
    Choice::Pose(Occupancy { object: ObjectId(0), hop })
}

fn rests_on(outcome: &Outcome) -> Option<Vec<Choice>> {
    outcome.result.as_ref().err().map(|report| report.rests_on.clone().unwrap_or_else(|| panic!("{report:?}")))
}

#[test]
fn a_failure_that_rests_on_one_end_stays_whatever_the_other_end_and_one_on_both_does_not() {
    let problem = scene("t00_one_arm");
    let statement = statement(problem.clone());
    let stage = TransitionStage::new(&statement).unwrap();
    let fails = |ends: [Pose; 2]| rests_on(&ask(&stage, &statement, &between(PairId(0), ends, 1)));
    let mut random = Random(1);
    let others: Vec<[Pose; 2]> = (0..25).map(|_| random_ends(&problem, &mut random, 0.5)).collect();
    let (mut by_pick, mut by_place, mut none) = (0, 0, 0);
    for seed in 2..80 {
        let [from, to] = random_ends(&problem, &mut Random(seed), 0.7);
        match fails([from, to]) {
            None => none += 1,
            Some(choices) if choices == [pose(0)] => {
                assert!(others.iter().all(|other| fails([from, other[1]]).is_some()), "seed {seed}");
                by_pick += 1;
            }
            Some(choices) if choices == [pose(1)] => {
                assert!(others.iter().all(|other| fails([other[0], to]).is_some()), "seed {seed}");
                assert!(others.iter().any(|other| fails([from, other[1]]).is_none()), "seed {seed}: the pick, too");
                by_place += 1;
            }
            Some(choices) => {
                assert_eq!(choices, [pose(0), pose(1)], "seed {seed}");
                assert!(others.iter().any(|other| fails([from, other[1]]).is_none()), "seed {seed}: the pick alone");
                assert!(others.iter().any(|other| fails([other[0], to]).is_none()), "seed {seed}: the place alone");
            }
        }
    }
    assert!(by_pick > 5 && by_place > 5 && none > 5, "{by_pick} {by_place} {none}");
}

#[test]
fn where_only_the_grasps_do_not_match_a_failure_rests_on_both_ends() {
    let mut problem = scene("t15_no_common_grasp");
    // Somewhere in a region this large it might be put down: nothing is proven.
    let target = problem.pairs[0].to;
    problem.regions[target.index()].size = [3.0, 3.0];
    let statement = statement(problem.clone());
    let stage = TransitionStage::new(&statement).unwrap();
    let [from, to] = random_ends(&problem, &mut Random(0), 0.0);
    assert_eq!(rests_on(&ask(&stage, &statement, &between(PairId(0), [from, to], 1))), Some(vec![pose(0), pose(1)]));
    // At either end alone there are grasps: the object can be put back where it was.
    for (end, region) in [(from, problem.pairs[0].from), (to, target)] {
        let mut back = problem.clone();
        (back.pairs[0].from, back.pairs[0].to) = (region, region);
        let statement = common::statement(back);
        let stage = TransitionStage::new(&statement).unwrap();
        assert_eq!(rests_on(&ask(&stage, &statement, &between(PairId(0), [end, end], 1))), None);
    }
    // A place that no grasp reaches is at fault alone.
    let far = Translation3::new(9.0, 9.0, 0.0) * to;
    assert_eq!(rests_on(&ask(&stage, &statement, &between(PairId(0), [from, far], 1))), Some(vec![pose(1)]));
    assert_eq!(rests_on(&ask(&stage, &statement, &between(PairId(0), [far, to], 1))), Some(vec![pose(0)]));
}

/// Jobs that share ends and grasps in many ways, with budgets of all sizes.
fn jobs(problem: &Problem, seed: u64) -> Vec<Job> {
    let mut random = Random(seed);
    let mut jobs = Vec::new();
    for pair in first_hops(problem) {
        let Request::Transition(whole) = job(problem, pair, 5).request else { continue };
        let ends = [0.0, 0.02, 0.6]
            .map(|by| [whole.world_from_pick, whole.world_from_place].map(|pose| random.beside(&pose, by)));
        for i in 0..3 {
            for budget in [0, 1, 7, 40, 150, 400, 1000, 1_000_000] {
                let j = (random.unit() * 3.0) as usize;
                let Job { request, .. } = between(pair, [ends[i][0], ends[j][1]], 5);
                jobs.push((random.unit(), Job { request, budget }));
            }
        }
    }
    jobs.sort_by(|a, b| a.0.total_cmp(&b.0));
    jobs.into_iter().map(|(_, job)| job).collect()
}

#[test]
fn answers_and_work_do_not_depend_on_what_was_asked_before_whatever_the_budget() {
    for (name, seeds) in [("t00_one_arm", 3), ("t13_occluded", 1)] {
        let problem = scene(name);
        let statement: ProblemStatement = statement(problem.clone());
        for seed in 0..seeds {
            let experienced = TransitionStage::new(&statement).unwrap();
            let (mut cut, mut whole) = (0, 0);
            for (number, job) in jobs(&problem, seed).iter().enumerate() {
                let fresh = TransitionStage::new(&statement).unwrap();
                let outcome = ask(&fresh, &statement, job);
                let other = ask(&experienced, &statement, job);
                assert!(
                    other == outcome,
                    "{name}, seed {seed}, job {number}: work {} of {}, alone {}",
                    other.work,
                    job.budget,
                    outcome.work
                );
                *if outcome.work >= job.budget { &mut cut } else { &mut whole } += 1;
            }
            assert!(cut > 2 && whole > 2, "{name}, seed {seed}: {cut} cut short, {whole} not");
        }
    }
}
