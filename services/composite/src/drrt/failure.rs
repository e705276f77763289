//! Why there is no plan: who got stuck at the furthest point, and what was in the way.

use contract::{CauseTally, FailureReport};
use plan::{BodyRef, Cause};

use super::mode_vector::{BLOCKED_S, VectorId};
use super::rules::{Act, Refused, State};
use super::search::Search;
use super::validity::CompositeValidity;

impl<V: CompositeValidity> Search<'_, V> {
    /// The report of a search without a solution. `is_exhausted`: everything that can be reached on these roadmaps has
    /// been; else the budget ended first.
    pub fn failure(&mut self, is_exhausted: bool) -> FailureReport {
        let mut causes: Vec<(Cause, u64)> = Vec::new();
        if let Some(furthest) = self.furthest() {
            let state = self.tree.get(self.tree.in_vector(furthest)[0]).state.clone();
            causes.extend((0..state.vertices.len()).filter_map(|robot| self.obstructed(&state, robot)));
            causes.extend(self.deadlock(&state));
        }
        if !is_exhausted {
            causes.push((Cause::Budget { stage: contract::StageKind::Composite.name().to_owned() }, 1));
        }
        let mut tally = CauseTally::default();
        tally.count_all(&causes);
        // Denser roadmaps may have a way, however thoroughly these were searched.
        FailureReport::soft(tally, 0)
    }

    /// The most advanced mode vector; of several the one tried most.
    fn furthest(&self) -> Option<VectorId> {
        self.tree.vectors().max_by_key(|vector| {
            let tried = self.tried.get(vector).copied().unwrap_or(0);
            (self.rules.vectors.get(*vector).advance, tried, std::cmp::Reverse(*vector))
        })
    }

    /// The objects through which a robot's shortest way to its event leads, if no way avoids them all: those that stand
    /// there for ever, or all, if there is no robot that could go on.
    fn obstructed(&self, state: &State, robot: usize) -> Option<(Cause, u64)> {
        let problem = self.rules.roadmap.problem;
        if self.rules.urgency(state, robot).class != 0 || self.rules.time_to_go_s(state, robot) < BLOCKED_S {
            return None;
        }
        let goes_on = |robot: usize| {
            self.rules.urgency(state, robot).class == 0 && self.rules.time_to_go_s(state, robot) < BLOCKED_S
        };
        let is_waiting = (0..state.vertices.len()).any(goes_on);
        let vector = self.rules.vector(state);
        let times = &vector.times_to_go_s[robot];
        let phase = self.rules.roadmap.phase(robot, vector.phases[robot]);
        let mut at = state.vertices[robot];
        let mut objects = Vec::new();
        while at != phase.goal {
            let arcs = self.rules.roadmap.arcs(robot, vector.phases[robot], at).iter();
            let nearer = arcs.filter(|arc| phase.usable[arc.to.index()] && times[arc.to.index()] < times[at.index()]);
            let arc = nearer.min_by(|a, b| times[a.to.index()].total_cmp(&times[b.to.index()]))?;
            let present = arc.blockers.iter().filter(|occupancy| vector.present[**occupancy as usize]);
            let stays = present.map(|occupancy| &self.rules.roadmap.stays[*occupancy as usize]);
            objects.extend(stays.filter(|stay| !is_waiting || stay.until.is_none()).map(|stay| stay.occupancy.object));
            at = arc.to;
        }
        if objects.is_empty() {
            return None;
        }
        objects.sort_unstable();
        objects.dedup();
        let name = |object: &model::ObjectId| BodyRef::Object(problem.movable[object.index()].name.clone());
        let pair = phase.events.first().map(|event| problem.pair(event.pair).name.clone());
        let robot = problem.robots[robot].name.clone();
        Some((Cause::NoPath { pair, robot, blocking: objects.iter().map(name).collect() }, 1))
    }

    /// Robots that stand on a robot's shortest way to its phase's goal.
    fn standing_in_the_way(&mut self, state: &State, robot: usize) -> Vec<usize> {
        let mut at = state.clone();
        let mut found = Vec::new();
        while let Act::Along(arc) = self.rules.informed(&at, robot) {
            let own = self.rules.motion(&at, at.vector, robot, Act::Along(arc));
            for other in (0..at.vertices.len()).filter(|other| *other != robot) {
                let stand = self.rules.motion(&at, at.vector, other, Act::Stay);
                if self.rules.conflict(own, stand) {
                    found.push(other);
                }
            }
            at.vertices[robot] = self.rules.arcs(&at, robot)[arc].to;
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Robots whose wishes excluded one another at the furthest point; where none did, those that are not at their end.
    fn deadlock(&mut self, state: &State) -> Option<(Cause, u64)> {
        let robots = state.vertices.len();
        let at_furthest = self.refusals.range((state.vector, 0, 0)..(state.vector + 1, 0, 0));
        let (mut names, mut times) = (vec![false; robots], 0);
        for ((_, a, b), count) in at_furthest {
            (names[*a], names[*b]) = (true, true);
            times += count;
        }
        if let Some(aim) = self.rules.roadmap.aim {
            let in_the_way = self.standing_in_the_way(state, aim.robot);
            times += in_the_way.len() as u64;
            in_the_way.into_iter().chain([aim.robot]).for_each(|robot| names[robot] = true);
        }
        if times == 0 {
            names = (0..robots).map(|robot| self.rules.urgency(state, robot).class != 2).collect();
        }
        let problem = self.rules.roadmap.problem;
        let robots: Vec<String> =
            (0..robots).filter(|robot| names[*robot]).map(|robot| problem.robots[robot].name.clone()).collect();
        (!robots.is_empty()).then_some((Cause::Deadlock { robots }, times.max(1)))
    }

    /// Counts refusals between pairs of robots.
    pub fn note_refusals(&mut self, vector: VectorId, refused: &[Refused]) {
        for refused in refused {
            if let Refused::Pair(a, b) = *refused {
                *self.refusals.entry((vector, a.min(b), a.max(b))).or_insert(0) += 1;
            }
        }
    }
}
