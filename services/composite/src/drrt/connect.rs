//! Connection to the next events: per-robot shortest paths, prioritised, with waits and evasion.
//!
//! One robot leads: it goes the shortest way to its event, perhaps after a delay. The others follow in order of priority:
//! each searches vertices and steps for a way towards its own goal that keeps clear of those before it, which makes a
//! robot that stands in the way leave in time (cooperative A*, Silver, AIIDE 2005). The tree gets every step, up to the
//! first event.

use std::collections::BinaryHeap;

use contract::{Interrupted, JobContext, SampleValues};

use super::composite_roadmap::{Motion, Passed};
use super::mode_vector::BLOCKED_S;
use super::queue;
use super::rules::{Act, Rules, State};
use super::search::{Search, shuffle};
use super::tree::NodeId;
use super::validity::CompositeValidity;

/// Steps that the leader waits, in turn; also its waits by chance.
const DELAYS: [usize; 4] = [0, 4, 12, 32];
/// Most robots that lead in turn.
const LEADERS: usize = 3;
/// What an edge costs a leader on which it would meet a robot that stands now (s): so far it goes round.
const STANDING_S: f64 = 4.0;
/// Places in vertices and steps looked at for one work unit.
const PLACES_PER_UNIT: u64 = 32;
/// Most places looked at for one robot.
const MOST_PLACES: u64 = 20_000;

/// How a connection is tried.
struct Attempt {
    /// The leader, then the others by priority.
    order: Vec<usize>,
    /// Steps that the leader waits.
    delay: usize,
    /// What it costs the leader to meet a robot that stands now (s).
    standing_s: f64,
}

