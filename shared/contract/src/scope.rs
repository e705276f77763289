//! The part of the problem that each kind of job reads. A change elsewhere leaves the job's identity as it is.

use model::{ObjectId, Problem, RobotId};

use crate::{Digest, Request, encode_canonical};

pub(crate) fn scope_digest(problem: &Problem, request: &Request) -> Digest {
    match request {
        Request::Placement(_) => placement(problem),
        Request::Transition(job) => {
            let pair = problem.pair(job.pair);
            one_robot(problem, pair.robot, Some(pair.object))
        }
        Request::Blockers(job) => one_robot(problem, job.robot, Some(job.holding.object)),
        Request::Piece(job) => one_robot(problem, job.robot, job.holding.map(|holding| holding.object)),
        // Glued and composite roadmaps meet many objects.
        Request::Mode(_) | Request::Compose(_) => whole(problem),
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
    Digest::of(
        "mrtamp scope robot",
        &[
            &encode_canonical(problem.robot(robot)),
            &encode_canonical(&(&problem.fixed, &problem.regions, object)),
            &encode_canonical(&(&problem.pairs, &problem.settings, &problem.levels)),
        ],
    )
}

fn whole(problem: &Problem) -> Digest {
    Digest::of("mrtamp scope whole", &[&encode_canonical(problem)])
}
