//! Safe-interval search of one robot on one mode's roadmap, against everything committed.
//!
//! Phillips and Likhachev, SIPP, ICRA 2011, doi:10.1109/ICRA.2011.5980306, on continuous time: a state is a vertex and one
//! of its safe intervals; the earliest arrival in it is as good as any later one, for the robot may wait there. Edges have
//! fixed durations; who waits, waits at a vertex. The search is complete on the roadmap.

mod graph;
mod traffic;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use contract::VertexId;

pub(crate) use graph::{Hop, ModeGraph};
use traffic::Nearby;
pub(crate) use traffic::{Blocker, SafeInterval, Traffic};

use crate::{Conflicts, Travel};

/// Times (s) before which the robot may not do some things: the last cell before them may not begin earlier, for an arc
/// of the plan can hold a robot only at a cell's boundary. Minus infinity where nothing is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gates {
    /// Come to the goal.
    pub goal_s: f64,
    /// Fold the arm.
    pub fold_s: f64,
    /// Come to the goal's stand.
    pub arrive_s: f64,
}

impl Gates {
    pub const OPEN: Self = Self { goal_s: f64::NEG_INFINITY, fold_s: f64::NEG_INFINITY, arrive_s: f64::NEG_INFINITY };
}

/// A vertex in one of its safe intervals, at the earliest time known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State {
    pub vertex: VertexId,
    pub interval: usize,
    pub time_s: f64,
    /// The state before it, the way from there, and when it set out.
    came: Option<(usize, Hop, f64)>,
}

/// One motion of a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub hop: Hop,
    pub departs_s: f64,
    pub arrives_s: f64,
}

/// An edge as [`Traffic`] sees it, in its own direction.
struct KnownEdge {
    travel: Travel,
    nearby: Nearby,
}

/// Open states: least bound on the time of arrival first, then latest in time, then oldest.
type Entry = Reverse<(u64, Reverse<u64>, usize)>;

/// A search in progress.
pub(crate) struct Search<'a> {
    graph: &'a ModeGraph<'a>,
    traffic: &'a Traffic<'a>,
    conflicts: &'a Conflicts,
    gates: Gates,
    /// Bound on the time from each vertex (s); vertices where it is infinite are left out.
    bound_s: Vec<f64>,
    states: Vec<State>,
    open: BinaryHeap<Entry>,
    earliest_s: Vec<Vec<f64>>,
    safe: Vec<Option<Vec<SafeInterval>>>,
    edges: Vec<Option<KnownEdge>>,
}

impl<'a> Search<'a> {
    /// A search from `start` at `begins_s` (s), where the robot has stood since `since_s`. Without a safe interval that
    /// contains both it finds nothing.
    pub fn new(
        graph: &'a ModeGraph<'a>,
        traffic: &'a Traffic<'a>,
        conflicts: &'a Conflicts,
        gates: Gates,
        bound_s: Vec<f64>,
        (start, since_s, begins_s): (VertexId, f64, f64),
    ) -> Self {
        let mut search = Self {
            graph,
            traffic,
            conflicts,
            gates,
            bound_s,
            states: Vec::new(),
            open: BinaryHeap::new(),
            earliest_s: vec![Vec::new(); graph.len()],
            safe: vec![None; graph.len()],
            edges: (0..graph.roadmap.edges.len()).map(|_| None).collect(),
        };
        let both = |interval: &SafeInterval| interval.contains(since_s) && interval.contains(begins_s);
        let interval = search.safe(start).iter().position(both);
        if let Some(interval) = interval {
            search.push(State { vertex: start, interval, time_s: begins_s, came: None });
        }
        search
    }

    /// The state with the least bound, and everything that follows from it is opened. `None`: there is no more.
    pub fn next(&mut self) -> Option<usize> {
        while let Some(Reverse((_, _, index))) = self.open.pop() {
            let state = self.states[index];
            if state.time_s <= self.earliest_s[state.vertex.index()][state.interval] {
                self.expand(index);
                return Some(index);
            }
        }
        None
    }

    pub fn state(&self, index: usize) -> State {
        self.states[index]
    }

    /// The safe interval of a state.
    pub fn interval(&self, state: &State) -> SafeInterval {
        let intervals = self.safe[state.vertex.index()].as_ref();
        let empty = SafeInterval { from_s: f64::INFINITY, until_s: f64::NEG_INFINITY };
        intervals.and_then(|intervals| intervals.get(state.interval)).copied().unwrap_or(empty)
    }

