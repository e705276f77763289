//! From orderings to gates: before when a mode may not do what.
//!
//! An ordering `X ≺ Y` gates the mode in which Y happens: on `grasp` and `release` its goal; on `done`, `start` and `carry`
//! the folding of the arm after the event that begins it; on `at_pick` and `at_place` the coming to the goal's stand (or
//! the folding, where the robot is there from the start). X must be committed. If X is `carry`, `done` or `start` and only
//! the tail of the event before it is committed, the tail's time counts, and the tail up to there is then frozen: the
//! robot's next commitment begins with it.

use contract::Move;
use model::{PairId, Point, RobotId};
use skeleton::{ArcOrigin, Event, EventGraph, Mode, ModeId, ModeKind};

use crate::points::{arrival_len, end_of, retract_len};
use crate::sipp::Gates;
use crate::{Scene, Timeline};

/// Orderings and times of one job.
pub(crate) struct Orders<'a> {
    pub scene: &'a Scene,
    pub graph: &'a EventGraph,
    pub timeline: &'a Timeline,
}

impl Orders<'_> {
    /// The gates of a mode, or the robots whose events must be committed before.
    pub fn gates(&self, mode: &Mode) -> Result<Gates, Vec<RobotId>> {
        let mut gates = Gates::OPEN;
        let after = mode.begins.map(|event| event.pair);
        match (mode.kind, mode.pair) {
            (ModeKind::Transfer, Some(pair)) => {
                gates.fold_s = self.latest(&[Event::new(pair, Point::Carry)], mode)?;
                gates.arrive_s = self.latest(&[Event::new(pair, Point::AtPlace)], mode)?;
                gates.goal_s = self.latest(&[Event::release(pair)], mode)?;
            }
            (_, pair) => {
                let done = after.map(|pair| Event::new(pair, Point::Done));
                let start = pair.map(|pair| Event::new(pair, Point::Start));
                gates.fold_s = self.latest(&[done, start].into_iter().flatten().collect::<Vec<_>>(), mode)?;
                if let Some(pair) = pair {
                    gates.arrive_s = self.latest(&[Event::new(pair, Point::AtPick)], mode)?;
                    gates.goal_s = self.latest(&[Event::grasp(pair)], mode)?;
                }
            }
        }
        Ok(gates)
    }

    /// Whether a grasp or release that must come before the mode's event is not committed.
    pub fn lacks_event(&self, mode: &Mode) -> Option<Event> {
        let ends = mode.ends?;
        let instant = |event: &Event| matches!(event.point, Point::Grasp | Point::Release);
        let mut events = self.graph.events().filter(instant);
        events.find(|event| self.graph.precedes(*event, ends) && self.timeline.event_s(self.scene, *event).is_none())
    }

    /// How many moves of the robot's tail other robots count on.
    pub fn frozen_len(&self, mode: &Mode, tail: &[Move]) -> usize {
        let robot = mode.id.robot;
        let counted_on = self.graph.arcs().iter().any(|arc| {
            let here = matches!(arc.before.point, Point::Done | Point::Carry | Point::Start);
            here && arc.origin != ArcOrigin::Robot
                && self.mode_of(arc.before) == Some(mode.id)
                && self.owner(arc.after) != robot
                && self.mode_of(arc.after).is_some_and(|other| self.is_committed(other))
        });
        let folded = retract_len(self.scene.problem().robot(robot), mode.is_holding(), tail);
        if counted_on { folded.unwrap_or(tail.len()) } else { 0 }
    }

    /// The latest of the events that must come before any of `events` (s).
    fn latest(&self, events: &[Event], mode: &Mode) -> Result<f64, Vec<RobotId>> {
        let mut latest_s = f64::NEG_INFINITY;
        let mut waits_for = Vec::new();
        let arcs = self.graph.arcs().iter().filter(|arc| arc.origin != ArcOrigin::Robot && events.contains(&arc.after));
        for arc in arcs.filter(|arc| self.owner(arc.before) != mode.id.robot) {
            match self.time_s(arc.before) {
                Some(time_s) => latest_s = latest_s.max(time_s),
                None => waits_for.push(self.owner(arc.before)),
            }
        }
        waits_for.sort_unstable();
        waits_for.dedup();
        if waits_for.is_empty() { Ok(latest_s) } else { Err(waits_for) }
    }

    /// When an event happens (s), if that is settled.
    fn time_s(&self, event: Event) -> Option<f64> {
        let commitments = &self.timeline.robot(self.owner(event)).commitments;
        let mode = match self.mode_of(event) {
            Some(mode) => mode,
            // The robot's first start.
            None => return Some(0.0),
        };
        let of_robot = self.scene.problem().robot(mode.robot);
        let step = mode.step as usize;
        if let Some(commitment) = commitments.get(step) {
            let begins_s = step.checked_sub(1).map_or(0.0, |before| commitments[before].event_s);
            let moves = &commitment.moves;
            let fold = retract_len(of_robot, commitment.holding.is_some(), moves).unwrap_or(moves.len());
            return Some(match event.point {
                Point::Grasp | Point::Release => commitment.event_s,
                Point::Carry | Point::Done | Point::Start => end_of(moves, fold, begins_s),
                Point::AtPick | Point::AtPlace => end_of(moves, arrival_len(of_robot, moves).max(fold), begins_s),
            });
        }
        if !matches!(event.point, Point::Carry | Point::Done | Point::Start) {
            return None;
        }
        let before = commitments.get(step.checked_sub(1)?)?;
        let fold = retract_len(of_robot, before.tail_holding.is_some(), &before.tail)?;
        let time_s = end_of(&before.tail, fold, before.event_s);
        // The tail knows no gates: it counts only if it happens to keep them.
        let kept = |arc: &skeleton::Arc| self.time_s(arc.before).is_some_and(|first_s| first_s < time_s);
        let gating = |arc: &&skeleton::Arc| {
            arc.after == event && arc.origin != ArcOrigin::Robot && self.owner(arc.before) != mode.robot
        };
        self.graph.arcs().iter().filter(gating).all(kept).then_some(time_s)
    }

    /// The mode in which an event happens: `done` in the one after the release, and `start` is `done` of the pair before.
    pub fn mode_of(&self, event: Event) -> Option<ModeId> {
        let robot = self.owner(event);
        let pairs: Vec<PairId> = self.scene.problem().pairs_of_robot(robot).collect();
        let position = pairs.iter().position(|pair| *pair == event.pair)?;
        let step = match event.point {
            Point::Start if position == 0 => return None,
            Point::Start | Point::AtPick | Point::Grasp => 2 * position,
            Point::Carry | Point::AtPlace | Point::Release => 2 * position + 1,
            Point::Done => 2 * position + 2,
        };
        Some(ModeId { robot, step: step as u32 })
    }

    fn is_committed(&self, mode: ModeId) -> bool {
        (mode.step as usize) < self.timeline.robot(mode.robot).commitments.len()
    }

    fn owner(&self, event: Event) -> RobotId {
        self.scene.problem().pair(event.pair).robot
    }
}
