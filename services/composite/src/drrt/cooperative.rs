//! Cooperative planning of some steps within one mode vector: one robot leads, the others keep clear of those before them.

use std::collections::BinaryHeap;

use contract::{Interrupted, VertexId};

use super::composite_roadmap::{Motion, Passed};
use super::meter::Meter;
use super::mode_graph::ModeGraph;
use super::mode_vector::BLOCKED_S;
use super::queue;
use super::rules::{Act, Rules, State};
use super::validity::CompositeValidity;

/// Most places (vertices and steps) looked at for one robot.
const MOST_PLACES: u32 = 8_000;

/// How it is tried.
#[derive(Clone, Debug)]
pub(super) struct Attempt {
    /// The leader, then the others by priority.
    pub order: Vec<usize>,
    /// Steps that the leader waits.
    pub delay: usize,
    /// What it costs the leader to meet a robot that stands now (s).
    pub standing_s: f64,
}

impl<V: CompositeValidity> Rules<'_, V> {
    /// Steps of all robots within the state's mode vector. A robot that finds no way is planned again right after the
    /// leader, until each has been.
    pub fn plan_together(
        &mut self,
        state: &State,
        attempt: &Attempt,
        meter: &mut Meter<'_, '_>,
    ) -> Result<Option<Vec<Vec<Act>>>, Interrupted> {
        let leader = attempt.order[0];
        let mut route = vec![Act::Stay; attempt.delay];
        let Some(way) = self.lead(state, leader, attempt.standing_s) else { return Ok(None) };
        route.extend(way);
        let is_last = |robot: usize| self.roadmap.phase(robot, self.vector(state).phases[robot]).events.is_empty();
        if is_last(leader) {
            // The end is only reached when all are there together.
            let longest = (0..attempt.order.len()).map(|robot| self.steps_to_go(state, robot)).max().unwrap_or(0);
            route.resize(route.len() + longest, Act::Stay);
        }
        let mut order = attempt.order.clone();
        let mut promoted = vec![false; order.len()];
        promoted[leader] = true;
        loop {
            match self.plan_in_order(state, &order, &route, meter)? {
                Ok(steps) => return Ok(Some(steps)),
                Err(stuck) if promoted[stuck] => return Ok(None),
                Err(stuck) => {
                    promoted[stuck] = true;
                    order.retain(|robot| *robot != stuck);
                    order.insert(1, stuck);
                }
            }
        }
    }

    /// All robots' acts at each step, or the first robot that finds no way.
    fn plan_in_order(
        &mut self,
        state: &State,
        order: &[usize],
        route: &[Act],
        meter: &mut Meter<'_, '_>,
    ) -> Result<Result<Vec<Vec<Act>>, usize>, Interrupted> {
        let placed = self.placed_by(state, order[0]);
        let mut planned: Vec<Planned> = Vec::new();
        for robot in order {
            let acts = match planned.len() {
                0 => Some(route.to_vec()),
                _ => self.follow(state, *robot, &planned, route.len(), placed, meter)?,
            };
            let Some(acts) = acts else { return Ok(Err(*robot)) };
            let motions = self.motions(state, *robot, &acts);
            planned.push(Planned { robot: *robot, acts, motions });
        }
        let mut steps = vec![vec![Act::Stay; order.len()]; route.len()];
        for Planned { robot, acts, .. } in planned {
            acts.into_iter().enumerate().for_each(|(step, act)| steps[step][robot] = act);
        }
        Ok(Ok(steps))
    }

    /// The occupancy that a robot's event would create.
    fn placed_by(&self, state: &State, robot: usize) -> Option<u32> {
        let passed = Passed { robot, phase: self.vector(state).phases[robot] };
        self.roadmap.stays.iter().position(|stay| stay.from == Some(passed)).map(|stay| stay as u32)
    }

    /// The leader's way to its goal, objects as they stand; robots that stand in it cost.
    fn lead(&mut self, state: &State, robot: usize, standing_s: f64) -> Option<Vec<Act>> {
        let graph = self.roadmap.graph(robot, self.vector(state).phases[robot]);
        let goal = self.roadmap.phase(robot, self.vector(state).phases[robot]).goal;
        let mode = graph.roadmap.mode.step as usize;
        let others: Vec<Motion> = (0..state.vertices.len())
            .filter(|other| *other != robot)
            .map(|other| self.motion(state, state.vector, other, Act::Stay))
            .collect();
        let mut cost = vec![f64::INFINITY; graph.arcs.len()];
        let mut entered: Vec<Option<(usize, usize)>> = vec![None; graph.arcs.len()];
        let mut open = BinaryHeap::new();
        cost[state.vertices[robot].index()] = 0.0;
        open.push(queue::Entry::new(0.0, state.vertices[robot]));
        while let Some(entry) = open.pop() {
            let vertex = entry.item;
            if vertex == goal {
                break;
            }
            if entry.key > cost[vertex.index()] {
                continue;
            }
            for (index, arc) in graph.arcs[vertex.index()].iter().enumerate() {
                if !self.may_enter(state.vector, robot, arc) || !self.is_clear(state.vector, arc) {
                    continue;
                }
                let motion = Motion { robot, mode, from: vertex, arc: Some(index) };
                let meets = standing_s > 0.0 && others.iter().any(|other| self.conflict(motion, *other));
                let next = entry.key + arc.duration_s + if meets { standing_s } else { 0.0 };
                if next < cost[arc.to.index()] {
                    cost[arc.to.index()] = next;
                    entered[arc.to.index()] = Some((vertex.index(), index));
                    open.push(queue::Entry::new(next, arc.to));
                }
            }
        }
        if !cost[goal.index()].is_finite() {
            return None;
        }
        let mut acts = Vec::new();
        let mut at = goal.index();
        while let (true, Some((from, arc))) = (at != state.vertices[robot].index(), entered[at]) {
            acts.push(Act::Along(arc));
            at = from;
        }
        acts.reverse();
        Some(acts)
    }

    /// Number of edges on a robot's shortest way to its goal.
    fn steps_to_go(&self, state: &State, robot: usize) -> usize {
        let mut at = state.clone();
        let mut steps = 0;
        while let Act::Along(arc) = self.informed(&at, robot) {
            at.vertices[robot] = self.arcs(&at, robot)[arc].to;
            steps += 1;
        }
        steps
    }

    /// The motions of a robot that does some acts one after the other.
    fn motions(&self, state: &State, robot: usize, acts: &[Act]) -> Vec<Motion> {
        let mut at = state.clone();
        let mut motions = Vec::with_capacity(acts.len());
        for act in acts {
            motions.push(self.motion(&at, state.vector, robot, *act));
            if let Act::Along(arc) = act {
                at.vertices[robot] = self.arcs(&at, robot)[*arc].to;
            }
        }
        motions
    }

    /// A way of `horizon` steps that keeps clear of the motions planned before it and ends near the robot's goal, where no
    /// object is placed on it. Least is the time to go at its end plus half of the time travelled: a robot goes on where it
    /// can, and moves aside no further than it must.
    fn follow(
        &mut self,
        state: &State,
        robot: usize,
        planned: &[Planned],
        horizon: usize,
        placed: Option<u32>,
        meter: &mut Meter<'_, '_>,
    ) -> Result<Option<Vec<Act>>, Interrupted> {
        let graph = self.roadmap.graph(robot, self.vector(state).phases[robot]);
        let mode = graph.roadmap.mode.step as usize;
        let width = graph.arcs.len();
        let guide = Guide::new(&self.vector(state).times_to_go_s[robot], graph);
        let mut cost = vec![f64::INFINITY; width * (horizon + 1)];
        let mut entered: Vec<Option<(usize, Act)>> = vec![None; width * (horizon + 1)];
        let mut open = BinaryHeap::new();
        let start = state.vertices[robot].index();
        cost[start] = 0.0;
        open.push(guide.entry(0.0, horizon, start));
        let mut places = 0;
        while let Some(entry) = open.pop() {
            let (_, left, vertex) = entry.item;
            let step = horizon - left;
            let place = step * width + vertex;
            let stand = Motion { robot, mode, from: VertexId::at(vertex), arc: None };
            if left == 0 {
                if placed.is_some_and(|occupancy| self.stand_hits(stand, occupancy)) {
                    continue;
                }
                return Ok(Some(retrace(&entered, place, width)));
            }
            if entry.key > guide.entry(cost[place], left, vertex).key {
                continue;
            }
            places += 1;
            if places > MOST_PLACES || !meter.count_place()? {
                return Ok(None);
            }
            let ways = graph.arcs[vertex].iter().enumerate();
            let ways =
                ways.filter(|(_, arc)| self.may_enter(state.vector, robot, arc) && self.is_clear(state.vector, arc));
            let mut acts: Vec<(Act, Motion, usize, f64)> = ways
                .map(|(i, arc)| (Act::Along(i), Motion { arc: Some(i), ..stand }, arc.to.index(), arc.duration_s))
                .collect();
            acts.push((Act::Stay, stand, vertex, 0.0));
            for (act, motion, to, duration_s) in acts {
                let next = (step + 1) * width + to;
                let longer = cost[place] + duration_s;
                if longer >= cost[next] || planned.iter().any(|other| other.meets(self, step, act, motion)) {
                    continue;
                }
                cost[next] = longer;
                entered[next] = Some((place, act));
                open.push(guide.entry(longer, left - 1, to));
            }
        }
        Ok(None)
    }
}

