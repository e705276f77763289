//! Refines problems by direct calls that count, that may be cut short, and whose answers a test may replace.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use contract::{
    Answer, AskFault, AskStages, CompositeMethod, DirectCalls, Foresight, Job, JobId, Ledger, Outcome,
    PlacementCandidate, ProblemStatement, StageKind,
};
use launch::ending::finished_plan;
use launch::stages::{BusyTimes, own_stages};
use model::{PairId, Problem};
use plan::{Certificate, Plan};
use refiner::{End, refine_plan};

#[path = "../../shared/validation/tests/checker/certificates/failure.rs"]
mod failure;

use failure::failure;

/// Work units of transition, roadmap and composite after which a run is cut short, if nothing else is said.
pub const UNLIMITED: u64 = u64::MAX;

/// An answer in a stage's place.
pub type Instead<'a> = &'a dyn Fn(&Job) -> Option<Outcome>;

/// What a run leaves.
pub struct Run {
    pub end: End,
    pub plan: Option<Plan>,
    pub ledger: Ledger,
    /// Jobs that each stage was asked, repeated ones included.
    pub asked: BTreeMap<StageKind, u64>,
    /// Work units of transition, roadmap and composite; what is asked again costs nothing.
    pub work: u64,
    /// Placement candidates taken up, in order: each pair's sample.
    pub candidates: Vec<BTreeMap<PairId, u32>>,
}

impl Run {
    pub fn asked(&self, stage: StageKind) -> u64 {
        self.asked.get(&stage).copied().unwrap_or(0)
    }
}

/// Direct calls with a limit on work.
struct Watched<'a> {
    calls: DirectCalls,
    asked: BTreeMap<StageKind, u64>,
    worked: BTreeSet<JobId>,
    work: u64,
    candidates: Vec<BTreeMap<PairId, u32>>,
    limit: u64,
    instead: Option<Instead<'a>>,
}

impl AskStages for Watched<'_> {
    fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault> {
        jobs.iter().map(|job| self.answer(job)).collect()
    }

    fn foresee(&mut self, foresight: Foresight) {
        self.calls.foresee(foresight);
    }

    fn job_id(&self, job: &Job) -> JobId {
        self.calls.job_id(job)
    }
}

impl Watched<'_> {
    fn answer(&mut self, job: &Job) -> Result<Outcome, AskFault> {
        if self.work >= self.limit {
            return Err(AskFault::TimeLimit);
        }
        *self.asked.entry(job.stage()).or_insert(0) += 1;
        let outcome = match self.instead.and_then(|instead| instead(job)) {
            Some(outcome) => outcome,
            None => self.calls.ask(std::slice::from_ref(job))?.pop().ok_or(AskFault::Cancelled)?,
        };
        if let Ok(Answer::Placements(candidates)) = &outcome.result {
            let samples = |candidate: &PlacementCandidate| {
                candidate.placements.iter().map(|placed| (placed.pair, placed.sample)).collect()
            };
            self.candidates.extend(candidates.iter().map(samples));
        }
        if job.stage() != StageKind::Placement && self.worked.insert(self.calls.job_id(job)) {
            self.work += outcome.work;
        }
        Ok(outcome)
    }
}

/// Refines a problem.
pub fn run(problem: &Problem, seed: u64, composite: CompositeMethod) -> Run {
    run_with(problem, seed, composite, UNLIMITED, None)
}

/// Refines a problem with at most `limit` work units, stages' answers replaced where `instead` has one.
pub fn run_with(
    problem: &Problem,
    seed: u64,
    composite: CompositeMethod,
    limit: u64,
    instead: Option<Instead<'_>>,
) -> Run {
    let statement = Arc::new(ProblemStatement::new(problem.clone(), seed, composite));
    let stages = own_stages(&statement, &BusyTimes::default()).expect("the geometry of a valid problem is usable");
    let calls = DirectCalls::new(statement.clone(), stages, Arc::new(AtomicBool::new(false)));
    let products = calls.products();
    let (asked, worked) = (BTreeMap::new(), BTreeSet::new());
    let mut watched = Watched { calls, asked, worked, work: 0, candidates: Vec::new(), limit, instead };
    let refinement = refine_plan(&statement, &mut watched, &mut |_| ());
    let plan = match &refinement.end {
        End::Solved { plan, .. } => products.get(&plan.digest),
        End::Failed { .. } | End::Fault(_) => None,
    };
    let plan = plan.map(|bytes| finished_plan(&statement, &refinement.ledger, &bytes).expect("a plan"));
    let Watched { asked, work, candidates, .. } = watched;
    Run { end: refinement.end, plan, ledger: refinement.ledger, asked, work, candidates }
}

/// What the checker says of a certificate.
pub fn verify(problem: &Problem, certificate: &Certificate) -> Result<(), String> {
    let failure = failure(problem, Some(certificate.clone()));
    validation::check_failure(problem, &failure).map_err(|violations| format!("not verified: {violations:?}"))
}