    /// The motions that lead to a state.
    pub fn path(&self, index: usize) -> Vec<Step> {
        let mut steps = Vec::new();
        let mut state = self.states[index];
        while let Some((before, hop, departs_s)) = state.came {
            steps.push(Step { hop, departs_s, arrives_s: state.time_s });
            state = self.states[before];
        }
        steps.reverse();
        steps
    }

    fn push(&mut self, state: State) {
        let known = &mut self.earliest_s[state.vertex.index()];
        if known.len() <= state.interval {
            known.resize(state.interval + 1, f64::INFINITY);
        }
        let bound = state.time_s + self.bound_s[state.vertex.index()];
        if state.time_s < known[state.interval] && bound < f64::INFINITY {
            known[state.interval] = state.time_s;
            // Bits of non-negative numbers order as the numbers do.
            self.open.push(Reverse((bound.to_bits(), Reverse(state.time_s.to_bits()), self.states.len())));
            self.states.push(state);
        }
    }

    fn safe(&mut self, vertex: VertexId) -> &[SafeInterval] {
        let (graph, conflicts, traffic) = (self.graph, self.conflicts, self.traffic);
        self.safe[vertex.index()].get_or_insert_with(|| traffic.safe_intervals(&graph.stand(vertex, conflicts)))
    }

    fn expand(&mut self, index: usize) {
        let state = self.states[index];
        let leaves_by_s = self.interval(&state).until_s;
        let graph = self.graph;
        for hop in graph.hops(state.vertex) {
            if self.bound_s[hop.to.index()] == f64::INFINITY {
                continue;
            }
            let duration_s = graph.duration_s(hop.edge);
            let from_s = state.time_s.max(self.gate_s(state.vertex, hop, duration_s));
            for (interval, target) in self.safe(hop.to).to_vec().into_iter().enumerate() {
                let window = self.window(target, duration_s, (from_s, leaves_by_s));
                if window.0 > leaves_by_s {
                    break;
                }
                if let Some(departs_s) = self.departure(hop, duration_s, window) {
                    let came = Some((index, *hop, departs_s));
                    self.push(State { vertex: hop.to, interval, time_s: departs_s + duration_s, came });
                }
            }
        }
    }

    /// Times of departure that lead into a safe interval.
    fn window(&self, target: SafeInterval, duration_s: f64, (from_s, until_s): (f64, f64)) -> (f64, f64) {
        let enter_s = if target.from_s > from_s + duration_s { target.entrance_s() } else { target.from_s };
        (from_s.max(enter_s - duration_s), until_s.min(target.until_s - duration_s))
    }

    fn departure(&mut self, hop: &Hop, duration_s: f64, window: (f64, f64)) -> Option<f64> {
        if window.0 > window.1 {
            return None;
        }
        self.know(hop.edge);
        let known = self.edges[hop.edge].as_ref()?;
        let travel = if hop.forward { known.travel } else { known.travel.back() };
        self.traffic.earliest_departure(&travel, &known.nearby, duration_s, window)
    }

    fn know(&mut self, edge: usize) {
        if self.edges[edge].is_none() {
            let travel = self.conflicts.travel(&self.graph.motion(edge));
            self.edges[edge] = Some(KnownEdge { travel, nearby: self.traffic.nearby(&travel) });
        }
    }

    /// Before when (s) the gates do not let the robot set out.
    fn gate_s(&mut self, from: VertexId, hop: &Hop, duration_s: f64) -> f64 {
        let graph = self.graph;
        let mut last_cell_s = f64::NEG_INFINITY;
        if hop.to == graph.roadmap.goal {
            last_cell_s = last_cell_s.max(self.gates.goal_s);
        }
        if self.gates.fold_s > f64::NEG_INFINITY && graph.is_folded(hop.to) && !graph.is_folded(from) {
            last_cell_s = last_cell_s.max(self.gates.fold_s);
        }
        let arrives = || graph.same_stand(hop.to, graph.roadmap.goal) && !graph.same_stand(from, hop.to);
        if self.gates.arrive_s > f64::NEG_INFINITY && arrives() {
            last_cell_s = last_cell_s.max(self.gates.arrive_s);
        }
        if last_cell_s == f64::NEG_INFINITY {
            return last_cell_s;
        }
        self.know(hop.edge);
        let cells = self.edges[hop.edge].as_ref().map_or(1, |known| known.travel.cells);
        last_cell_s - duration_s * (f64::from(cells - 1) / f64::from(cells))
    }
}
