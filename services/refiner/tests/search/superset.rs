//! What the transition stage tells placement saves candidates and loses no answer: it holds for every candidate with the
//! same poses. On enumerated worlds with a static order of candidates, a search without causes tries all that a search
//! with causes tries, and both end alike. Causes of later stages are softer, since not every way to do a pair is tried
//! with every other: they are told to nobody here.

use std::collections::BTreeSet;

use contract::{
    Answer, Literal, Outcome, Placed, PlacementCandidate, PlacementJob, ProblemStatement, Request, Soundness,
};
use model::{FailurePolicy, PairId, Policies};
use plan::{BodyRef, Cause};
use refiner::End;
use std::cell::RefCell;
use std::rc::Rc;

use crate::scripted::{Rule, Scripted, fails, no_path, statement};

/// Samples of each hop.
const SAMPLES: u32 = 3;

type Samples = Vec<u32>;

/// All candidates, in a static order.
fn world(pairs: usize) -> Vec<Samples> {
    let all = SAMPLES.pow(pairs as u32);
    (0..all).map(|index| (0..pairs as u32).map(|pair| index / SAMPLES.pow(pair) % SAMPLES).collect()).collect()
}

/// Candidates that no nogood excludes, as the placement stage gives them out.
fn place(statement: &ProblemStatement, job: &PlacementJob, tried: &RefCell<Vec<Samples>>) -> Outcome {
    let problem = &statement.problem;
    let holds = |samples: &Samples, literal: &Literal| match literal {
        Literal::Pose { occupancy, sample } => (0..problem.pairs.len()).any(|pair| {
            let moved = &problem.pairs[pair];
            (moved.object, moved.hop, samples[pair]) == (occupancy.object, occupancy.hop, *sample)
        }),
        Literal::Alternative { .. } | Literal::Order { .. } => false,
    };
    let excluded = |samples: &Samples| job.nogoods.iter().any(|nogood| nogood.iter().all(|l| holds(samples, l)));
    let mut left = world(problem.pairs.len()).into_iter().filter(|samples| !excluded(samples));
    let Some(samples) = left.nth(job.first as usize) else {
        let cause = Cause::NoPlacement { object: "o".into(), region: "w".into() };
        return fails(cause, Soundness::Soft { level: 0 });
    };
    tried.borrow_mut().push(samples.clone());
    let placed = |(pair, sample): (usize, &u32)| {
        let mut pose = problem.movable[0].world_from_start;
        pose.translation.x = f64::from(*sample) + 10.0 * pair as f64;
        Placed { pair: PairId::at(pair), sample: *sample, world_from_object: pose }
    };
    let placements = samples.iter().enumerate().map(placed).collect();
    let candidate = PlacementCandidate { index: job.first, placements, orders: Vec::new() };
    Outcome::answer(Answer::Placements(vec![candidate]), 1)
}

/// Whether something that depends on these bytes fails.
fn is_bad(seed: u64, percent: u8, bytes: &[u8]) -> bool {
    let digest = contract::Digest::of("test of causes", &[&seed.to_le_bytes(), bytes]);
    u16::from(digest.0[0]) * 100 < u16::from(percent) * 256
}

fn rules(statement: &ProblemStatement, seed: u64, percent: u8, tried: &Rc<RefCell<Vec<Samples>>>) -> Vec<Rule> {
    let (known, tried) = (statement.clone(), tried.clone());
    let names: Vec<String> = statement.problem.movable.iter().map(|object| object.name.clone()).collect();
    let placement: Rule = Box::new(move |request| match request {
        Request::Placement(job) => Some(place(&known, job, &tried)),
        _ => None,
    });
    let transition: Rule = Box::new(move |request| match request {
        Request::Transition(job) => {
            let bytes = contract::encode_canonical(&(job.pair, job.world_from_pick, job.world_from_place));
            is_bad(seed, percent, &bytes).then(|| fails(no_path("x"), Soundness::Soft { level: 0 }))
        }
        _ => None,
    });
    // A certain pose is in the way of a grasp of a mode.
    let roadmap: Rule = Box::new(move |request| {
        let Request::Mode(job) = request else { return None };
        let blocks = |obstruction: &&contract::Obstruction| {
            let bytes = contract::encode_canonical(&(job.mode, &job.holding, &obstruction.standing));
            is_bad(seed, percent, &bytes)
        };
        let blocking = job.certain.iter().filter(blocks).map(|o| names[o.occupancy.object.index()].clone());
        let blocking: Vec<BodyRef> = blocking.map(BodyRef::Object).collect();
        let cause = Cause::NoPath { pair: None, robot: "r".into(), blocking: blocking.clone() };
        (!blocking.is_empty()).then(|| fails(cause, Soundness::Soft { level: 0 }))
    });
    vec![placement, transition, roadmap]
}

/// The candidates tried, in order, and whether the last one was completed.
fn search(seed: u64, percent: u8, scene: &str, causes: bool) -> (Vec<Samples>, bool) {
    let mut statement = statement(scene);
    statement.problem.levels.highest = 0;
    statement.options.candidates = u32::MAX;
    let [transition, blind] = [causes, false].map(|causes| Some(FailurePolicy::Backtrack { causes }));
    statement.options.policies = Policies { placement: None, transition, roadmap: blind, composite: blind };
    let tried = Rc::default();
    let run = Scripted::new(&statement, rules(&statement, seed, percent, &tried)).run();
    let tried = tried.borrow().clone();
    (tried, matches!(run.end, End::Solved { .. }))
}

#[test]
fn a_search_without_causes_tries_all_that_one_with_causes_tries_and_ends_alike() {
    let (mut with, mut without, mut solved) = (0, 0, 0);
    for seed in 0..150 {
        let percent = [15, 30, 45, 60][seed as usize % 4];
        for scene in ["t03_relay", "t10_swap_with_buffer", "t05_tiny_region"] {
            let (informed, informed_end) = search(seed, percent, scene, true);
            let (blind, blind_end) = search(seed, percent, scene, false);
            assert_eq!(informed_end, blind_end, "{scene}, seed {seed}");
            if informed_end {
                assert_eq!(informed.last(), blind.last(), "{scene}, seed {seed}: another answer");
            }
            let all: BTreeSet<&Samples> = blind.iter().collect();
            assert!(informed.iter().all(|samples| all.contains(samples)), "{scene}, seed {seed}");
            (with, without, solved) = (with + informed.len(), without + blind.len(), solved + u32::from(informed_end));
        }
    }
    println!("{with} candidates with causes, {without} without, {solved} of 450 solved");
    assert!(without > 2 * with && (50..400).contains(&solved), "{with} {without} {solved}");
}
