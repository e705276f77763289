//! Per-robot oracles: what each robot would do if it were alone, and what else it could do when that fails.

use contract::{SampleValues, VertexId};

use super::rules::{Act, Rules, State};
use super::validity::CompositeValidity;

/// How far one robot is from the end of its work.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(super) struct Urgency {
    /// 0: on its way to an event that may happen (or to its end); 1: its gate is shut; 2: at its end.
    pub class: u8,
    /// Least time to the end of the plan through this robot's event (s).
    pub remaining_s: f64,
}

impl<V: CompositeValidity> Rules<'_, V> {
    /// Least time of a robot to its phase's goal, objects as they stand (s).
    pub fn time_to_go_s(&self, state: &State, robot: usize) -> f64 {
        self.vector(state).times_to_go_s[robot][state.vertices[robot].index()]
    }

    /// Sum over the robots of the least times to their phases' goals (s).
    pub fn total_to_go_s(&self, state: &State) -> f64 {
        (0..state.vertices.len()).map(|robot| self.time_to_go_s(state, robot)).sum()
    }

    /// How urgent a robot is.
    pub fn urgency(&self, state: &State, robot: usize) -> Urgency {
        let vector = self.vector(state);
        let phase = self.roadmap.phase(robot, vector.phases[robot]);
        let to_go_s = self.time_to_go_s(state, robot);
        let is_last = phase.events.is_empty();
        let is_done = match self.roadmap.aim {
            None => is_last && state.vertices[robot] == phase.goal,
            // Who only makes room is never in a hurry.
            Some(aim) if aim.robot != robot => is_last,
            Some(aim) => self.is_reached(aim, state),
        };
        let class = match (vector.open[robot], is_done) {
            (_, true) => 2,
            (false, _) => 1,
            (true, _) => 0,
        };
        let is_aim = self.roadmap.aim.is_some_and(|aim| aim.robot == robot);
        Urgency { class, remaining_s: if is_aim { f64::MAX } else { to_go_s + phase.remaining_s } }
    }

    /// Robots, most urgent first: those whose event may happen before those that wait, longest critical path first.
    pub fn priorities(&self, state: &State) -> Vec<usize> {
        let mut robots: Vec<(Urgency, usize)> =
            (0..state.vertices.len()).map(|robot| (self.urgency(state, robot), robot)).collect();
        robots.sort_by(|(a, r), (b, s)| {
            a.class.cmp(&b.class).then(b.remaining_s.total_cmp(&a.remaining_s)).then(r.cmp(s))
        });
        robots.into_iter().map(|(_, robot)| robot).collect()
    }

    /// The next step of the shortest way to the goal, objects as they stand; its event where it may happen.
    pub fn informed(&self, state: &State, robot: usize) -> Act {
        if self.has_event(state, robot) {
            return Act::Event;
        }
        let times = &self.vector(state).times_to_go_s[robot];
        let mut best = (times[state.vertices[robot].index()], Act::Stay);
        for (index, arc) in self.arcs(state, robot).iter().enumerate() {
            let time = times[arc.to.index()];
            if time < best.0 && self.may_enter(state.vector, robot, arc) && self.is_clear(state.vector, arc) {
                best = (time, Act::Along(index));
            }
        }
        best.1
    }

    /// Any of a robot's acts, each with the same probability.
    pub fn random(&self, state: &State, robot: usize, values: &mut SampleValues) -> Act {
        let acts = self.acts(state, robot);
        acts[values.next_index(acts.len())]
    }

    /// The oracle of dRRT: the edge with the least angle to the direction of `target` (Solovey, Salzman, Halperin,
    /// doi:10.1177/0278364915615688). Coordinates are scaled to seconds. A robot that is there stays.
    pub fn toward(&self, state: &State, robot: usize, target: &[f64]) -> Act {
        let model = &self.roadmap.problem.robots[robot];
        let vertices = &self.roadmap.graph(robot, self.vector(state).phases[robot]).roadmap.vertices;
        let here = &vertices[state.vertices[robot].index()];
        let direction = |to: &[f64]| -> Vec<f64> {
            let to = model.short_way(here, to);
            to.iter().zip(here).zip(&model.coordinates).map(|((t, h), c)| (t - h) / c.velocity).collect()
        };
        let wanted = direction(target);
        let mut best = (-1.0_f64, Act::Stay);
        for act in self.acts(state, robot) {
            let Act::Along(index) = act else { continue };
            let along = direction(&vertices[self.arcs(state, robot)[index].to.index()]);
            let cosine = cosine(&wanted, &along);
            if cosine > best.0 {
                best = (cosine, act);
            }
        }
        best.1
    }

    /// `first`, then what a robot of lower priority may do instead: wait, go back, or evade, best neighbour first.
    pub fn alternatives(&self, state: &State, robot: usize, first: Act, came_from: Option<VertexId>) -> Vec<Act> {
        let times = &self.vector(state).times_to_go_s[robot];
        let arcs = self.arcs(state, robot);
        let mut ways: Vec<(bool, f64, usize)> = arcs
            .iter()
            .enumerate()
            .filter(|(_, arc)| self.may_enter(state.vector, robot, arc))
            .map(|(i, arc)| (Some(arc.to) != came_from, times[arc.to.index()] + arc.duration_s, i))
            .collect();
        ways.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut acts = vec![first];
        let others = std::iter::once(Act::Stay).chain(ways.into_iter().map(|(_, _, i)| Act::Along(i)));
        acts.extend(others.filter(|act| *act != first));
        acts
    }
}

impl<V: CompositeValidity> Rules<'_, V> {
    /// Lower bound on the time from a state to the aim (s).
    pub fn least_remaining_s(&self, state: &State) -> f64 {
        let phases = &self.vector(state).phases;
        let least = |robot: usize| {
            let phase = self.roadmap.phase(robot, phases[robot]);
            phase.cost_to_go_s[state.vertices[robot].index()] + phase.remaining_s
        };
        if let Some(aim) = self.roadmap.aim {
            return if self.is_reached(aim, state) { 0.0 } else { least(aim.robot) };
        }
        (0..phases.len()).map(least).fold(0.0, f64::max)
    }

    /// What each robot does in one step from a state to another of the same mode vector, and how long it takes (s); `None`
    /// if they are no neighbours. Other robots are not looked at.
    pub fn acts_between(&self, from: &State, to: &State) -> Option<(Vec<Act>, f64)> {
        let mut acts = Vec::with_capacity(from.vertices.len());
        let mut duration_s: f64 = 0.0;
        for (robot, target) in to.vertices.iter().enumerate() {
            if from.vertices[robot] == *target {
                acts.push(Act::Stay);
                continue;
            }
            let arcs = self.arcs(from, robot).iter().enumerate();
            let (index, arc) = arcs
                .filter(|(_, arc)| arc.to == *target && self.is_clear(from.vector, arc))
                .min_by(|(_, a), (_, b)| a.duration_s.total_cmp(&b.duration_s))?;
            acts.push(Act::Along(index));
            duration_s = duration_s.max(arc.duration_s);
        }
        Some((acts, duration_s))
    }
}

fn cosine(a: &[f64], b: &[f64]) -> f64 {
    let dot: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    let norms = a.iter().map(|x| x * x).sum::<f64>().sqrt() * b.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norms > 0.0 { dot / norms } else { -1.0 }
}
