//! Local coupled repair: some robots together, until a mode that could not be committed alone has had its event.
//!
//! As in ARC (Solis, Motes, Amato, adaptive robot coordination), the conflict is solved as a problem of the robots that take
//! part in it, from states in which everybody stands; all others stay where they are. First those in the way only make room
//! within their modes; if that is not enough, they may have events of their own.

use contract::{Commitment, FailureReport, Interrupted, JobContext, ModeRoadmap, ProblemStatement, RandomStream};
use contract::{StageKind, Tail};
use model::RobotId;
use skeleton::{ModeId, Skeleton};

use super::composite_roadmap::{CompositeRoadmap, Passed};
use super::schedule::{self, Scheduled};
use super::seek;
use super::start::Start;
use super::validity::CompositeValidity;
use crate::CommittedMotion;

/// Who shall get what done.
#[derive(Clone, Copy, Debug)]
pub struct Together<'a> {
    /// The mode whose event is wanted (or that has to be over, if it is a closing return): its robot's next.
    pub mode: ModeId,
    /// Who may move.
    pub robots: &'a [RobotId],
}

/// Motion that a repair adds. Each robot rests at its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Repaired {
    /// The modes that ended, in order of their events.
    pub commitments: Vec<Commitment>,
    /// Tails of robots that moved, new ones of those that had an event included.
    pub tails: Vec<Tail>,
}

/// Motion after `done`, begun when everybody rests, until the mode is done; otherwise as
/// [`drrt_with`](super::drrt_with).
///
/// # Errors
/// [`Interrupted`]: cancelled, or roadmaps, prefix or mode do not belong to the problem.
pub fn repair_with<V: CompositeValidity>(
    statement: &ProblemStatement,
    skeleton: &Skeleton,
    done: &CommittedMotion,
    roadmaps: &[Vec<ModeRoadmap>],
    together: Together<'_>,
    validity: &V,
    context: &mut JobContext<'_>,
) -> Result<Result<Repaired, FailureReport>, Interrupted> {
    let problem = &statement.problem;
    let whole = CompositeRoadmap::new(problem, skeleton, roadmaps)?;
    let start = Start::at_rest(done, &whole)?;
    let aim = aim(&whole, &start, together)?;
    let names: Vec<&str> =
        together.robots.iter().filter_map(|robot| problem.robots.get(robot.index())).map(|r| r.name.as_str()).collect();
    let moves = |robot: usize| !start.robots[robot].is_done && together.robots.contains(&RobotId::at(robot));
    // Those who have nothing left but to return do it together: who is at home first may be in the way of the others.
    let is_last = |robot: usize| start.robots[robot].phase as usize + 1 == whole.robots[robot].phases.len();
    let return_together = is_last(aim.robot) && (0..start.robots.len()).all(|robot| !moves(robot) || is_last(robot));
    let making_room = (together.robots.len() > 1 && !return_together).then_some(true);
    for only_makes_room in making_room.into_iter().chain([false]) {
        let mut roadmap = whole.clone();
        if !return_together {
            roadmap.aim_at(aim.robot, aim.phase);
        }
        for (robot, at) in start.robots.iter().enumerate() {
            if !moves(robot) {
                roadmap.pin(robot, at.phase, at.vertex);
            } else if only_makes_room && robot != aim.robot {
                roadmap.keep_in(robot, at.phase, at.vertex);
            }
        }
        let random = RandomStream::new(statement.seed, StageKind::Composite, &names, "repair");
        let limit = if only_makes_room { context.left() / 2 } else { context.left() };
        match seek(&roadmap, &start, validity, random, limit, context)? {
            Ok(mut found) => {
                let Scheduled { commitments, tails } = schedule::schedule(&mut found.rules, &start, &found.way, moves);
                return Ok(Ok(Repaired { commitments, tails }));
            }
            Err(report) if !only_makes_room => return Ok(Err(report)),
            Err(_) => {}
        }
    }
    Err(Interrupted::Unfit("a repair of no robots".to_owned()))
}

/// The end of the mode, which must be its robot's next.
fn aim(roadmap: &CompositeRoadmap<'_>, start: &Start, together: Together<'_>) -> Result<Passed, Interrupted> {
    let Together { mode, robots } = together;
    let robot = mode.robot.index();
    if !robots.contains(&mode.robot) {
        return Err(Interrupted::Unfit("a repair without the robot whose mode it is".to_owned()));
    }
    let next = start.robots.get(robot).filter(|at| !at.is_done).map(|at| roadmap.phase(robot, at.phase).mode);
    if next != Some(mode.step as usize) {
        return Err(Interrupted::Unfit(format!("mode {mode:?} is not its robot's next")));
    }
    let last = roadmap.robots[robot].phases.iter().rposition(|phase| phase.mode == mode.step as usize);
    Ok(Passed { robot, phase: last.unwrap_or_default() as u32 })
}
