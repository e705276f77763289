//! All that the search may know of the outside.

use serde::{Deserialize, Serialize};

use crate::{Job, JobId, Outcome, StageKind};

/// How the search asks.
pub trait AskStages {
    /// Outcomes in the order of `jobs`, whatever the order in which they arrive.
    ///
    /// # Errors
    /// [`AskFault`]: never a statement about the problem.
    fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault>;

    /// Advice only: jobs worth starting now, best first. What is in flight, neither asked nor listed, may be cancelled.
    fn foresee(&mut self, foresight: Foresight);

    /// Identity of a job in this run.
    fn job_id(&self, job: &Job) -> JobId;
}

/// A pure function from the outcomes that have arrived so far to a ranked list of jobs worth starting.
pub struct Foresight {
    /// Outcome lookup in, jobs out.
    #[allow(clippy::type_complexity)]
    pub jobs: Box<dyn Fn(&dyn Fn(&JobId) -> Option<Outcome>) -> Vec<Job> + Send>,
}

impl Foresight {
    /// Nothing is worth starting.
    #[must_use]
    pub fn nothing() -> Self {
        Self { jobs: Box::new(|_| Vec::new()) }
    }

    /// A fixed list.
    #[must_use]
    pub fn list(jobs: Vec<Job>) -> Self {
        Self { jobs: Box::new(move |_| jobs.clone()) }
    }
}

/// Why asking failed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum AskFault {
    /// The run's limit on time was reached.
    #[error("the time limit was reached")]
    TimeLimit,
    /// The user wants the run to end.
    #[error("ended by signal")]
    Cancelled,
    /// Workers died again and again on one job.
    #[error("{deaths} workers of stage {stage} died on one job; it is kept in {replay}")]
    PoisonJob {
        /// Stage.
        stage: StageKind,
        /// Deaths.
        deaths: u32,
        /// Replay file.
        replay: String,
    },
    /// Two different outcomes arrived for one job: a stage is not a function of its job.
    #[error("stage {stage} gave two different outcomes for one job")]
    Nondeterministic {
        /// Stage.
        stage: StageKind,
    },
    /// A stage refuses a job that it should be able to answer.
    #[error("stage {stage} refuses a job: {reason}")]
    Refused {
        /// Stage.
        stage: StageKind,
        /// What it says.
        reason: String,
    },
    /// Nobody answers: no worker of the stage is left.
    #[error("no worker of stage {stage} is left")]
    NoWorker {
        /// Stage.
        stage: StageKind,
    },
    /// The transport failed.
    #[error("{0}")]
    Transport(String),
}