/// What a robot does at each step, as acts and as motions.
struct Planned {
    robot: usize,
    acts: Vec<Act>,
    motions: Vec<Motion>,
}

impl Planned {
    /// Whether another robot's act at a step would bring the two too close.
    fn meets<V: CompositeValidity>(&self, rules: &mut Rules<'_, V>, step: usize, act: Act, motion: Motion) -> bool {
        let both_stay = act == Act::Stay && self.acts[step] == Act::Stay;
        !both_stay && rules.conflict(motion, self.motions[step])
    }
}

/// Estimates for a robot that follows.
struct Guide {
    to_go_s: Vec<f64>,
    longest_s: f64,
}

impl Guide {
    fn new(times: &[f64], graph: &ModeGraph<'_>) -> Self {
        // An edge that an object blocks now is as good as any other to wait at.
        let to_go = |time: &f64| if time.is_finite() { time % BLOCKED_S } else { BLOCKED_S };
        let longest_s = graph.arcs.iter().flatten().map(|arc| arc.duration_s).fold(0.0, f64::max);
        Self { to_go_s: times.iter().map(to_go).collect(), longest_s }
    }

    /// Lower bound on half the time travelled plus the time to go at the end; nearer to the goal first.
    fn entry(&self, cost_s: f64, left: usize, vertex: usize) -> queue::Entry<(u64, usize, usize)> {
        let to_go_s = self.to_go_s[vertex];
        let out_of_reach_s = (to_go_s - left as f64 * self.longest_s).max(0.0);
        // Non-negative numbers are ordered as their bits.
        queue::Entry::new((cost_s + to_go_s + out_of_reach_s) / 2.0, (to_go_s.to_bits(), left, vertex))
    }
}

fn retrace(entered: &[Option<(usize, Act)>], place: usize, width: usize) -> Vec<Act> {
    let mut acts = Vec::new();
    let mut at = place;
    while let (true, Some((from, act))) = (at >= width, entered[at]) {
        acts.push(act);
        at = from;
    }
    acts.reverse();
    acts
}
