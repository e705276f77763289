//! The stage: answers composite jobs.

use contract::{Composition, Interrupted, Job, JobContext, Outcome, ProblemStatement, Request, Stage};

use crate::{CompositeError, Scene, drrt};

/// The paper's fourth step.
pub struct CompositeStage {
    scene: Scene,
}

impl CompositeStage {
    /// A stage for one problem.
    ///
    /// # Errors
    /// [`CompositeError`].
    pub fn new(statement: &ProblemStatement) -> Result<Self, CompositeError> {
        Ok(Self { scene: Scene::new(statement)? })
    }
}

impl Stage for CompositeStage {
    fn refine(&self, job: &Job, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let Request::Compose(compose) = &job.request else {
            return Err(Interrupted::Unfit(format!("a job of stage {} came to composite", job.stage())));
        };
        self.scene.conflicts.forget_if_large();
        match &compose.composition {
            Composition::Drrt { prefix, roadmaps } => {
                drrt::refine(&self.scene, &compose.assignment, *prefix, roadmaps, context)
            }
            Composition::CommitMode { .. } | Composition::Assemble { .. } => {
                Err(Interrupted::Unfit("not written yet".into()))
            }
        }
    }
}
