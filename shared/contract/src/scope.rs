//! The part of the problem that each kind of job reads. A change elsewhere leaves the job's identity as it is.

use model::{ObjectId, PairId, Problem, RobotId};

use crate::{Digest, Request, encode_canonical};

/// Which part of the problem a job reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Scope {
    /// Objects, regions and pairs.
    Placement,
    /// One robot, what never moves of the others, and the object that it handles.
    Robot(RobotId, Option<ObjectId>),
    /// Everything.
    Whole,
}

impl Scope {
    /// What a request reads. `None`: it names a pair, robot or object that the problem does not have.
    pub(crate) fn of(problem: &Problem, request: &Request) -> Option<Self> {
        let scope = match request {
            Request::Placement(_) | Request::Hop(_) | Request::Samples(_) => Self::Placement,
            Request::Transition(job) => Self::of_pair(problem, job.pair)?,
            Request::Blockers(job) => Self::Robot(job.robot, Some(job.holding.object)),
            Request::Piece(job) => Self::Robot(job.robot, job.holding.map(|holding| holding.object)),
            // Glued and composite roadmaps meet many objects, and so does a hand among samples.
            Request::Mode(_) | Request::Compose(_) | Request::GraspBlockers(_) => Self::Whole,
        };
        scope.exists_in(problem).then_some(scope)
    }

    fn of_pair(problem: &Problem, pair: PairId) -> Option<Self> {
        let pair = problem.pairs.get(pair.index())?;
        Some(Self::Robot(pair.robot, Some(pair.object)))
    }

    fn exists_in(self, problem: &Problem) -> bool {
        match self {
            Self::Placement | Self::Whole => true,
            Self::Robot(robot, object) => {
                robot.index() < problem.robots.len()
                    && object.is_none_or(|object| object.index() < problem.movable.len())
            }
        }
    }

    /// Digest of what is read; the scope must exist in the problem.
    pub(crate) fn digest(self, problem: &Problem) -> Digest {
        match self {
            Self::Placement => placement(problem),
            Self::Robot(robot, object) => one_robot(problem, robot, object),
            Self::Whole => Digest::of("mrtamp scope whole", &[&encode_canonical(problem)]),
        }
    }
}

fn placement(problem: &Problem) -> Digest {
    let bodies: Vec<_> =
        problem.movable.iter().map(|m| (&m.name, &m.body, &m.world_from_start, m.start_support)).collect();
    Digest::of(
        "mrtamp scope placement",
        &[
            &encode_canonical(&(&problem.fixed, bodies, &problem.regions)),
            &encode_canonical(&(&problem.pairs, &problem.orderings, &problem.settings, &problem.levels)),
        ],
    )
}

fn one_robot(problem: &Problem, robot: RobotId, object: Option<ObjectId>) -> Digest {
    let object = object.map(|object| &problem.movable[object.index()]);
    let is_idle = |id: &RobotId| problem.pairs_of_robot(*id).next().is_none();
    let others = problem.robot_ids().filter(|id| *id != robot);
    let steady: Vec<_> =
        others.map(|id| (id, problem.robot(id))).filter(|(id, r)| is_idle(id) || r.base.is_none()).collect();
    Digest::of(
        "mrtamp scope robot",
        &[
            &encode_canonical(&(problem.robot(robot), steady)),
            &encode_canonical(&(&problem.fixed, &problem.regions, object)),
            &encode_canonical(&(&problem.pairs, &problem.settings, &problem.levels)),
        ],
    )
}
