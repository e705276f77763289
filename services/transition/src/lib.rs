//! Second step of the paper (Sec. III-C): grasps and transition configurations.
//!
//! For one pair and the poses at its two ends the stage finds alternatives: one grasp, and at each end a stand of the base,
//! an arm configuration and the hand's short straight ways off. Only the robot itself and fixed objects are obstacles, and
//! only configurations are tested, no edges: `Request::Blockers` tells afterwards which standing objects are in the way.

mod alternatives;
mod ends;
mod reach;
mod stand;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use alternatives::Found;
use collision::{Geometry, GeometryError, Motion};
use contract::{
    Answer, BlockersJob, FailureReport, Interrupted, Job, JobContext, Outcome, ProblemStatement, Request, Stage,
    TransitionJob,
};
use ends::Reached;
use kinematics::ArmSolver;
use model::{AllowedContacts, Configuration, PairId, RobotId};
use plan::Certificate;

/// The transition stage.
pub struct TransitionStage {
    geometry: Geometry,
    solvers: Vec<ArmSolver>,
    seed: u64,
    found: Memo<Found>,
    reached: Memo<Reached>,
    /// For each pair that failed, whether it can be proven to be impossible.
    proofs: Mutex<BTreeMap<PairId, Option<Certificate>>>,
}

/// Entries of a memo beyond which it begins anew.
const MOST_REMEMBERED: usize = 4096;

/// What was found out, by what it depends on.
type Memo<T> = Mutex<BTreeMap<Vec<u8>, Arc<T>>>;

fn remember<T>(memo: &Memo<T>, key: Vec<u8>, value: &Arc<T>) {
    if let Ok(mut memo) = memo.lock() {
        if memo.len() >= MOST_REMEMBERED {
            memo.clear();
        }
        memo.insert(key, value.clone());
    }
}

impl TransitionStage {
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
            found: Memo::default(),
            reached: Memo::default(),
            proofs: Mutex::default(),
        })
    }

    fn solver(&self, robot: RobotId) -> &ArmSolver {
        &self.solvers[robot.index()]
    }

    fn transition(&self, job: &TransitionJob, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        if job.pair.index() >= self.geometry.problem().pairs.len() {
            return Err(Interrupted::Unfit(format!("no pair {}", job.pair.0)));
        }
        let found = self.found(job, context)?;
        if found.combinations.is_empty() {
            let causes = found.causes.clone();
            return Ok(match self.proof(job.pair) {
                Some(certificate) => Outcome::infeasible(causes, certificate, found.work),
                None => {
                    let report = FailureReport::soft(causes, job.level);
                    Outcome {
                        result: Err(FailureReport { rests_on: found.rests_on.clone(), ..report }),
                        work: found.work,
                    }
                }
            });
        }
        Ok(Outcome::answer(Answer::Alternatives(found.alternatives(job.first, job.count)), found.work))
    }

    fn found(&self, job: &TransitionJob, context: &mut JobContext<'_>) -> Result<Arc<Found>, Interrupted> {
        // What a budget cuts short is the answer for that budget alone.
        let ends = (job.world_from_pick, job.world_from_place);
        let key = contract::encode_canonical(&(job.pair, ends, job.level, context.left()));
        if let Some(found) = self.found.lock().ok().and_then(|memo| memo.get(&key).cloned()) {
            return Ok(found);
        }
        let found = Arc::new(self.find(job, context)?);
        remember(&self.found, key, &found);
        Ok(found)
    }

    /// A proof that a pair is impossible wherever its object stands, if there is one.
    fn proof(&self, pair: PairId) -> Option<Certificate> {
        if let Some(known) = self.proofs.lock().ok().and_then(|memo| memo.get(&pair).cloned()) {
            return known;
        }
        let proof = self.geometry.prove_no_transition(pair);
        if let Ok(mut memo) = self.proofs.lock() {
            memo.insert(pair, proof.clone());
        }
        proof
    }

    fn blockers(&self, job: &BlockersJob) -> Outcome {
        let approach = ways(job.robot, None, &job.reach.approach, |_| AllowedContacts {
            touch: Some(job.holding.object),
            support: None,
        });
        let lift = ways(job.robot, Some(job.holding), &job.reach.lift, |i| AllowedContacts {
            touch: None,
            support: (i < job.reach.lift_up as usize).then_some(job.reach.support),
        });
        let motions: Vec<Motion> = approach.into_iter().chain(lift).collect();
        let blocked = job
            .standing
            .iter()
            .map(|standing| motions.iter().any(|motion| self.geometry.motion_hits(motion, standing).is_some()))
            .collect();
        Outcome::answer(Answer::Blocked(blocked), (motions.len() * job.standing.len()) as u64)
    }
}

/// Motions along a way of configurations.
fn ways(
    robot: RobotId,
    holding: Option<model::Holding>,
    way: &[Configuration],
    allowed: impl Fn(usize) -> AllowedContacts,
) -> Vec<Motion> {
    way.windows(2)
        .enumerate()
        .map(|(i, step)| Motion { robot, holding, from: step[0].clone(), to: step[1].clone(), allowed: allowed(i) })
        .collect()
}

impl Stage for TransitionStage {
    fn refine(&self, job: &Job, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        match &job.request {
            Request::Transition(job) => self.transition(job, context),
            Request::Blockers(job) => Ok(self.blockers(job)),
            Request::GraspBlockers(job) => self.grasp_blockers(job, context),
            _ => Err(Interrupted::Unfit("not a job of the transition stage".to_owned())),
        }
    }
}
