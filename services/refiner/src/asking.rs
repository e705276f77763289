//! Asking: outcomes committed to the ledger, work counted and limited, more samples where a stage's policy wants them.

use contract::{
    AskFault, ComposeJob, Composition, Decision, Digest, FailureReport, Job, JobId, LedgerEntry, ModeJob, Outcome,
    ProductRef, Request, StageKind, WorkKind,
};
use model::FailurePolicy;
use plan::{Cause, StageCount};

use crate::budgets::capped;
use crate::conflict::Halt;
use crate::search::Search;

/// No sample count is raised beyond this level.
const HIGHEST_LEVEL: u32 = 16;

impl Search<'_> {
    /// Identity of a job.
    pub(crate) fn id(&self, job: &Job) -> JobId {
        self.stages.job_id(job)
    }

    pub(crate) fn policy(&self, stage: StageKind) -> FailurePolicy {
        self.statement.options.policy(stage)
    }

    pub(crate) fn ask_one(&mut self, job: &Job) -> Result<Outcome, Halt> {
        let mut outcomes = self.ask(std::slice::from_ref(job))?;
        outcomes.pop().ok_or_else(|| misfit(job.stage()).into())
    }

    /// Outcomes in the order of the jobs. What a stage fails at is asked again with more samples, or ends the search, if
    /// its policy says so.
    pub(crate) fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, Halt> {
        let mut outcomes = self.ask_once(jobs)?;
        for (job, outcome) in jobs.iter().zip(&mut outcomes) {
            let Err(report) = &outcome.result else { continue };
            // Of placement, the level loop knows whether a failure is one.
            if job.stage() == StageKind::Placement || !is_whole_question(job) {
                continue;
            }
            if self.policy(job.stage()) == FailurePolicy::Stop {
                return Err(self.stopped(job.stage(), report));
            }
            if let Some(again) = self.ask_for_more(job, report)? {
                *outcome = again;
            }
        }
        Ok(outcomes)
    }

    /// The end of a search whose stage fails and has to stop then.
    pub(crate) fn stopped(&mut self, stage: StageKind, report: &FailureReport) -> Halt {
        self.commit(LedgerEntry::Stopped { stage });
        Halt::Stopped(report.causes.clone())
    }

    /// Commits that a stage is asked for more samples.
    pub(crate) fn decide_more(&mut self, stage: StageKind, doublings: u32) {
        let times = 1_u32.checked_shl(doublings).unwrap_or(u32::MAX);
        self.commit(LedgerEntry::Decided(Decision::More { stage, times }));
    }

    /// The first answer to a question that has failed, asked with ever more samples.
    fn ask_for_more(&mut self, job: &Job, report: &FailureReport) -> Result<Option<Outcome>, Halt> {
        let ran_out = |(cause, _): &(Cause, u64)| matches!(cause, Cause::Budget { .. });
        if is_search_for_all(job) && !report.causes.iter().any(ran_out) {
            // It has seen everything; more of the same changes nothing.
            return Ok(None);
        }
        for doublings in self.policy(job.stage()).doublings() {
            self.decide_more(job.stage(), doublings);
            let Some(more) = self.with_more(job, doublings)? else { return Ok(None) };
            let outcome = self.ask_once(&[more])?.pop().ok_or_else(|| misfit(job.stage()))?;
            if outcome.result.is_ok() {
                return Ok(Some(outcome));
            }
        }
        Ok(None)
    }

    /// The same question with samples and budget doubled so often.
    pub(crate) fn with_more(&mut self, job: &Job, doublings: u32) -> Result<Option<Job>, Halt> {
        let mut more = job.clone();
        match &mut more.request {
            Request::Transition(asked) => {
                asked.level = raised(asked.level, doublings);
                asked.count = asked.count.saturating_mul(1 << doublings.min(HIGHEST_LEVEL));
            }
            Request::Piece(asked) => asked.level = raised(asked.level, doublings),
            Request::Mode(asked) => self.raise_mode(asked, doublings)?,
            Request::Compose(_) => {}
            Request::Placement(_)
            | Request::Hop(_)
            | Request::Samples(_)
            | Request::Blockers(_)
            | Request::GraspBlockers(_) => return Ok(None),
        }
        let units = job.budget.saturating_mul(1 << doublings.min(HIGHEST_LEVEL));
        more.budget = capped(&self.statement.options, &more.request, units);
        Ok(Some(more))
    }

    /// More samples for a mode: for its pieces, and for their connections.
    fn raise_mode(&mut self, asked: &mut ModeJob, doublings: u32) -> Result<(), Halt> {
        asked.level = raised(asked.level, doublings);
        for slot in [&mut asked.base, &mut asked.start_arm, &mut asked.goal_arm] {
            let Some(piece) = slot.and_then(|product: ProductRef| self.pieces.get(&product.made_by)).cloned() else {
                continue;
            };
            let Some(more) = self.with_more(&piece, doublings)? else { continue };
            let outcome = self.ask_once(&[more])?.pop().ok_or_else(|| misfit(StageKind::Roadmap))?;
            if let Ok(contract::Answer::Piece(product)) = outcome.result {
                *slot = Some(product);
            }
        }
        Ok(())
    }

    /// Outcomes in the order of the jobs, all committed to the ledger. The first proof that there is no plan ends the
    /// search, and so does a limit on work.
    pub(crate) fn ask_once(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, Halt> {
        let outcomes = self.stages.ask(jobs)?;
        for (job, outcome) in jobs.iter().zip(&outcomes) {
            let id = self.id(job);
            let digest = Digest::of("mrtamp outcome", &[&contract::encode_canonical(outcome)]);
            self.commit(LedgerEntry::Used { job: id, outcome: digest });
            if self.used.insert(id) {
                self.count(job, outcome)?;
            }
            let may_be_raised = matches!(self.policy(StageKind::Roadmap), FailurePolicy::More { .. });
            if may_be_raised && matches!(job.request, Request::Piece(_)) {
                self.pieces.insert(id, job.clone());
            }
        }
        let reports = outcomes.iter().filter_map(|outcome| outcome.result.as_ref().err());
        match reports.into_iter().find(|report| report.proof().is_some()) {
            Some(report) => Err(Halt::Proven(report.clone())),
            None => Ok(outcomes),
        }
    }

    fn count(&mut self, job: &Job, outcome: &Outcome) -> Result<(), Halt> {
        let stage = job.stage();
        let fresh = || StageCount { stage: stage.name().to_owned(), ..StageCount::default() };
        let count = self.counts.entry(stage).or_insert_with(fresh);
        count.jobs += 1;
        count.failures += u64::from(outcome.result.is_err());
        count.work += outcome.work;
        if let Err(report) = &outcome.result {
            self.met.count_all(&report.causes);
        }
        let spent = [Some(WorkKind::Stage(stage)), job.request.is_drrt().then_some(WorkKind::Drrt)];
        for work in spent.into_iter().flatten() {
            let spent = self.spent.entry(work).or_insert(0);
            *spent = spent.saturating_add(outcome.work);
            let spent = *spent;
            if self.statement.options.limit(work).is_some_and(|limit| spent > limit) {
                self.commit(LedgerEntry::LimitReached { work, spent });
                return Err(Halt::LimitReached(work));
            }
        }
        Ok(())
    }
}

