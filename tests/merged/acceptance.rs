//! Which complete placements a pipeline accepts, seen from outside: those with which it comes to a stage that then refuses
//! everything.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use contract::{
    Answer, AskFault, AskStages, CauseTally, CompositeMethod, Decision, DirectCalls, Foresight, Job, JobId,
    LedgerEntry, Merge, Outcome, ProblemStatement, Request, StageKind,
};
use launch::stages::{BusyTimes, own_stages};
use model::{FailurePolicy, PairId, Problem};
use refiner::{End, refine_plan};
use skeleton::Event;

use crate::orders::irredundant;

/// The sample of each pair in their order, and the orders, sorted.
pub type Placement = (Vec<u32>, Vec<(Event, Event)>);

/// Pipelines on one problem. Answers of stages are shared between them.
pub struct Pipelines {
    statement: Arc<ProblemStatement>,
    pub calls: DirectCalls,
}

impl Pipelines {
    pub fn new(problem: &Problem, seed: u64) -> Self {
        let statement = Arc::new(ProblemStatement::new(problem.clone(), seed, CompositeMethod::Prioritised));
        let stages = own_stages(&statement, &BusyTimes::default()).unwrap();
        let calls = DirectCalls::new(statement.clone(), stages, Arc::new(AtomicBool::new(false)));
        Self { statement, calls }
    }

    pub fn problem(&self) -> &Problem {
        &self.statement.problem
    }

    /// Everything that a pipeline accepts before it asks `until`, and the number of jobs that it asked.
    pub fn accepted(&mut self, merge: Merge, causes: bool, until: StageKind) -> (BTreeSet<Placement>, usize) {
        let mut statement = ProblemStatement::clone(&self.statement);
        statement.options.merge = merge;
        statement.options.policies.transition = Some(FailurePolicy::Backtrack { causes });
        statement.options.candidates = u32::MAX;
        statement.options.composite_failures = 1;
        let present = RefCell::new(Present::default());
        let mut toll = Toll {
            problem: &self.statement.problem,
            calls: &mut self.calls,
            until,
            present: &present,
            accepted: BTreeSet::new(),
            asked: 0,
        };
        let run = refine_plan(&statement, &mut toll, &mut |entry| present.borrow_mut().note(entry));
        assert!(matches!(run.end, End::Failed { .. }), "{:?}", run.end);
        (toll.accepted, toll.asked)
    }
}

/// The placement that the search is at.
#[derive(Default)]
struct Present {
    samples: BTreeMap<PairId, u32>,
    orders: BTreeMap<PairId, Vec<(Event, Event)>>,
}

impl Present {
    fn note(&mut self, entry: &LedgerEntry) {
        if let LedgerEntry::Decided(Decision::Hop { pair, sample, orders }) = entry {
            self.samples.insert(*pair, *sample);
            self.orders.insert(*pair, orders.clone());
        }
    }
}

struct Toll<'a> {
    problem: &'a Problem,
    calls: &'a mut DirectCalls,
    until: StageKind,
    present: &'a RefCell<Present>,
    accepted: BTreeSet<Placement>,
    asked: usize,
}

impl Toll<'_> {
    fn refused(&mut self, job: &Job) -> Outcome {
        let present = self.present.borrow();
        let samples = present.samples.values().copied().collect();
        let mut orders: Vec<(Event, Event)> = match &job.request {
            Request::Compose(job) => job.assignment.orders.iter().map(|order| (order.before, order.after)).collect(),
            _ => irredundant(self.problem, &present.orders.values().flatten().copied().collect::<Vec<_>>()),
        };
        orders.sort_unstable();
        drop(present);
        self.accepted.insert((samples, orders));
        Outcome::soft_failure(CauseTally::default(), 0, 0)
    }
}

impl AskStages for Toll<'_> {
    fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault> {
        let mut outcomes = Vec::new();
        for job in jobs {
            self.asked += 1;
            if job.stage() == self.until {
                outcomes.push(self.refused(job));
                continue;
            }
            let outcome = self.calls.ask(std::slice::from_ref(job))?.remove(0);
            if let Ok(Answer::Placements(candidates)) = &outcome.result {
                let mut present = self.present.borrow_mut();
                for candidate in candidates {
                    present.samples = candidate.placements.iter().map(|placed| (placed.pair, placed.sample)).collect();
                    let orders = candidate.orders.iter().map(|order| (order.before, order.after)).collect();
                    present.orders = BTreeMap::from([(PairId(0), orders)]);
                }
            }
            outcomes.push(outcome);
        }
        Ok(outcomes)
    }

    fn foresee(&mut self, _: Foresight) {}

    fn job_id(&self, job: &Job) -> JobId {
        self.calls.job_id(job)
    }
}
