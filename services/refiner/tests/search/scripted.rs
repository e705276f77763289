//! Scripted stages that count what they are asked.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use contract::{
    Alternative, Answer, AskFault, AskStages, CompositeMethod, Composition, Decision, Digest, FailureReport, Foresight,
    HopChoice, HopJob, Job, JobId, JobIds, Ledger, LedgerEntry, Outcome, Placed, PlacementCandidate, ProblemStatement,
    ProductRef, Reach, Request, Soundness,
};
use model::{DiskFiles, FixedId, GraspId, PairId, Pose, Problem, load_problem};
use plan::Cause;
use refiner::{Refinement, refine_plan};
use skeleton::ModeId;

/// Two robots hand one object on.
pub fn relay() -> ProblemStatement {
    statement("t03_relay")
}

pub fn statement(scene: &str) -> ProblemStatement {
    let mut problem = loaded(scene);
    problem.levels.highest = 1;
    ProblemStatement::new(problem, 5, CompositeMethod::Prioritised)
}

/// A scene; each is read once, for some tests search in it hundreds of times.
fn loaded(scene: &str) -> Problem {
    static SCENES: Mutex<BTreeMap<String, Problem>> = Mutex::new(BTreeMap::new());
    let path = format!("{}/../../launch/scenes/{scene}.yaml", env!("CARGO_MANIFEST_DIR"));
    let load = || load_problem(&DiskFiles, &path).unwrap();
    SCENES.lock().unwrap().entry(scene.to_owned()).or_insert_with(load).clone()
}

pub type Rule = Box<dyn Fn(&Request) -> Option<Outcome>>;

/// Answers everything with success, unless a rule says otherwise; remembers what it was asked.
pub struct Scripted<'a> {
    pub statement: &'a ProblemStatement,
    ids: JobIds,
    rules: Vec<Rule>,
    pub asked: Vec<Job>,
    /// Asking ends with a time limit after so many jobs.
    pub patience: usize,
    commits: u64,
}

impl<'a> Scripted<'a> {
    pub fn new(statement: &'a ProblemStatement, rules: Vec<Rule>) -> Self {
        let ids = JobIds::new(Arc::new(statement.clone()));
        Self { statement, ids, rules, asked: Vec::new(), patience: usize::MAX, commits: 0 }
    }

    pub fn run(&mut self) -> Refinement {
        refine_plan(self.statement, self, &mut |_| ())
    }

    pub fn count(&self, which: impl Fn(&Request) -> bool) -> usize {
        self.asked.iter().filter(|job| which(&job.request)).count()
    }

    fn answer(&mut self, job: &Job) -> Outcome {
        let made =
            ProductRef { digest: Digest::of("test", &[&contract::encode_canonical(job)]), made_by: self.job_id(job) };
        let problem = &self.statement.problem;
        let answer = match &job.request {
            Request::Placement(job) => {
                Answer::Placements((job.first..job.first + job.count).map(|index| candidate(problem, index)).collect())
            }
            Request::Hop(job) => Answer::Hop { choices: hop_choices(job), against: Vec::new(), causes: Vec::new() },
            Request::Transition(job) => {
                Answer::Alternatives((0..3 << job.level).map(|i| alternative(problem, job.pair, i)).collect())
            }
            Request::Samples(_) => Answer::Samples(Vec::new()),
            Request::GraspBlockers(job) => Answer::Blocked(vec![false; job.standing.len()]),
            Request::Blockers(job) => Answer::Blocked(vec![false; job.standing.len()]),
            Request::Piece(_) => Answer::Piece(made),
            Request::Mode(_) => Answer::Mode { roadmap: made, shortest_s: 1.0, in_the_way: Vec::new() },
            Request::Compose(job) => match &job.composition {
                Composition::Repair { mode, .. } => {
                    self.commits += 1;
                    Answer::Repaired { prefix: made, modes: vec![(*mode, self.commits as f64)] }
                }
                Composition::Passages { .. } => Answer::NoPassage(Vec::new()),
                Composition::Assemble { .. } => Answer::Plan { plan: made, makespan_s: 9.0 },
                Composition::Synchronous { .. } => {
                    Answer::Rounds { prefix: made, rounds: two_rounds().into(), ends_s: 9.0 }
                }
                _ => {
                    self.commits += 1;
                    Answer::Committed { prefix: made, event_s: self.commits as f64, tail_s: 0.0 }
                }
            },
        };
        Outcome::answer(answer, 1)
    }
}

impl AskStages for Scripted<'_> {
    fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault> {
        let mut outcomes = Vec::new();
        for job in jobs {
            if self.asked.len() == self.patience {
                return Err(AskFault::TimeLimit);
            }
            self.asked.push(job.clone());
            let ruled = self.rules.iter().find_map(|rule| rule(&job.request));
            outcomes.push(ruled.unwrap_or_else(|| self.answer(job)));
        }
        Ok(outcomes)
    }

    fn foresee(&mut self, _: Foresight) {}

    fn job_id(&self, job: &Job) -> JobId {
        self.ids.of(job).unwrap()
    }
}

pub fn two_rounds() -> [Vec<ModeId>; 2] {
    [0, 1].map(|step| vec![ModeId { robot: model::RobotId(0), step }])
}

pub fn candidate(problem: &Problem, index: u32) -> PlacementCandidate {
    let placements = (0..problem.pairs.len())
        .map(|i| Placed { pair: PairId::at(i), sample: index, world_from_object: problem.movable[0].world_from_start })
        .collect();
    PlacementCandidate { index, placements, orders: Vec::new() }
}

/// Every hop has four samples, side by side.
fn hop_choices(job: &HopJob) -> Vec<HopChoice> {
    let choice = |sample| {
        let world_from_object = Pose::translation(f64::from(sample), 0.0, 0.0);
        HopChoice { placed: Placed { pair: job.pair, sample, world_from_object }, orders: Vec::new() }
    };
    (job.first..4.min(job.first.saturating_add(job.count))).map(choice).collect()
}

/// The grasp tells the alternatives apart.
pub fn alternative(problem: &Problem, pair: PairId, index: u32) -> Alternative {
    let q = problem.robot(problem.pair(pair).robot).start.clone();
    let reach = Reach {
        stand: q[..problem.robot(problem.pair(pair).robot).base_len()].to_vec(),
        at_object: q.clone(),
        approach: vec![q.clone()],
        lift: vec![q],
        lift_up: 0,
        support: FixedId(0),
    };
    Alternative { index, grasp: GraspId(index), pick: reach.clone(), place: reach }
}

pub fn fails(cause: Cause, soundness: Soundness) -> Outcome {
    Outcome {
        result: Err(FailureReport { causes: vec![(cause, 1)], soundness, certificate: None, rests_on: None }),
        work: 1,
    }
}

pub fn no_path(pair: &str) -> Cause {
    Cause::NoPath { pair: Some(pair.to_owned()), robot: "r".to_owned(), blocking: Vec::new() }
}

pub fn decisions(ledger: &Ledger) -> Vec<Decision> {
    let decided = |entry: &LedgerEntry| match entry {
        LedgerEntry::Decided(decision) => Some(decision.clone()),
        _ => None,
    };
    ledger.entries.iter().filter_map(decided).collect()
}

pub fn transfer_fails_with(robot: u32, grasps: std::ops::Range<u32>) -> Rule {
    Box::new(move |request| match request {
        Request::Mode(job) if job.mode.robot.0 == robot && job.holding.is_some_and(|h| grasps.contains(&h.grasp.0)) => {
            Some(fails(no_path("x"), Soundness::Soft { level: 0 }))
        }
        _ => None,
    })
}