/// Whether a failure of the job is one of its stage. A single mode that cannot be committed, a repair, and a composite search
/// after a prefix are steps on the way.
fn is_whole_question(job: &Job) -> bool {
    match &job.request {
        Request::Compose(compose) => match compose.composition {
            Composition::CommitMode { .. } | Composition::Repair { .. } | Composition::Passages { .. } => false,
            Composition::Drrt { prefix, .. } => prefix.is_none(),
            Composition::Assemble { .. } | Composition::Synchronous { .. } => true,
        },
        Request::Placement(_)
        | Request::Hop(_)
        | Request::Samples(_)
        | Request::GraspBlockers(_)
        | Request::Transition(_)
        | Request::Blockers(_)
        | Request::Piece(_)
        | Request::Mode(_) => true,
    }
}

/// Whether the job searches for the motion of all robots.
fn is_search_for_all(job: &Job) -> bool {
    let is_synchronous = |compose: &ComposeJob| matches!(compose.composition, Composition::Synchronous { .. });
    job.request.is_drrt() || matches!(&job.request, Request::Compose(compose) if is_synchronous(compose))
}

fn raised(level: u32, doublings: u32) -> u32 {
    level.saturating_add(doublings).min(HIGHEST_LEVEL.max(level))
}

/// A stage answered with the answer of another request.
pub(crate) fn misfit(stage: StageKind) -> AskFault {
    AskFault::Refused { stage, reason: "its answer does not belong to the job".to_owned() }
}
