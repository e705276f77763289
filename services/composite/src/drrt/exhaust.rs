//! Systematic search of a small product: its answer is exact, a "no" included.

use std::collections::{BTreeMap, BinaryHeap};

use contract::Interrupted;

use super::meter::Meter;
use super::queue;
use super::rules::{Act, Rules, State};
use super::validity::CompositeValidity;

/// Composite edges generated for one work unit.
const EDGES_PER_UNIT: u64 = 64;

/// How a systematic search ended.
pub(super) enum Exhausted {
    /// A way of least composite time: what was done at each step.
    Found(Vec<Vec<Act>>),
    /// Everything that can be reached has been; there is no way on these roadmaps.
    NoWay,
    /// The budget ended first.
    Budget,
}

struct Reached {
    state: State,
    cost_s: f64,
    entered: Option<(usize, Vec<Act>)>,
    is_closed: bool,
}

/// Searches all composite edges from `root`, cheapest estimate first (A*).
pub(super) fn exhaust<V: CompositeValidity>(
    rules: &mut Rules<'_, V>,
    root: &State,
    meter: &mut Meter<'_, '_>,
) -> Result<Exhausted, Interrupted> {
    let mut all = vec![Reached { state: root.clone(), cost_s: 0.0, entered: None, is_closed: false }];
    let mut known: BTreeMap<State, usize> = BTreeMap::from([(root.clone(), 0)]);
    let mut open = BinaryHeap::from([queue::Entry::new(rules.least_remaining_s(root), 0)]);
    while let Some(entry) = open.pop() {
        let from = entry.item;
        if std::mem::replace(&mut all[from].is_closed, true) {
            continue;
        }
        let state = all[from].state.clone();
        if rules.is_final(&state) {
            return Ok(Exhausted::Found(retrace(&all, from)));
        }
        let edges = rules.edges_from(&state);
        if !meter.spend(1 + edges.len() as u64 / EDGES_PER_UNIT)? {
            return Ok(Exhausted::Budget);
        }
        for acts in edges {
            let step = rules.step(&state, &acts);
            let cost_s = all[from].cost_s + step.duration_s;
            let next = *known.entry(step.to.clone()).or_insert(all.len());
            if next == all.len() {
                all.push(Reached { state: step.to, cost_s: f64::INFINITY, entered: None, is_closed: false });
            }
            if cost_s < all[next].cost_s {
                all[next].cost_s = cost_s;
                all[next].entered = Some((from, acts));
                open.push(queue::Entry::new(cost_s + rules.least_remaining_s(&all[next].state), next));
            }
        }
    }
    Ok(Exhausted::NoWay)
}

fn retrace(all: &[Reached], goal: usize) -> Vec<Vec<Act>> {
    let mut steps = Vec::new();
    let mut at = goal;
    while let Some((from, acts)) = &all[at].entered {
        steps.push(acts.clone());
        at = *from;
    }
    steps.reverse();
    steps
}

impl<V: CompositeValidity> Rules<'_, V> {
    /// All composite edges from a state that keep the rules.
    pub fn edges_from(&mut self, state: &State) -> Vec<Vec<Act>> {
        let ready: Vec<usize> = (0..state.vertices.len()).filter(|robot| self.has_event(state, *robot)).collect();
        let mut edges = Vec::new();
        // Rarely more than two robots are ready at the same time; beyond twelve, further ones have their events later.
        for subset in 0_u32..1 << ready.len().min(12) {
            let mut events = vec![Act::Stay; state.vertices.len()];
            for (bit, robot) in ready.iter().enumerate().take(12) {
                if subset >> bit & 1 == 1 {
                    events[*robot] = Act::Event;
                }
            }
            self.edges_with(state, &events, &mut edges);
        }
        edges
    }

    fn edges_with(&mut self, state: &State, events: &[Act], edges: &mut Vec<Vec<Act>>) {
        let vector = self.after_events(state, events);
        let mut partial: Vec<Vec<Act>> = vec![Vec::new()];
        for robot in 0..events.len() {
            let wishes: Vec<Act> = match events[robot] {
                Act::Event => vec![Act::Event],
                _ => std::iter::once(Act::Stay).chain((0..self.arcs(state, robot).len()).map(Act::Along)).collect(),
            };
            let wishes: Vec<Act> =
                wishes.into_iter().filter(|act| self.may_alone(state, vector, robot, *act)).collect();
            let mut longer = Vec::new();
            for acts in &partial {
                for act in &wishes {
                    let own = (robot, *act);
                    let meets = (0..robot).any(|other| self.would_meet(state, vector, (other, acts[other]), own));
                    if !meets {
                        longer.push([acts.as_slice(), &[*act]].concat());
                    }
                }
            }
            partial = longer;
        }
        edges.extend(partial.into_iter().filter(|acts| acts.iter().any(|act| *act != Act::Stay)));
    }
}
