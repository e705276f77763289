//! Multi-modal dRRT*: a tree in the implicit composite roadmap of all mode vectors.
//!
//! Solovey, Salzman, Halperin, Finding a needle in an exponential haystack, doi:10.1177/0278364915615688 (dRRT); Shome et
//! al., dRRT*, doi:10.1007/s10514-019-09832-9 (informed oracle, best parent, rewiring).
//!
//! Every node can be selected and every composite edge from it drawn with positive probability, so whatever can be
//! reached in the product is reached in the end with probability 1.

use std::collections::BTreeMap;

use contract::{Interrupted, RandomStream, SampleValues, VertexId};

use super::compose::Wishes;
use super::composite_roadmap::CompositeRoadmap;
use super::meter::Meter;
use super::mode_vector::VectorId;
use super::rules::{Act, Rules, State, Step};
use super::tree::{Entry, NodeId, Tree};
use super::validity::CompositeValidity;

/// Every so many iterations a connection to the next events is tried instead of an expansion.
const CONNECT_EVERY: u64 = 10;
/// Latest nodes of a mode vector looked at for a better parent and for rewiring.
const NEAR: usize = 64;
/// Composite edges checked for that.
const NEAR_CHECKS: usize = 8;
/// After the first solution the search goes on for half as many iterations, within these bounds.
const LEAST_EXTRA: u64 = 64;
const MOST_EXTRA: u64 = 256;

/// A search and all it has found.
pub(super) struct Search<'a, V> {
    pub rules: Rules<'a, V>,
    pub tree: Tree,
    /// Cheapest node at which all is done.
    pub solution: Option<NodeId>,
    /// How often two robots' wishes excluded one another, by mode vector.
    pub refusals: BTreeMap<(VectorId, usize, usize), u64>,
    /// Expansions from nodes of each mode vector.
    pub tried: BTreeMap<VectorId, u64>,
    /// First nodes of mode vectors from which no connection has been tried.
    pub fresh: Vec<NodeId>,
    random: RandomStream,
}

impl<'a, V: CompositeValidity> Search<'a, V> {
    /// A search from the state with these phases and vertices.
    pub fn new(
        roadmap: &'a CompositeRoadmap<'a>,
        validity: &'a V,
        start: &[(u32, VertexId)],
        random: RandomStream,
    ) -> Self {
        let mut rules = Rules::new(roadmap, validity);
        let phases: Vec<u32> = start.iter().map(|(phase, _)| *phase).collect();
        let vector = rules.vectors.number(roadmap, &phases);
        let root = State { vector, vertices: start.iter().map(|(_, vertex)| *vertex).collect() };
        let solution = rules.is_final(&root).then_some(0);
        Self {
            rules,
            tree: Tree::new(root),
            solution,
            refusals: BTreeMap::new(),
            tried: BTreeMap::new(),
            fresh: vec![0],
            random,
        }
    }

    /// Searches until there is a solution that a little more work does not improve, or the work is spent.
    ///
    /// # Errors
    /// [`Interrupted::Cancelled`].
    pub fn run(&mut self, meter: &mut Meter<'_, '_>) -> Result<(), Interrupted> {
        let mut last = u64::MAX;
        for iteration in 0.. {
            while let (Some(node), None) = (self.fresh.pop(), self.solution) {
                self.connect_in_turn(node, meter)?;
            }
            if self.solution.is_some() && last == u64::MAX {
                last = iteration + (iteration / 2).clamp(LEAST_EXTRA, MOST_EXTRA);
            }
            if iteration >= last || !meter.spend(1)? {
                return Ok(());
            }
            let mut values = self.random.values(iteration);
            let (node, target) = self.select(&mut values);
            if iteration % CONNECT_EVERY == CONNECT_EVERY - 1 {
                self.connect_at_random(node, &mut values, meter)?;
            } else {
                self.expand(node, target.as_deref(), &mut values, meter)?;
            }
        }
        Ok(())
    }

