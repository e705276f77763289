//! Questions to the transition stage of a scene.
#![allow(dead_code, reason = "every test file uses its own part")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "its input is its own")]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use contract::{
    Alternative, Answer, CompositeMethod, Job, JobContext, MemoryProducts, Outcome, ProblemStatement, Request, Stage,
    TransitionJob,
};
use model::{DiskFiles, PairId, Pose, Problem, load_problem};
use nalgebra::Translation3;
use transition::TransitionStage;

pub fn scene(name: &str) -> Problem {
    let path = format!("{}/../../launch/scenes/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    load_problem(&DiskFiles, &path).unwrap()
}

/// The middle of a pair's target region, upright.
pub fn middle_of_target(problem: &Problem, pair: PairId) -> Pose {
    let pair = problem.pair(pair);
    let region = &problem.regions[pair.to.index()];
    let height = problem.movable[pair.object.index()].origin_height();
    region.world_from_region * Translation3::new(0.0, 0.0, height)
}

pub fn job(problem: &Problem, pair: PairId, count: u32) -> Job {
    let world_from_pick = problem.movable[problem.pair(pair).object.index()].world_from_start;
    let world_from_place = middle_of_target(problem, pair);
    between(pair, [world_from_pick, world_from_place], count)
}

pub fn between(pair: PairId, [world_from_pick, world_from_place]: [Pose; 2], count: u32) -> Job {
    let request = TransitionJob { pair, world_from_pick, world_from_place, level: 0, first: 0, count };
    Job { request: Request::Transition(request), budget: 1_000_000 }
}

pub fn ask(stage: &TransitionStage, statement: &ProblemStatement, job: &Job) -> Outcome {
    let products = MemoryProducts::default();
    let mut context = JobContext::new(job.id(statement), job, &products, Arc::new(AtomicBool::new(false)));
    stage.refine(job, &mut context).unwrap()
}

pub fn statement(problem: Problem) -> ProblemStatement {
    ProblemStatement::new(problem, 1, CompositeMethod::Prioritised)
}

pub fn alternatives(outcome: Outcome) -> Vec<Alternative> {
    match outcome.result {
        Ok(Answer::Alternatives(alternatives)) => alternatives,
        other => panic!("{other:?}"),
    }
}

/// First hops: those whose object is where the problem puts it.
pub fn first_hops(problem: &Problem) -> Vec<PairId> {
    (0..problem.pairs.len()).map(PairId::at).filter(|pair| problem.pair(*pair).hop == 1).collect()
}

/// SplitMix64: numbers from 0 to 1.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A pose moved sideways by at most `by` (m) in x and y.
    pub fn beside(&mut self, pose: &Pose, by: f64) -> Pose {
        Translation3::new(self.between(-by, by), self.between(-by, by), 0.0) * pose
    }
}
