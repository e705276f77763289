//! From a way through the composite roadmap to commitments.

use contract::{Commitment, ModeRoadmap, Move, Tail};
use model::{AllowedContacts, RobotId};

use super::polish::Way;
use super::rules::{Act, Rules, State};
use super::start::{RobotStart, Start};
use super::validity::CompositeValidity;

/// One robot on its way.
struct Track {
    moves: Vec<Move>,
    at: Vec<f64>,
    /// Rest that `moves` begins with (s).
    rest_s: f64,
    /// When `moves` begins (s).
    since_s: f64,
}

/// What a way becomes.
pub(super) struct Scheduled {
    /// Commitments of every mode that the way ends, in order of their events, without tails.
    pub commitments: Vec<Commitment>,
    /// What robots that are not at their end have done since their last events.
    pub tails: Vec<Tail>,
}

/// Gives a way its times; only robots that may move are committed to anything.
pub(super) fn schedule<V: CompositeValidity>(
    rules: &mut Rules<'_, V>,
    start: &Start,
    way: &Way,
    moves: impl Fn(usize) -> bool,
) -> Scheduled {
    let mut tracks: Vec<Track> = start.robots.iter().map(Track::new).collect();
    let mut commitments = Vec::new();
    let mut now_s = start.begins_s;
    for (state, acts) in way.states.iter().zip(&way.steps) {
        let step = rules.step(state, acts);
        let next_s = now_s + step.duration_s;
        for (robot, act) in acts.iter().enumerate() {
            let phase = rules.roadmap.phase(robot, rules.vector(state).phases[robot]);
            let timed = rules.roadmap.timed(rules.motion(state, step.to.vector, robot, *act));
            let track = &mut tracks[robot];
            match act {
                Act::Stay => {}
                Act::Along(_) => {
                    let to = rules.roadmap.problem.robots[robot].short_way(&track.at, &timed.travel.to);
                    track.travel(Move { to, begins_s: now_s, ends_s: now_s + timed.travel.ends_s, ..timed.travel });
                }
                Act::Event if phase.ends_mode() => {
                    let graph = &rules.roadmap.robots[robot].modes[phase.mode];
                    commitments.push(Commitment {
                        mode: graph.roadmap.mode,
                        holding: graph.roadmap.holding,
                        moves: std::mem::take(&mut track.moves),
                        event_s: now_s,
                        tail: Vec::new(),
                        tail_holding: timed.holding,
                    });
                    (track.rest_s, track.since_s) = (phase.rest_s, now_s);
                }
                Act::Event => {}
            }
            let stands_at = step.to.vertices[robot];
            let graph = rules.roadmap.graph(robot, rules.vectors.get(step.to.vector).phases[robot]);
            track.stand_until(next_s, &graph.timed_stand(stands_at).travel);
        }
        now_s = next_s;
    }
    let mut tails = Vec::new();
    let last = &way.states[way.states.len() - 1];
    for (robot, track) in tracks.into_iter().enumerate().filter(|(robot, _)| moves(*robot)) {
        if let Some(closing) = rules.closes(last, robot) {
            let (mode, holding) = (closing.mode, closing.holding);
            let (moves, event_s) = track.close();
            commitments.push(Commitment { mode, holding, moves, event_s, tail: Vec::new(), tail_holding: holding });
        } else {
            let graph = rules.roadmap.graph(robot, rules.vector(last).phases[robot]);
            let moves = track.rest(&graph.timed_stand(last.vertices[robot]).travel);
            tails.push(Tail { robot: RobotId::at(robot), moves });
        }
    }
    commitments.sort_by(|a, b| a.event_s.total_cmp(&b.event_s));
    Scheduled { commitments, tails }
}

impl<V: CompositeValidity> Rules<'_, V> {
    /// The roadmap of a robot's closing return, if that is over with the aim in this state.
    fn closes(&self, state: &State, robot: usize) -> Option<&ModeRoadmap> {
        let is_over = match self.roadmap.aim {
            Some(aim) => aim.robot == robot && self.vector(state).phases[robot] == aim.phase,
            None => true,
        };
        self.roadmap.robots[robot].closing().filter(|_| is_over)
    }
}

impl Track {
    fn new(start: &RobotStart) -> Self {
        let RobotStart { moves, at, since_s, rest_s, .. } = start.clone();
        Self { moves, at, rest_s, since_s }
    }

    fn travel(&mut self, travel: Move) {
        let from = std::mem::replace(&mut self.at, travel.to.clone());
        self.moves.push(Move { from, ..travel });
    }

    /// Fills the time until `until_s` with standing, as `stand` says.
    fn stand_until(&mut self, until_s: f64, stand: &Move) {
        let begins_s = self.moves.last().map_or(self.since_s, |m| m.ends_s);
        if begins_s >= until_s {
            return;
        }
        match self.moves.last_mut() {
            Some(last) if last.from == last.to && last.kind == stand.kind && last.allowed == stand.allowed => {
                last.ends_s = until_s;
            }
            _ => {
                let (from, to) = (self.at.clone(), self.at.clone());
                self.moves.push(Move { from, to, begins_s, ends_s: until_s, ..stand.clone() });
            }
        }
    }

    /// The moves, with what the robot may touch where it comes to rest, if that is anything.
    fn rest(mut self, stand: &Move) -> Vec<Move> {
        let stands = self.moves.last().is_some_and(|last| last.from == last.to);
        if !stands && stand.allowed != AllowedContacts::default() {
            let time_s = self.moves.last().map_or(self.since_s, |last| last.ends_s);
            let (from, to) = (self.at.clone(), self.at);
            self.moves.push(Move { from, to, begins_s: time_s, ends_s: time_s, ..stand.clone() });
        }
        self.moves
    }

    /// The closing return: it is over when the robot has come to its end, however long the others still move.
    fn close(mut self) -> (Vec<Move>, f64) {
        let rested_s = self.since_s + self.rest_s;
        while let Some(last) = self.moves.last_mut().filter(|last| last.from == last.to) {
            if last.begins_s < rested_s {
                last.ends_s = last.ends_s.min(rested_s);
                break;
            }
            self.moves.pop();
        }
        let event_s = self.moves.last().map_or(self.since_s, |m| m.ends_s);
        (self.moves, event_s)
    }
}
