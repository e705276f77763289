//! One robot's unit in a round, by safe-interval search among those that idle and those planned before it.

use contract::{Commitment, EdgeKind, JobContext, Move};
use skeleton::ModeId;

use super::evasion::Leg;
use super::rounds::spend;
use super::sequence::Stop;
use super::team::{Team, TeamMode};
use crate::commit::{GAP_S, INSTANT_S, Mover};
use crate::sipp::{Blocker, Gates, Search, State, Step, Traffic};
use crate::timeline::approach_s;
use crate::{Scene, TimedMove, TimedStanding};

/// Who and what else is there in a round. Times count from its beginning.
#[derive(Clone)]
pub(super) struct Around {
    /// Motion of every robot for all time; none of one that is not planned yet.
    pub robots: Vec<Vec<TimedMove>>,
    /// Objects.
    pub standings: Vec<TimedStanding>,
}

/// A robot's part in a round. Times count from the round's beginning.
#[derive(Clone, Debug)]
pub(super) struct Unit {
    pub mode: ModeId,
    pub path: Vec<Step>,
    /// When its event happens, or the robot stands (s).
    pub event_s: f64,
    /// When the hand's pause after the event is over (s).
    pub ends_s: f64,
}

/// A unit with what later ones must keep clear of.
pub(super) struct PlannedUnit {
    pub unit: Unit,
    /// Motion, and standing for ever behind it.
    pub moves: Vec<TimedMove>,
    /// The object that it puts down.
    pub placed: Option<TimedStanding>,
}

/// The next unit of a robot.
pub(super) struct UnitJob<'a> {
    pub team: &'a Team<'a>,
    pub robot: usize,
    pub done: &'a [u32],
    pub around: &'a Around,
    /// What it has done already to make room.
    pub leg: Option<&'a Leg>,
}

impl UnitJob<'_> {
    /// The unit that is over first, with the robot standing where it ends for as long as the round may last; or who is in
    /// the way.
    pub fn plan(&self, context: &mut JobContext<'_>) -> Result<Result<PlannedUnit, Vec<Blocker>>, Stop> {
        let Some(next) = self.team.next(self.robot, self.done) else { return Ok(Err(Vec::new())) };
        let traffic = self.traffic(0.0);
        let mut gates = Gates::OPEN;
        let placed = self.team.scene.placed(self.team.assignment, &next.mode)?;
        if let Some((ends_s, robot)) = placed.and_then(|placed| traffic.last_through(&placed)) {
            if ends_s == f64::INFINITY {
                return Ok(Err(vec![Blocker::Robot(robot)]));
            }
            gates.goal_s = ends_s + GAP_S;
        }
        let (graph, conflicts) = (&next.graph, &self.team.scene.conflicts);
        let start = self.leg.map_or((graph.roadmap.start, 0.0, 0.0), |leg| (leg.vertex, leg.ends_s, leg.ends_s));
        let mut search = Search::new(graph, &traffic, conflicts, gates, next.to_goal_s.clone(), start);
        let mut in_the_way = Vec::new();
        while let Some(index) = search.next() {
            spend(context)?;
            let state = search.state(index);
            if state.vertex != graph.roadmap.goal {
                continue;
            }
            let interval = search.interval(&state);
            let before = self.leg.map_or(&[][..], |leg| &leg.path);
            let unit = unit(next, [before, &search.path(index)].concat(), &state, &gates);
            if next.mode.ends.is_none() {
                if interval.until_s == f64::INFINITY {
                    return Ok(Ok(self.planned(next, unit)?));
                }
            } else if interval.contains(unit.event_s) {
                match self.blockers_after(next, unit.event_s)? {
                    None => return Ok(Ok(self.planned(next, unit)?)),
                    Some(blockers) => in_the_way.extend(blockers),
                }
            }
        }
        in_the_way.extend(traffic.blamed());
        Ok(Err(in_the_way))
    }

    fn traffic(&self, since_s: f64) -> Traffic<'_> {
        let robots = self.around.robots.iter().enumerate().filter(|(robot, _)| *robot != self.robot);
        let others = robots.map(|(_, moves)| moves.as_slice()).collect();
        Traffic::among(&self.team.scene.conflicts, others, self.around.standings.clone(), since_s)
    }

    /// Who keeps the robot from standing where its event happened, from then on for ever; `None`: nobody.
    fn blockers_after(&self, next: &TeamMode<'_>, event_s: f64) -> Result<Option<Vec<Blocker>>, Stop> {
        let mut traffic = self.traffic(event_s);
        if let Some(placed) = self.team.scene.placed(self.team.assignment, &next.mode)? {
            traffic.put(placed, event_s);
        }
        let stand = self.team.stand(self.robot, self.done[self.robot] + 1);
        let intervals = traffic.safe_intervals(&stand);
        let stays = intervals.iter().any(|safe| safe.contains(event_s) && safe.until_s == f64::INFINITY);
        Ok(if stays { None } else { Some(traffic.blamed()) })
    }

    fn planned(&self, next: &TeamMode<'_>, unit: Unit) -> Result<PlannedUnit, Stop> {
        let scene = self.team.scene;
        let start = next.graph.vertex(next.graph.roadmap.start).clone();
        let commitment = next.commitment(&unit, 0.0, Mover::new(start, 0.0));
        let mut moves = timed_moves(scene, next, &commitment.moves);
        let travel = self.team.stand(self.robot, self.done[self.robot] + 1);
        moves.push(TimedMove { travel, begins_s: commitment.event_s, ends_s: f64::INFINITY });
        let standing = self.team.scene.placed(self.team.assignment, &next.mode)?;
        let from_s = approach_s(scene, &commitment);
        let placed = standing.map(|standing| TimedStanding { standing, from_s, until_s: f64::INFINITY });
        Ok(PlannedUnit { unit, moves, placed })
    }
}

