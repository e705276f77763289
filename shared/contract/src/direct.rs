//! The reference mode: stages called directly, in program order.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::{
    AskFault, AskStages, Foresight, Interrupted, Job, JobContext, JobId, MemoryProducts, Outcome, ProblemStatement,
    Products, Stage, StageKind,
};

/// Called with every job that was worked on and its outcome.
type Observer = Box<dyn FnMut(&Job, &Outcome)>;

/// Stages in this process. Answers are kept: a job asked twice is worked on once.
pub struct DirectCalls {
    statement: Arc<ProblemStatement>,
    stages: BTreeMap<StageKind, Box<dyn Stage>>,
    products: Arc<MemoryProducts>,
    answered: BTreeMap<JobId, Outcome>,
    cancelled: Arc<AtomicBool>,
    observe: Observer,
}

impl DirectCalls {
    /// Direct calls to `stages`; setting `cancelled` ends the run at the next poll.
    #[must_use]
    pub fn new(
        statement: Arc<ProblemStatement>,
        stages: BTreeMap<StageKind, Box<dyn Stage>>,
        cancelled: Arc<AtomicBool>,
    ) -> Self {
        let products = Arc::new(MemoryProducts::default());
        Self { statement, stages, products, answered: BTreeMap::new(), cancelled, observe: Box::new(|_, _| ()) }
    }

    /// Calls `observe` after every job that was worked on.
    pub fn observe(&mut self, observe: impl FnMut(&Job, &Outcome) + 'static) {
        self.observe = Box::new(observe);
    }

    /// Where the products are.
    #[must_use]
    pub fn products(&self) -> Arc<dyn Products> {
        self.products.clone()
    }

    fn answer(&mut self, job: &Job) -> Result<Outcome, AskFault> {
        let id = self.job_id(job);
        if let Some(outcome) = self.answered.get(&id) {
            return Ok(outcome.clone());
        }
        let stage = self.stages.get(&job.stage()).ok_or(AskFault::NoWorker { stage: job.stage() })?;
        let mut context = JobContext::new(id, job, self.products.as_ref(), self.cancelled.clone());
        let outcome = stage.refine(job, &mut context).map_err(|interrupted| match interrupted {
            Interrupted::Cancelled => AskFault::Cancelled,
            other => AskFault::Refused { stage: job.stage(), reason: other.to_string() },
        })?;
        self.answered.insert(id, outcome.clone());
        (self.observe)(job, &outcome);
        Ok(outcome)
    }
}

impl AskStages for DirectCalls {
    fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault> {
        jobs.iter().map(|job| self.answer(job)).collect()
    }

    fn foresee(&mut self, _: Foresight) {}

    fn job_id(&self, job: &Job) -> JobId {
        job.id(&self.statement)
    }
}
