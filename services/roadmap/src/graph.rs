//! Shortest and least obstructed ways on a roadmap under construction.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use contract::Edge;

/// A total order on times, for heaps.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seconds(f64);

impl Eq for Seconds {}

impl PartialOrd for Seconds {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Seconds {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Neighbours of every vertex: (edge, other end).
pub(crate) fn adjacency(vertices: usize, edges: &[Edge]) -> Vec<Vec<(usize, usize)>> {
    let mut neighbours = vec![Vec::new(); vertices];
    for (i, edge) in edges.iter().enumerate() {
        neighbours[edge.a.index()].push((i, edge.b.index()));
        neighbours[edge.b.index()].push((i, edge.a.index()));
    }
    neighbours
}

/// Least time from every vertex to `goal` (s); infinite where there is no way. Annotations are ignored.
pub(crate) fn cost_to_go(vertices: usize, edges: &[Edge], goal: usize) -> Vec<f64> {
    let neighbours = adjacency(vertices, edges);
    let mut cost = vec![f64::INFINITY; vertices];
    cost[goal] = 0.0;
    let mut queue = BinaryHeap::from([Reverse((Seconds(0.0), goal))]);
    while let Some(Reverse((Seconds(reached), vertex))) = queue.pop() {
        if reached > cost[vertex] {
            continue;
        }
        for (edge, next) in &neighbours[vertex] {
            let through = reached + edges[*edge].duration_s;
            if through < cost[*next] {
                cost[*next] = through;
                queue.push(Reverse((Seconds(through), *next)));
            }
        }
    }
    cost
}

/// Blockers on a way from `start` to `goal` with few distinct blockers, then short. Greedy minimum constraint removal
/// (Hauser, doi:10.1177/0278364913507795): exact where every vertex's best set extends to the goal's. `None`: no way at all.
pub(crate) fn least_blockers(vertices: usize, edges: &[Edge], start: usize, goal: usize) -> Option<BTreeSet<u32>> {
    let neighbours = adjacency(vertices, edges);
    let mut best: Vec<Option<(usize, Seconds)>> = vec![None; vertices];
    let mut queue = BinaryHeap::from([Reverse((0_usize, Seconds(0.0), start, BTreeSet::new()))]);
    while let Some(Reverse((count, Seconds(reached), vertex, blockers))) = queue.pop() {
        if best[vertex].is_some_and(|known| known <= (count, Seconds(reached))) {
            continue;
        }
        best[vertex] = Some((count, Seconds(reached)));
        if vertex == goal {
            return Some(blockers);
        }
        for (edge, next) in &neighbours[vertex] {
            let mut set = blockers.clone();
            set.extend(&edges[*edge].blockers);
            queue.push(Reverse((set.len(), Seconds(reached + edges[*edge].duration_s), *next, set)));
        }
    }
    None
}
