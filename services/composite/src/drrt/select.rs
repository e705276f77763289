//! Which node grows next: 60 % among the most advanced mode vectors, 20 % uniform over mode vectors, 20 % Voronoi.

use contract::SampleValues;

use super::mode_vector::VectorId;
use super::search::Search;
use super::tree::NodeId;
use super::validity::CompositeValidity;

/// Expansions of a mode vector without a new one after which it counts as one event less advanced; doubling for each more.
const PATIENCE: u64 = 32;
/// Nodes among which the nearest to a random composite configuration is taken.
const CANDIDATES: usize = 64;

impl<V: CompositeValidity> Search<'_, V> {
    /// A node, and for a Voronoi choice the random configurations (one for each robot) that it is near to.
    pub fn select(&mut self, values: &mut SampleValues) -> (NodeId, Option<Vec<Vec<f64>>>) {
        let draw = values.next_unit();
        if draw < 0.6 {
            let vector = self.advanced_vector(values);
            return (self.promising_node(vector, values), None);
        }
        let vectors: Vec<VectorId> = self.tree.vectors().collect();
        let vector = vectors[values.next_index(vectors.len())];
        if draw < 0.8 {
            return (self.uniform_node(vector, values), None);
        }
        let target = self.random_configurations(vector, values);
        (self.nearest_node(vector, &target, values), Some(target))
    }

    /// The most advanced mode vector with probability 1/2, the second with 1/4, and so on. Vectors that have been tried
    /// for long fall behind.
    fn advanced_vector(&self, values: &mut SampleValues) -> VectorId {
        let rank = |vector: &VectorId| {
            let tried = self.tried.get(vector).copied().unwrap_or(0) / PATIENCE;
            i64::from(self.rules.vectors.get(*vector).advance) - i64::from((1 + tried).ilog2())
        };
        let mut vectors: Vec<(i64, VectorId)> = self.tree.vectors().map(|vector| (-rank(&vector), vector)).collect();
        let mut skipped = 0;
        while skipped + 1 < vectors.len() && values.next_unit() >= 0.5 {
            skipped += 1;
        }
        vectors.select_nth_unstable(skipped).1.1
    }

    fn uniform_node(&self, vector: VectorId, values: &mut SampleValues) -> NodeId {
        let nodes = self.tree.in_vector(vector);
        nodes[values.next_index(nodes.len())]
    }

    /// Half the time any node, else the nearest to the goals of four.
    fn promising_node(&self, vector: VectorId, values: &mut SampleValues) -> NodeId {
        let mut best = self.uniform_node(vector, values);
        if values.next_unit() < 0.5 {
            return best;
        }
        for _ in 0..3 {
            let other = self.uniform_node(vector, values);
            let to_go = |node: NodeId| self.rules.total_to_go_s(&self.tree.get(node).state);
            if to_go(other) < to_go(best) {
                best = other;
            }
        }
        best
    }

    fn random_configurations(&self, vector: VectorId, values: &mut SampleValues) -> Vec<Vec<f64>> {
        let phases = &self.rules.vectors.get(vector).phases;
        let random = |(robot, phase): (usize, &u32)| {
            let usable = &self.rules.roadmap.phase(robot, *phase).usable;
            let usable: Vec<usize> = (0..usable.len()).filter(|v| usable[*v]).collect();
            let vertices = &self.rules.roadmap.graph(robot, *phase).roadmap.vertices;
            vertices[usable[values.next_index(usable.len())]].clone()
        };
        phases.iter().enumerate().map(random).collect()
    }

    fn nearest_node(&self, vector: VectorId, target: &[Vec<f64>], values: &mut SampleValues) -> NodeId {
        let nodes = self.tree.in_vector(vector);
        let phases = &self.rules.vectors.get(vector).phases;
        let distance = |node: NodeId| -> f64 {
            let vertices = &self.tree.get(node).state.vertices;
            let apart = |robot: usize| {
                let graph = self.rules.roadmap.graph(robot, phases[robot]);
                let here = &graph.roadmap.vertices[vertices[robot].index()];
                let model = &self.rules.roadmap.problem.robots[robot];
                model.duration(here, &model.short_way(here, &target[robot]))
            };
            (0..target.len()).map(apart).sum()
        };
        let mut best = (f64::INFINITY, nodes[0]);
        for i in 0..nodes.len().min(CANDIDATES) {
            let node = if nodes.len() <= CANDIDATES { nodes[i] } else { nodes[values.next_index(nodes.len())] };
            let distance = distance(node);
            if distance < best.0 {
                best = (distance, node);
            }
        }
        best.1
    }
}
