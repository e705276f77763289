//! The samples of a hop are the poses that candidates choose from.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod common;

use std::collections::{BTreeMap, BTreeSet};

use common::check::overlap;
use common::{Scene, WIDE, ask, candidates, job, shipped, stage};
use contract::{Answer, Interrupted, Job, Outcome, Request, SamplesJob, encode};
use model::{ObjectId, PairId, Pose, Problem};
use placement::PlacementStage;
use plan::Cause;

fn samples_job(pair: usize, level: u32) -> Job {
    Job { request: Request::Samples(SamplesJob { pair: PairId::at(pair), level }), budget: 4_000_000 }
}

fn samples(stage: &PlacementStage, pair: usize, level: u32) -> BTreeMap<u32, Pose> {
    match ask(stage, &samples_job(pair, level)).unwrap().result {
        Ok(Answer::Samples(samples)) => {
            assert!(samples.windows(2).all(|two| two[0].0 < two[1].0), "in ascending order, each once");
            samples.into_iter().collect()
        }
        other => panic!("no samples but {other:?}"),
    }
}

/// A table with an object that nobody moves, and one that is brought there.
fn beside_a_rock() -> Problem {
    let scene = Scene::new(1).table("a", WIDE).table("b", [0.3, 0.3]).carton("m", "a", [0.0, 0.0]);
    let mut problem = scene.carton("rock", "b", [0.02, 0.03]).moves(1, "m", "a", "b").0;
    problem.levels.placements = 32;
    problem
}

#[test]
fn the_samples_of_the_only_hop_are_those_of_all_candidates_and_touch_nothing_that_stays() {
    let problem = beside_a_rock();
    let mut left_out = 0;
    for seed in 0..10 {
        let stage = stage(&problem, seed);
        let samples = samples(&stage, 0, 0);
        let all = candidates(&stage, &job(0, 0, 1000, vec![]));
        let used: BTreeMap<u32, Pose> =
            all.iter().map(|c| (c.placements[0].sample, c.placements[0].world_from_object)).collect();
        assert_eq!(used, samples, "seed {seed}");
        let rock = problem.movable[1].world_from_start;
        for (number, pose) in &samples {
            assert!(!overlap(&problem, (ObjectId(0), pose), (ObjectId(1), &rock)), "seed {seed}, sample {number}");
        }
        left_out += 32 - samples.len();
    }
    assert!(left_out > 20, "{left_out} samples touch the rock: the test sees too few");
}

#[test]
fn what_candidates_of_several_hops_use_is_among_the_samples_of_each_hop() {
    for name in ["t05_tiny_region", "figure1_tight"] {
        let mut problem = shipped(name);
        problem.levels.placements = 6;
        let stage = stage(&problem, 2);
        let of_pair: Vec<BTreeMap<u32, Pose>> = (0..problem.pairs.len()).map(|pair| samples(&stage, pair, 0)).collect();
        let mut used = BTreeSet::new();
        for candidate in candidates(&stage, &job(0, 0, 300, vec![])) {
            for placed in &candidate.placements {
                assert_eq!(of_pair[placed.pair.index()].get(&placed.sample), Some(&placed.world_from_object), "{name}");
                used.insert((placed.pair, placed.sample));
            }
        }
        assert!(used.len() > problem.pairs.len(), "{name}: {used:?}");
    }
}

#[test]
fn the_samples_of_a_level_are_the_first_ones_of_the_next() {
    for problem in [beside_a_rock(), shipped("figure1_tight")] {
        let (stage, first) = (stage(&problem, 5), problem.levels.placements);
        for pair in 0..problem.pairs.len() {
            let levels: Vec<BTreeMap<u32, Pose>> = (0..3).map(|level| samples(&stage, pair, level)).collect();
            for (level, two) in (0..).zip(levels.windows(2)) {
                let of_before: BTreeMap<u32, Pose> =
                    two[1].iter().filter(|(number, _)| **number < first << level).map(|(n, p)| (*n, *p)).collect();
                assert_eq!(of_before, two[0], "pair {pair}, level {level}");
                assert!(two[1].len() > two[0].len(), "pair {pair}, level {level}");
            }
        }
    }
}

#[test]
fn a_pair_or_a_level_that_cannot_be_is_unfit() {
    let stage = stage(&beside_a_rock(), 0);
    for job in [samples_job(1, 0), samples_job(usize::from(u16::MAX), 0), samples_job(0, 14), samples_job(0, u32::MAX)]
    {
        let answer = ask(&stage, &job);
        assert!(matches!(answer, Err(Interrupted::Unfit(_))), "{answer:?}");
    }
    assert!(!samples(&stage, 0, 0).is_empty(), "the stage answers on");
}

#[test]
fn samples_cost_and_are_the_same_whatever_was_asked_before_and_whatever_the_budget() {
    let problem = beside_a_rock();
    let warm = stage(&problem, 1);
    let same = |job: &Job| -> Outcome {
        let (warm, cold) = (ask(&warm, job).unwrap(), ask(&stage(&problem, 1), job).unwrap());
        assert_eq!(encode(&warm).unwrap(), encode(&cold).unwrap(), "budget {}", job.budget);
        cold
    };
    let whole = same(&samples_job(0, 0)).work;
    candidates(&warm, &job(0, 0, 5, vec![]));
    let mut cut = 0;
    for budget in 0..whole + 3 {
        let outcome = same(&Job { budget, ..samples_job(0, 0) });
        if let Err(report) = outcome.result {
            assert!(report.causes.contains(&(Cause::Budget { stage: "placement".into() }, 1)), "{report:?}");
            cut += 1;
        }
    }
    assert!(cut > 10, "{cut} of {whole} cut short");
}