impl<V: CompositeValidity> Search<'_, V> {
    /// Tries connections from a node in a fixed order until one leads to an event or to the end.
    pub fn connect_in_turn(&mut self, node: NodeId, context: &mut JobContext<'_>) -> Result<(), Interrupted> {
        let state = self.tree.get(node).state.clone();
        let priorities = self.rules.priorities(&state);
        let ready = |robot: &usize| self.rules.urgency(&state, *robot).class == 0;
        let leaders: Vec<usize> = priorities.iter().copied().filter(ready).take(LEADERS).collect();
        for delay in DELAYS {
            for leader in &leaders {
                let attempt = Attempt { order: led_by(*leader, &priorities), delay, standing_s: STANDING_S };
                if self.connect(node, &attempt, context)? || self.spent > self.limit {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Tries one connection with leader, order, delay and detour by chance.
    pub fn connect_at_random(
        &mut self,
        node: NodeId,
        values: &mut SampleValues,
        context: &mut JobContext<'_>,
    ) -> Result<(), Interrupted> {
        let state = self.tree.get(node).state.clone();
        let mut order = self.rules.priorities(&state);
        let ready: Vec<usize> =
            order.iter().copied().filter(|robot| self.rules.urgency(&state, *robot).class == 0).collect();
        if ready.is_empty() {
            return Ok(());
        }
        let leader = ready[values.next_index(ready.len())];
        if values.next_unit() < 0.5 {
            shuffle(&mut order, values);
        }
        let delay = DELAYS[values.next_index(DELAYS.len())] / 2 + values.next_index(4);
        let standing_s = [0.0, STANDING_S, 16.0 * STANDING_S][values.next_index(3)];
        self.connect(node, &Attempt { order: led_by(leader, &order), delay, standing_s }, context)?;
        Ok(())
    }

    /// Whether an attempt led to an event or to the end of the plan.
    fn connect(&mut self, node: NodeId, attempt: &Attempt, context: &mut JobContext<'_>) -> Result<bool, Interrupted> {
        let state = self.tree.get(node).state.clone();
        let mut places = 0;
        let planned = self.rules.plan_together(&state, attempt, &mut places);
        let units = 1 + places / PLACES_PER_UNIT + planned.as_ref().map_or(0, |acts| acts.len() as u64);
        if !self.spend(units, context)? {
            return Ok(false);
        }
        Ok(planned.is_some_and(|steps| self.walk(node, &steps)))
    }

    /// Takes planned steps until an event happens; whether one did, or all is done.
    fn walk(&mut self, node: NodeId, steps: &[Vec<Act>]) -> bool {
        let mut at = node;
        for acts in steps {
            if self.happen(at, acts) {
                return true;
            }
            let state = self.tree.get(at).state.clone();
            if acts.iter().all(|act| *act == Act::Stay) {
                continue;
            }
            let Ok(step) = self.rules.checked_step(&state, acts) else { return false };
            at = self.reach(at, acts.clone(), step).0;
        }
        let still = vec![Act::Stay; self.tree.get(at).state.vertices.len()];
        self.happen(at, &still) || self.solution == Some(at)
    }

    /// Lets events happen at a node: all that can while the other robots go on, or else a single one.
    fn happen(&mut self, node: NodeId, acts: &[Act]) -> bool {
        let state = self.tree.get(node).state.clone();
        let ready: Vec<usize> = (0..acts.len()).filter(|robot| self.rules.has_event(&state, *robot)).collect();
        if ready.is_empty() {
            return false;
        }
        let with = |acts: &[Act], events: &[usize]| -> Vec<Act> {
            (0..acts.len()).map(|r| if events.contains(&r) { Act::Event } else { acts[r] }).collect()
        };
        let still = vec![Act::Stay; acts.len()];
        let mut choices = vec![with(acts, &ready), with(&still, &ready)];
        choices.extend(ready.iter().map(|robot| with(&still, &[*robot])));
        for acts in choices {
            if let Ok(step) = self.rules.checked_step(&state, &acts) {
                self.reach(node, acts, step);
                return true;
            }
        }
        false
    }
}

fn led_by(leader: usize, order: &[usize]) -> Vec<usize> {
    std::iter::once(leader).chain(order.iter().copied().filter(|robot| *robot != leader)).collect()
}

impl<V: CompositeValidity> Rules<'_, V> {
    /// Steps of all robots within the state's mode vector, each robot's part clear of those before it in the order.
    fn plan_together(&mut self, state: &State, attempt: &Attempt, places: &mut u64) -> Option<Vec<Vec<Act>>> {
        let leader = attempt.order[0];
        let mut route = vec![Act::Stay; attempt.delay];
        route.extend(self.lead(state, leader, attempt.standing_s)?);
        let is_last = |robot: usize| self.roadmap.phase(robot, self.vector(state).phases[robot]).events.is_empty();
        if is_last(leader) {
            // The end is only reached when all are there together.
            let longest = (0..attempt.order.len()).map(|robot| self.steps_to_go(state, robot)).max().unwrap_or(0);
            route.resize(route.len() + longest, Act::Stay);
        }
        let placed = self.placed_by(state, leader);
        let mut planned: Vec<(usize, Vec<Act>, Vec<Motion>)> = Vec::new();
        for robot in &attempt.order {
            let acts = match planned.len() {
                0 => route.clone(),
                _ => self.follow(state, *robot, &planned, route.len(), placed, places)?,
            };
            let motions = self.motions(state, *robot, &acts);
            planned.push((*robot, acts, motions));
        }
        let mut steps = vec![vec![Act::Stay; attempt.order.len()]; route.len()];
        for (robot, acts, _) in planned {
            acts.into_iter().enumerate().for_each(|(step, act)| steps[step][robot] = act);
        }
        Some(steps)
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

    /// A way of `horizon` steps that keeps clear of the motions planned before it and ends as near to the robot's goal as it
    /// can, where no object is placed on it.
    fn follow(
        &mut self,
        state: &State,
        robot: usize,
        planned: &[(usize, Vec<Act>, Vec<Motion>)],
        horizon: usize,
        placed: Option<u32>,
        places: &mut u64,
    ) -> Option<Vec<Act>> {
        let graph = self.roadmap.graph(robot, self.vector(state).phases[robot]);
        let mode = graph.roadmap.mode.step as usize;
        let width = graph.arcs.len();
        let times = self.vector(state).times_to_go_s[robot].clone();
        // An edge that an object blocks now is as good as any other to wait at.
        let to_go = |vertex: usize| if times[vertex].is_finite() { times[vertex] % BLOCKED_S } else { BLOCKED_S };
        let mut cost = vec![f64::INFINITY; width * (horizon + 1)];
        let mut entered: Vec<Option<(usize, Act)>> = vec![None; width * (horizon + 1)];
        let mut open = BinaryHeap::new();
        let start = state.vertices[robot].index();
        cost[start] = 0.0;
        open.push(queue::Entry::new(to_go(start), (horizon, start)));
        let most = *places + MOST_PLACES;
        while let Some(entry) = open.pop() {
            let (left, vertex) = entry.item;
            let step = horizon - left;
            let place = step * width + vertex;
            let here = contract::VertexId::at(vertex);
            let stand = Motion { robot, mode, from: here, arc: None };
            if left == 0 {
                if placed.is_some_and(|occupancy| self.stand_hits(stand, occupancy)) {
                    continue;
                }
                return Some(retrace(&entered, place, width));
            }
            *places += 1;
            if entry.key > cost[place] + to_go(vertex) || *places > most {
                continue;
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
                if longer >= cost[next]
                    || planned.iter().any(|(_, theirs, motions)| {
                        !(act == Act::Stay && theirs[step] == Act::Stay) && self.conflict(motion, motions[step])
                    })
                {
                    continue;
                }
                cost[next] = longer;
                entered[next] = Some((place, act));
                open.push(queue::Entry::new(longer + to_go(to), (left - 1, to)));
            }
        }
        None
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