    /// Grows the tree from a node: one step by target or by chance, then on by the informed oracle while it gets nearer.
    fn expand(
        &mut self,
        node: NodeId,
        target: Option<&[Vec<f64>]>,
        values: &mut SampleValues,
        meter: &mut Meter<'_, '_>,
    ) -> Result<(), Interrupted> {
        let state = self.tree.get(node).state.clone();
        *self.tried.entry(state.vector).or_insert(0) += 1;
        let robots = state.vertices.len();
        // From all by chance (which gives every composite edge its probability) to all informed.
        let informed = values.next_index(5) as f64 / 4.0;
        let first = |robot: usize, rules: &Rules<'_, V>, values: &mut SampleValues| match target {
            _ if values.next_unit() < informed && target.is_none() => rules.informed(&state, robot),
            Some(target) if values.next_unit() >= 0.125 => rules.toward(&state, robot, &target[robot]),
            _ => rules.random(&state, robot, values),
        };
        let first: Vec<Act> = (0..robots).map(|robot| first(robot, &self.rules, values)).collect();
        let mut order = self.rules.priorities(&state);
        if values.next_unit() < 0.3 {
            shuffle(&mut order, values);
        }
        let mut reached = self.try_step(node, order, first);
        while let Some(from) = reached {
            if self.solution == Some(from) || !meter.spend(1)? {
                break;
            }
            let state = self.tree.get(from).state.clone();
            let first = (0..robots).map(|robot| self.rules.informed(&state, robot)).collect();
            let order = self.rules.priorities(&state);
            reached = self.try_step(from, order, first).filter(|to| self.is_nearer(from, *to));
        }
        Ok(())
    }

    /// Whether a step leads to another mode vector, or nearer to the goals: all robots together, or the most urgent.
    fn is_nearer(&self, from: NodeId, to: NodeId) -> bool {
        let (from, to) = (&self.tree.get(from).state, &self.tree.get(to).state);
        if from.vector != to.vector || self.rules.total_to_go_s(to) < self.rules.total_to_go_s(from) {
            return true;
        }
        let leader = self.rules.priorities(from)[0];
        self.rules.time_to_go_s(to, leader) < self.rules.time_to_go_s(from, leader)
    }

    /// Takes the best step that keeps the rules. The node, if its state was not in the tree.
    fn try_step(&mut self, node: NodeId, order: Vec<usize>, first: Vec<Act>) -> Option<NodeId> {
        let state = self.tree.get(node).state.clone();
        let came_from = self.tree.get(node).entry.as_ref().map(|entry| self.tree.get(entry.parent).state.clone());
        let alternatives = |(robot, act): (usize, Act)| {
            let before = came_from
                .as_ref()
                .filter(|before| self.rules.vector(before).phases[robot] == self.rules.vector(&state).phases[robot]);
            self.rules.alternatives(&state, robot, act, before.map(|before| before.vertices[robot]))
        };
        let acts = first.into_iter().enumerate().map(alternatives).collect();
        let composed = self.rules.compose(&state, &Wishes { order, acts });
        self.note_refusals(state.vector, &composed.refused);
        let (acts, step) = composed.step?;
        if self.is_hopeless(node, &step) {
            return None;
        }
        let (reached, is_new) = self.reach(node, acts, step);
        is_new.then_some(reached)
    }

    /// Whether no solution through a step can be cheaper than the one there is.
    fn is_hopeless(&self, from: NodeId, step: &Step) -> bool {
        let Some(solution) = self.solution else { return false };
        let cost_s = self.tree.get(from).cost_s + step.duration_s + self.rules.least_remaining_s(&step.to);
        cost_s >= self.tree.get(solution).cost_s
    }

    /// The node of the state that a step leads to, and whether it is new. A new one gets its best parent, and is made
    /// the parent of those that it makes cheaper.
    pub fn reach(&mut self, from: NodeId, acts: Vec<Act>, step: Step) -> (NodeId, bool) {
        let entry = Entry { parent: from, acts, duration_s: step.duration_s };
        if let Some(known) = self.tree.find(&step.to) {
            self.tree.rewire(known, entry);
            return (known, false);
        }
        let is_first = self.tree.in_vector(step.to.vector).is_empty();
        let node = self.tree.add(step.to, entry);
        if is_first {
            self.fresh.push(node);
        }
        self.improve_around(node);
        self.note_solution(node);
        (node, true)
    }

    fn note_solution(&mut self, node: NodeId) {
        // If all has to be done, the final state is one, and a better solution is a cheaper way to its node.
        let cost_s = |node: NodeId| self.tree.get(node).cost_s;
        let is_better = self.solution.is_none_or(|known| cost_s(node) < cost_s(known));
        if is_better && self.rules.is_final(&self.tree.get(node).state) {
            self.solution = Some(node);
        }
    }

    fn improve_around(&mut self, node: NodeId) {
        let state = self.tree.get(node).state.clone();
        let known = self.tree.in_vector(state.vector);
        let near: Vec<NodeId> = known.iter().rev().filter(|n| **n != node).take(NEAR).copied().collect();
        let mut checks = 0;
        let mut parents: Vec<(f64, NodeId, Vec<Act>)> = Vec::new();
        for other in &near {
            let there = &self.tree.get(*other).state;
            let Some((acts, duration_s)) = self.rules.acts_between(there, &state) else { continue };
            if self.tree.is_cheaper(node, *other, duration_s) {
                parents.push((self.tree.get(*other).cost_s + duration_s, *other, acts));
            }
        }
        parents.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, parent, acts) in parents.into_iter().take(NEAR_CHECKS) {
            let there = self.tree.get(parent).state.clone();
            if let Ok(step) = self.rules.checked_step(&there, &acts) {
                self.tree.rewire(node, Entry { parent, acts, duration_s: step.duration_s });
                break;
            }
        }
        for other in near {
            let there = self.tree.get(other).state.clone();
            let Some((acts, duration_s)) = self.rules.acts_between(&state, &there) else { continue };
            if checks < NEAR_CHECKS && self.tree.is_cheaper(other, node, duration_s) {
                checks += 1;
                if let Ok(step) = self.rules.checked_step(&state, &acts) {
                    self.tree.rewire(other, Entry { parent: node, acts, duration_s: step.duration_s });
                }
            }
        }
    }
}

/// Fisher-Yates.
pub(super) fn shuffle(order: &mut [usize], values: &mut SampleValues) {
    for i in (1..order.len()).rev() {
        order.swap(i, values.next_index(i + 1));
    }
}
