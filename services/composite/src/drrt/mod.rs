//! Multi-modal dRRT* (paper Sec. III-E): the composite step as one search over all robots and modes at once.
//!
//! Each robot moves on the glued, reversible roadmaps of its modes. A composite state has the mode and the vertex of every
//! robot; the modes alone tell which objects stand where and whose event may happen. Robots travel an edge, stay, or have
//! their event, in steps that begin together; the clock of such a step is its slowest robot's, and the retiming of the
//! finished plan takes those waits out again. The paper's search keeps one mode vector and never goes back; here every
//! state ever reached can grow.
//!
//! Probabilistically complete on the given roadmaps. Small products are searched through where chance finds no way: their
//! "no" is definite for these roadmaps.

mod compose;
mod composite_roadmap;
mod connect;
mod cooperative;
mod exhaust;
mod failure;
mod geometric;
mod job;
mod meter;
mod mode_graph;
mod mode_vector;
mod oracle;
mod phase;
mod polish;
mod queue;
mod rules;
mod schedule;
mod search;
mod select;
mod start;
mod tree;
mod validity;

use contract::{
    Assignment, Commitment, FailureReport, Interrupted, JobContext, ModeRoadmap, ProblemStatement, RandomStream,
    StageKind, VertexId,
};
use skeleton::Skeleton;

pub use job::refine;
pub use validity::{CompositeValidity, RobotEdge, TimedEdge};

use composite_roadmap::CompositeRoadmap;
use exhaust::Exhausted;
use geometric::Geometric;
use meter::Meter;
use polish::Way;
use search::Search;
use start::Start;

use crate::Conflicts;

/// Products of no more composite vertices than this are searched systematically when chance has not found a way.
const SMALL: f64 = 200_000.0;

/// Composite motion for all that is left after `done`, by the stage's conflict relation; see [`drrt_with`].
///
/// # Errors
/// [`Interrupted`].
pub fn drrt(
    statement: &ProblemStatement,
    skeleton: &Skeleton,
    assignment: &Assignment,
    done: &[Commitment],
    roadmaps: &[Vec<ModeRoadmap>],
    conflicts: &Conflicts,
    context: &mut JobContext<'_>,
) -> Result<Result<Vec<Commitment>, FailureReport>, Interrupted> {
    drrt_with(statement, skeleton, done, roadmaps, &Geometric { conflicts, assignment }, context)
}

/// Composite motion for all that is left after `done`, geometry asked through `validity`.
///
/// `skeleton.graph` holds all orderings, `roadmaps[robot][mode]` every mode's glued roadmap. The commitments are those of
/// the modes after `done`, in order of their events, without tails. One work unit is one expansion.
///
/// # Errors
/// [`Interrupted`]: cancelled, or the roadmaps or the prefix do not belong to the problem.
pub fn drrt_with<V: CompositeValidity>(
    statement: &ProblemStatement,
    skeleton: &Skeleton,
    done: &[Commitment],
    roadmaps: &[Vec<ModeRoadmap>],
    validity: &V,
    context: &mut JobContext<'_>,
) -> Result<Result<Vec<Commitment>, FailureReport>, Interrupted> {
    let problem = &statement.problem;
    let mut roadmap = CompositeRoadmap::new(problem, skeleton, roadmaps)?;
    let start = Start::after(done, &roadmap)?;
    let finished = start.robots.iter().enumerate().filter(|(_, robot)| robot.is_done);
    finished.for_each(|(robot, _)| roadmap.pin(robot));
    let names: Vec<&str> = problem.robots.iter().map(|robot| robot.name.as_str()).collect();
    let random = RandomStream::new(statement.seed, StageKind::Composite, &names, "drrt");
    let is_small = roadmap.size() <= SMALL;
    // A product that can be searched through is not worth more chance than that takes.
    let limit = if is_small { (roadmap.size() as u64).min(context.left() / 2) } else { u64::MAX };
    let root: Vec<(u32, VertexId)> = start.robots.iter().map(|robot| (robot.phase, robot.vertex)).collect();
    let mut search = Search::new(&roadmap, validity, &root, random);
    search.run(&mut Meter::new(context, limit))?;
    let root = search.tree.get(0).state.clone();
    let steps = match search.solution {
        Some(solution) => search.tree.path_to(solution),
        None if is_small => match exhaust::exhaust(&mut search.rules, &root, context)? {
            Exhausted::Found(steps) => steps,
            Exhausted::NoWay => return Ok(Err(search.failure(true))),
            Exhausted::Budget => return Ok(Err(search.failure(false))),
        },
        None => return Ok(Err(search.failure(false))),
    };
    let way = Way::new(&mut search.rules, root, steps).polish(&mut search.rules, context)?;
    Ok(Ok(schedule::commitments(&mut search.rules, &start, &way)))
}

#[cfg(test)]
mod tests;
