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
mod repair;
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

pub(crate) use geometric::Geometric;
pub use job::refine;
pub(crate) use job::{check_holdings, load_roadmap};
pub use repair::{Repaired, Together, repair_with};
pub use validity::{CompositeValidity, RobotEdge, TimedEdge};

use composite_roadmap::CompositeRoadmap;
use exhaust::Exhausted;
use meter::Meter;
use polish::Way;
use rules::Rules;
use search::Search;
use start::{RobotStart, Start};

use crate::{CommittedMotion, Conflicts};

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
    done: &CommittedMotion,
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
    done: &CommittedMotion,
    roadmaps: &[Vec<ModeRoadmap>],
    validity: &V,
    context: &mut JobContext<'_>,
) -> Result<Result<Vec<Commitment>, FailureReport>, Interrupted> {
    let problem = &statement.problem;
    let mut roadmap = CompositeRoadmap::new(problem, skeleton, roadmaps)?;
    let start = Start::after(done, &roadmap)?;
    for (robot, RobotStart { phase, vertex, .. }) in start.robots.iter().enumerate().filter(|(_, robot)| robot.is_done)
    {
        roadmap.pin(robot, *phase, *vertex);
    }
    let names: Vec<&str> = problem.robots.iter().map(|robot| robot.name.as_str()).collect();
    let random = RandomStream::new(statement.seed, StageKind::Composite, &names, "drrt");
    let found = seek(&roadmap, &start, validity, random, u64::MAX, context)?;
    let moves = |robot: usize| !start.robots[robot].is_done;
    Ok(found.map(|mut found| schedule::schedule(&mut found.rules, &start, &found.way, moves).commitments))
}

/// A way, and the rules that it keeps.
struct Sought<'a, V> {
    rules: Rules<'a, V>,
    way: Way,
}

/// A way from the start to the roadmap's aim, for at most `limit` work units.
fn seek<'a, V: CompositeValidity>(
    roadmap: &'a CompositeRoadmap<'a>,
    start: &Start,
    validity: &'a V,
    random: RandomStream,
    limit: u64,
    context: &mut JobContext<'_>,
) -> Result<Result<Sought<'a, V>, FailureReport>, Interrupted> {
    let size = roadmap.size(start.robots.iter().map(|robot| robot.phase));
    let is_small = size <= SMALL;
    let limit = limit.min(context.left());
    // A product that can be searched through is not worth more chance than that takes.
    let by_chance = if is_small { (size as u64).min(limit / 2) } else { limit };
    let root: Vec<(u32, VertexId)> = start.robots.iter().map(|robot| (robot.phase, robot.vertex)).collect();
    let mut search = Search::new(roadmap, validity, &root, random);
    let mut meter = Meter::new(context, by_chance);
    search.run(&mut meter)?;
    let left = limit.saturating_sub(meter.spent());
    let root = search.tree.get(0).state.clone();
    let steps = match search.solution {
        Some(solution) => search.tree.path_to(solution),
        None if is_small => match exhaust::exhaust(&mut search.rules, &root, &mut Meter::new(context, left))? {
            Exhausted::Found(steps) => steps,
            Exhausted::NoWay => return Ok(Err(search.failure(true))),
            Exhausted::Budget => return Ok(Err(search.failure(false))),
        },
        None => return Ok(Err(search.failure(false))),
    };
    let way = Way::new(&mut search.rules, root, steps).polish(&mut search.rules, context)?;
    Ok(Ok(Sought { rules: search.rules, way }))
}

#[cfg(test)]
mod tests;
