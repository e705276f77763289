//! Third step of the paper (Sec. III-D): roadmaps of single robots, other robots ignored.
//!
//! A *piece* knows fixed objects only: a base roadmap (the base drives with the arm folded), or an arm piece at one stand.
//! A *mode roadmap* glues pieces; poses that are certainly present have removed edges, possible ones annotate them.
//! Kavraki et al., Probabilistic roadmaps, doi:10.1109/70.508439.

mod arm;
mod base;
mod blocked;
mod bridge;
mod connect;
mod glue;
mod graph;
mod no_way;
mod retreat;

use std::collections::BTreeMap;
use std::sync::Mutex;

use collision::{Geometry, GeometryError};
use contract::{
    Answer, FailureReport, Interrupted, Job, JobContext, ModeJob, Outcome, PieceJob, PieceSpec, ProblemStatement,
    Product, Request, Stage,
};
use kinematics::ArmSolver;
use model::PairId;
use plan::{Certificate, PairEnd};

use blocked::BlockedMotions;

/// The roadmap stage.
pub struct RoadmapStage {
    geometry: Geometry,
    solvers: Vec<ArmSolver>,
    seed: u64,
    /// Blocked or free, by motion: a memo of continuous tests against fixed objects.
    free: Mutex<BTreeMap<Vec<u8>, bool>>,
    /// Motions that standing objects block.
    blocked: BlockedMotions,
    /// For each end of a pair to which no way was found, whether it can be proven that there is none.
    proofs: Mutex<BTreeMap<(PairId, PairEnd), Option<Certificate>>>,
}

impl RoadmapStage {
    /// The stage for one statement.
    ///
    /// # Errors
    /// When a shape of the problem is degenerate.
    pub fn new(statement: &ProblemStatement) -> Result<Self, GeometryError> {
        let geometry = Geometry::new(&statement.problem)?;
        let solvers = statement.problem.robots.iter().map(ArmSolver::for_robot).collect();
        Ok(Self {
            geometry,
            solvers,
            seed: statement.seed,
            free: Mutex::default(),
            blocked: BlockedMotions::default(),
            proofs: Mutex::default(),
        })
    }

    fn piece(&self, job: &PieceJob, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let made = match &job.spec {
            PieceSpec::Base => base::base_piece(&self.geometry, self.seed, job, context)?,
            PieceSpec::Arm { .. } => arm::arm_piece(self, job, context)?,
        };
        match made {
            Ok(piece) => {
                let product = context.publish(&Product::Piece(piece))?;
                Ok(Outcome::answer(Answer::Piece(product), context.spent()))
            }
            Err(causes) => Ok(Outcome::soft_failure(causes, job.level, context.spent())),
        }
    }

    fn mode(&self, job: &ModeJob, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        match glue::glue(self, job, context)? {
            Ok(glued) => {
                let roadmap = context.publish(&Product::Mode(glued.roadmap))?;
                let (shortest_s, in_the_way) = (glued.shortest_s, glued.in_the_way);
                Ok(Outcome::answer(Answer::Mode { roadmap, shortest_s, in_the_way }, context.spent()))
            }
            Err(no_way) => Ok(match self.proof(job) {
                Some(certificate) => Outcome::infeasible(no_way.causes, certificate, context.spent()),
                None => {
                    let report = FailureReport::soft(no_way.causes, job.level).resting_on(no_way.rests_on);
                    Outcome { result: Err(report), work: context.spent() }
                }
            }),
        }
    }

    /// A proof that the base cannot get to where a mode ends, whatever the stand there.
    fn proof(&self, job: &ModeJob) -> Option<Certificate> {
        let (robot, step) = (job.mode.robot, job.mode.step as usize);
        let pair = self.geometry.problem().pairs_of_robot(robot).nth(step / 2)?;
        let end = if step % 2 == 0 { PairEnd::Pick } else { PairEnd::Place };
        if let Some(known) = self.proofs.lock().ok().and_then(|memo| memo.get(&(pair, end)).cloned()) {
            return known;
        }
        let proof = self.geometry.prove_no_drive(pair, end);
        if let Ok(mut memo) = self.proofs.lock() {
            memo.insert((pair, end), proof.clone());
        }
        proof
    }
}

impl Stage for RoadmapStage {
    fn refine(&self, job: &Job, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let robots = self.geometry.problem().robots.len();
        if job.robot().is_none_or(|robot| robot.index() >= robots) {
            return Err(Interrupted::Unfit("not a job about a robot of the problem".to_owned()));
        }
        match &job.request {
            Request::Piece(job) => self.piece(job, context),
            Request::Mode(job) => self.mode(job, context),
            _ => Err(Interrupted::Unfit("not a job of the roadmap stage".to_owned())),
        }
    }
}
