//! Levels and placement candidates: the outer loops of the search.

use std::collections::{BTreeMap, BTreeSet};

use contract::{
    Answer, AskFault, AskStages, CauseTally, Decision, Digest, FailureReport, Job, JobId, Ledger, LedgerEntry, Outcome,
    PlacementCandidate, PlacementJob, ProblemStatement, ProductRef, Request, Soundness, StageKind,
};
use model::Problem;
use plan::{Cause, PairPoint, ResultKind, StageCount};
use skeleton::{Cycle, Skeleton};

use crate::budgets::Budgets;
use crate::candidate::Candidate;
use crate::{End, Refinement};

/// Placement candidates refined at one level before the next level is tried.
const CANDIDATES_PER_LEVEL: u32 = 32;

/// Why a part of the search has no result.
pub(crate) enum Stuck {
    /// Asking failed: the run ends.
    Fault(AskFault),
    /// The choices cannot be completed.
    Failed(Vec<(Cause, u64)>),
}

impl From<AskFault> for Stuck {
    fn from(fault: AskFault) -> Self {
        Self::Fault(fault)
    }
}

/// State of one search.
pub(crate) struct Search<'a> {
    pub(crate) statement: &'a ProblemStatement,
    pub(crate) stages: &'a mut dyn AskStages,
    observe: &'a mut dyn FnMut(&LedgerEntry),
    ledger: Ledger,
    causes: CauseTally,
    used: BTreeSet<JobId>,
    counts: BTreeMap<StageKind, StageCount>,
}

/// How far one level came.
enum LevelEnd {
    Solved(ProductRef, f64),
    Exhausted,
    /// No level can help.
    Hopeless,
}

impl<'a> Search<'a> {
    pub(crate) fn new(
        statement: &'a ProblemStatement,
        stages: &'a mut dyn AskStages,
        observe: &'a mut dyn FnMut(&LedgerEntry),
    ) -> Self {
        Self {
            statement,
            stages,
            observe,
            ledger: Ledger::default(),
            causes: CauseTally::default(),
            used: BTreeSet::new(),
            counts: BTreeMap::new(),
        }
    }

