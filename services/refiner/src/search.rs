//! Levels and placement candidates: the outer loops of the search.

use std::collections::{BTreeMap, BTreeSet};

use contract::{
    Answer, AskFault, AskStages, CauseTally, Decision, Digest, Job, JobId, Ledger, LedgerEntry, Literal, Nogood,
    Outcome, PlacementCandidate, PlacementJob, ProblemStatement, Request, Soundness, StageKind,
};
use model::Problem;
use plan::{Cause, Certificate, PairPoint, ResultKind, StageCount};
use skeleton::{Cycle, Skeleton};

use crate::budgets::Budgets;
use crate::candidate::{Candidate, Found};
use crate::conflict::{Choice, Conflict, Halt, Stuck};
use crate::{End, Refinement};

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
    Solved(Found),
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
            Ok(None) => self.failed(ResultKind::SamplesExhausted, None),
            Err(Halt::Proven(report)) => {
                self.causes.count_all(&report.causes);
                self.failed(ResultKind::InfeasibleProven, report.certificate)
            }
            Err(Halt::Fault(AskFault::TimeLimit)) => self.failed(ResultKind::LimitReached, None),
            Err(Halt::Fault(fault)) => End::Fault(fault),
        };
        let stages = self.counts.into_values().collect();
        Refinement { ledger: self.ledger, end, stages }
    }

    fn failed(&mut self, result: ResultKind, certificate: Option<Certificate>) -> End {
        End::Failed { result, causes: std::mem::take(&mut self.causes).ranked(), certificate }
    }

    fn levels(&mut self) -> Result<Option<Found>, Halt> {
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
                LevelEnd::Solved(found) => return Ok(Some(found)),
                LevelEnd::Hopeless => return Ok(None),
                LevelEnd::Exhausted => {}
            }
        }
        Ok(None)
    }

    /// Candidates one after the other; with causes, each failure excludes every candidate that shares its choices.
    fn level(&mut self, level: u32, skeleton: &Skeleton) -> Result<LevelEnd, Halt> {
        let budgets = Budgets::at(&self.problem().levels, level);
        let mut nogoods: Vec<Vec<Literal>> = Vec::new();
        for tried in 0..self.statement.options.candidates {
            let first = if self.statement.options.causes { 0 } else { tried };
            let job = PlacementJob { level, first, count: 1, nogoods: nogoods.clone() };
            let candidate = match self.ask_one(&budgets.job(Request::Placement(job)))?.result {
                Ok(Answer::Placements(candidates)) => candidates.into_iter().next(),
                Ok(_) => return Err(misfit(StageKind::Placement).into()),
                Err(report) => {
                    self.causes.count_all(&report.causes);
                    let hopeless = report.soundness == Soundness::Hard && nogoods.is_empty();
                    return Ok(if hopeless { LevelEnd::Hopeless } else { LevelEnd::Exhausted });
                }
            };
            let Some(candidate) = candidate else { return Ok(LevelEnd::Exhausted) };
            self.commit(LedgerEntry::Decided(Decision::Placement(tried)));
            let conflict = match self.refine(level, budgets, skeleton, &candidate) {
                Ok(found) => return Ok(LevelEnd::Solved(found)),
                Err(Stuck::Halted(halt)) => return Err(halt),
                Err(Stuck::Failed(conflict)) => conflict,
            };
            self.causes.count_all(&conflict.causes.clone().ranked());
            self.backtrack(StageKind::Placement, Decision::Placement(tried), conflict.first_cause());
            let literals = literals_of(self.problem(), &conflict, &candidate);
            if self.statement.options.causes {
                if literals.is_empty() {
                    // It depends on nothing that placement chooses.
                    return Ok(LevelEnd::Exhausted);
                }
                self.learn(level, &conflict, &literals);
                nogoods.push(literals);
            }
        }
        Ok(LevelEnd::Exhausted)
    }

    fn learn(&mut self, level: u32, conflict: &Conflict, literals: &[Literal]) {
        let Some(proof) = conflict.proof else { return };
        self.commit(LedgerEntry::Learnt(Nogood {
            literals: literals.to_vec(),
            cause: conflict.first_cause(),
            soundness: Soundness::Soft { level },
            proof,
        }));
    }

    fn refine(
        &mut self,
        level: u32,
        budgets: Budgets,
        skeleton: &Skeleton,
        candidate: &PlacementCandidate,
    ) -> Result<Found, Stuck> {
        let mut skeleton = skeleton.clone();
        for order in &candidate.orders {
            if let Err(cycle) = skeleton.graph.add(order.before, order.after, skeleton::ArcOrigin::Discovered) {
                let causes = [(self.cycle_cause(&cycle), 1)];
                let poses = skeleton.occupancies().map(Choice::Pose);
                return Err(Stuck::Failed(Conflict::of(poses, &causes, None)));
            }
        }
        Candidate::new(self, level, budgets, skeleton, candidate).complete(self)
    }

    /// Commits a backtrack request.
    pub(crate) fn backtrack(&mut self, stage: StageKind, decision: Decision, because: Option<Cause>) {
        self.commit(LedgerEntry::Backtrack { stage, decision, because });
    }

    pub(crate) fn commit(&mut self, entry: LedgerEntry) {
        (self.observe)(&entry);
        self.ledger.commit(entry);
    }

    /// Identity of a job.
    pub(crate) fn id(&self, job: &Job) -> JobId {
        self.stages.job_id(job)
    }

    pub(crate) fn ask_one(&mut self, job: &Job) -> Result<Outcome, Halt> {
        let mut outcomes = self.ask(std::slice::from_ref(job))?;
        outcomes.pop().ok_or_else(|| misfit(job.stage()).into())
    }

    /// Outcomes in the order of the jobs, all committed to the ledger. The first proof that there is no plan ends the search.
    pub(crate) fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, Halt> {
        let outcomes = self.stages.ask(jobs)?;
        for (job, outcome) in jobs.iter().zip(&outcomes) {
            let id = self.id(job);
            let digest = Digest::of("mrtamp outcome", &[&contract::encode_canonical(outcome)]);
            self.commit(LedgerEntry::Used { job: id, outcome: digest });
            if self.used.insert(id) {
                self.count(job.stage(), outcome);
            }
        }
        let reports = outcomes.iter().filter_map(|outcome| outcome.result.as_ref().err());
        match reports.into_iter().find(|report| report.proof().is_some()) {
            Some(report) => Err(Halt::Proven(report.clone())),
            None => Ok(outcomes),
        }
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

/// What a conflict says about a placement candidate: the samples it depends on. Start poses are nobody's choice. What
/// stands where when depends on the candidate's orderings too, so they all count.
fn literals_of(problem: &Problem, conflict: &Conflict, candidate: &PlacementCandidate) -> Vec<Literal> {
    let mut literals = Vec::new();
    for choice in &conflict.choices {
        let Choice::Pose(occupancy) = *choice else { continue };
        let creates = |pair: model::PairId| {
            let pair = problem.pair(pair);
            (pair.object, pair.hop) == (occupancy.object, occupancy.hop)
        };
        let placed = candidate.placements.iter().find(|placed| creates(placed.pair));
        literals.extend(placed.map(|placed| Literal::Pose { occupancy, sample: placed.sample }));
    }
    let orders = candidate.orders.iter();
    literals.extend(orders.map(|order| Literal::Order { before: order.before, after: order.after }));
    literals
}

/// A stage answered with the answer of another request.
pub(crate) fn misfit(stage: StageKind) -> AskFault {
    AskFault::Refused { stage, reason: "its answer does not belong to the job".to_owned() }
}