/// The moves of a mode that take time.
pub(super) fn timed_moves(scene: &Scene, of: &TeamMode<'_>, moves: &[Move]) -> Vec<TimedMove> {
    let moving = moves.iter().filter(|step| step.ends_s > step.begins_s);
    moving.map(|step| TimedMove::new(scene, of.mode.id.robot, of.graph.roadmap.holding, step)).collect()
}

fn unit(next: &TeamMode<'_>, path: Vec<Step>, state: &State, gates: &Gates) -> Unit {
    // An event where the robot is already comes strictly after what it waits for.
    let at_once = path.is_empty() && next.mode.ends.is_some();
    let event_s = if at_once { state.time_s.max(gates.goal_s) + INSTANT_S } else { state.time_s };
    Unit { mode: next.mode.id, path, event_s, ends_s: event_s + next.pause_s }
}

impl TeamMode<'_> {
    /// A unit as commitment, in a round that begins at `begins_s` (s). `mover` is where and when the robot's unit before
    /// it ended; until the round it stands there.
    pub fn commitment(&self, unit: &Unit, begins_s: f64, mut mover: Mover) -> Commitment {
        let graph = &self.graph;
        let (start, holding) = (graph.allowed_at(graph.roadmap.start), graph.roadmap.holding);
        mover.stand(begins_s, EdgeKind::Arm, start);
        let later = |step: &Step| {
            let (departs_s, arrives_s) = (step.departs_s + begins_s, step.arrives_s + begins_s);
            Step { hop: step.hop, departs_s, arrives_s }
        };
        mover.follow(graph, &unit.path.iter().map(later).collect::<Vec<_>>());
        if unit.path.is_empty() && self.mode.ends.is_some() {
            let event_s = begins_s + unit.event_s;
            mover.stand(event_s - INSTANT_S, EdgeKind::Arm, start);
            mover.stand(event_s, EdgeKind::Arm, start);
        }
        let (moves, event_s) = (mover.moves, mover.time_s);
        Commitment { mode: unit.mode, holding, moves, event_s, tail: Vec::new(), tail_holding: holding }
    }
}
