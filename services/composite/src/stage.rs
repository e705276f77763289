//! The stage: answers composite jobs.

use contract::{Composition, Interrupted, Job, JobContext, Outcome, ProblemStatement, Request, Stage};

use crate::assemble::AssembleJob;
use crate::commit::CommitJob;
use crate::passages::PassagesJob;
use crate::repair::RepairJob;
use crate::synchronous::SynchronousJob;
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
        let (scene, assignment) = (&self.scene, &compose.assignment);
        match &compose.composition {
            Composition::CommitMode { prefix, mode, roadmap, next_roadmap, clear_of } => {
                let (prefix, mode, roadmap, next_roadmap) = (*prefix, *mode, *roadmap, *next_roadmap);
                CommitJob { scene, assignment, prefix, mode, roadmap, next_roadmap, clear_of }.answer(context)
            }
            Composition::Repair { prefix, mode, robots, roadmaps } => {
                RepairJob { scene, assignment, prefix: *prefix, mode: *mode, robots, roadmaps }.answer(context)
            }
            Composition::Passages { roadmaps } => PassagesJob { scene, assignment, roadmaps }.answer(context),
            Composition::Drrt { prefix, roadmaps } => drrt::refine(scene, assignment, *prefix, roadmaps, context),
            Composition::Assemble { prefix, shortest_s, rounds } => {
                AssembleJob { scene, assignment, prefix: *prefix, shortest_s, rounds }.answer(context)
            }
            Composition::Synchronous { choice, roadmaps } => {
                SynchronousJob { scene, assignment, choice: *choice, roadmaps }.answer(context)
            }
        }
    }
}