    pub(crate) fn problem(&self) -> &'a Problem {
        &self.statement.problem
    }

    pub(crate) fn run(mut self) -> Refinement {
        let end = match self.levels() {
            Ok(Some((plan, makespan_s))) => {
                self.commit(LedgerEntry::Solved { plan: plan.digest });
                End::Solved { plan, makespan_s }
            }
            Ok(None) => {
                let causes = std::mem::take(&mut self.causes).ranked();
                End::Failed { result: ResultKind::SamplesExhausted, causes }
            }
            Err(AskFault::TimeLimit) => {
                let causes = std::mem::take(&mut self.causes).ranked();
                End::Failed { result: ResultKind::LimitReached, causes }
            }
            Err(fault) => End::Fault(fault),
        };
        let stages = self.counts.into_values().collect();
        Refinement { ledger: self.ledger, end, stages }
    }

    fn levels(&mut self) -> Result<Option<(ProductRef, f64)>, AskFault> {
        let skeleton = match Skeleton::of_problem(self.problem()) {
            Ok(skeleton) => skeleton,
            Err(cycle) => {
                self.causes.count(self.cycle_cause(&cycle));
                return Ok(None);
            }
        };
        for level in 0..=self.problem().levels.highest {
            self.commit(LedgerEntry::Decided(Decision::Level(level)));
            match self.level(level, &skeleton)? {
                LevelEnd::Solved(plan, makespan_s) => return Ok(Some((plan, makespan_s))),
                LevelEnd::Hopeless => return Ok(None),
                LevelEnd::Exhausted => {}
            }
        }
        Ok(None)
    }

    fn level(&mut self, level: u32, skeleton: &Skeleton) -> Result<LevelEnd, AskFault> {
        let budgets = Budgets::at(&self.problem().levels, level);
        for index in 0..CANDIDATES_PER_LEVEL {
            let asked =
                |first| budgets.job(Request::Placement(PlacementJob { level, first, count: 1, nogoods: Vec::new() }));
            let candidate = match self.ask_one(&asked(index))?.result {
                Ok(Answer::Placements(candidates)) => candidates.into_iter().next(),
                Ok(_) => return Err(misfit(StageKind::Placement)),
                Err(report) => {
                    self.causes.count_all(&report.causes);
                    let hopeless = report.soundness == Soundness::Hard;
                    return Ok(if hopeless { LevelEnd::Hopeless } else { LevelEnd::Exhausted });
                }
            };
            let Some(candidate) = candidate else { return Ok(LevelEnd::Exhausted) };
            self.commit(LedgerEntry::Decided(Decision::Placement(candidate.index)));
            match self.refine(level, budgets, skeleton, &candidate) {
                Ok((plan, makespan_s)) => return Ok(LevelEnd::Solved(plan, makespan_s)),
                Err(Stuck::Fault(fault)) => return Err(fault),
                Err(Stuck::Failed(causes)) => {
                    self.backtrack(StageKind::Placement, Decision::Placement(candidate.index), &causes);
                }
            }
        }
        Ok(LevelEnd::Exhausted)
    }

    fn refine(
        &mut self,
        level: u32,
        budgets: Budgets,
        skeleton: &Skeleton,
        candidate: &PlacementCandidate,
    ) -> Result<(ProductRef, f64), Stuck> {
        let mut skeleton = skeleton.clone();
        for order in &candidate.orders {
            if let Err(cycle) = skeleton.graph.add(order.before, order.after, skeleton::ArcOrigin::Discovered) {
                return Err(Stuck::Failed(vec![(self.cycle_cause(&cycle), 1)]));
            }
        }
        Candidate::new(self.problem(), level, budgets, skeleton, candidate).complete(self)
    }

    /// Commits a backtrack request and keeps its causes.
    pub(crate) fn backtrack(&mut self, stage: StageKind, decision: Decision, causes: &[(Cause, u64)]) {
        self.causes.count_all(causes);
        let because = causes.first().map(|(cause, _)| cause.clone());
        self.commit(LedgerEntry::Backtrack { stage, decision, because });
    }

    pub(crate) fn commit(&mut self, entry: LedgerEntry) {
        (self.observe)(&entry);
        self.ledger.commit(entry);
    }

    pub(crate) fn ask_one(&mut self, job: &Job) -> Result<Outcome, AskFault> {
        let mut outcomes = self.ask(std::slice::from_ref(job))?;
        outcomes.pop().ok_or(misfit(job.stage()))
    }

    /// Outcomes in the order of the jobs, all committed to the ledger.
    pub(crate) fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault> {
        let outcomes = self.stages.ask(jobs)?;
        for (job, outcome) in jobs.iter().zip(&outcomes) {
            let id = self.stages.job_id(job);
            let digest = Digest::of("mrtamp outcome", &[&contract::encode_canonical(outcome)]);
            self.commit(LedgerEntry::Used { job: id, outcome: digest });
            if self.used.insert(id) {
                self.count(job.stage(), outcome);
            }
        }
        Ok(outcomes)
    }

    fn count(&mut self, stage: StageKind, outcome: &Outcome) {
        let fresh = || StageCount { stage: stage.name().to_owned(), ..StageCount::default() };
        let count = self.counts.entry(stage).or_insert_with(fresh);
        count.jobs += 1;
        count.failures += u64::from(outcome.result.is_err());
        count.work += outcome.work;
    }

    fn cycle_cause(&self, cycle: &Cycle) -> Cause {
        let point = |event: skeleton::Event| PairPoint {
            pair: self.problem().pair(event.pair).name.clone(),
            point: event.point,
        };
        Cause::Cycle { points: cycle.0.iter().map(|arc| point(arc.before)).collect() }
    }
}

/// A stage answered with the answer of another request.
pub(crate) fn misfit(stage: StageKind) -> AskFault {
    AskFault::Refused { stage, reason: "its answer does not belong to the job".to_owned() }
}

/// The failure of a report.
pub(crate) fn failed(report: FailureReport) -> Stuck {
    Stuck::Failed(report.causes)
}
