//! The event graph: a strict partial order on events with incremental closure and undo.

use model::{GivenOrdering, Point, Problem, RobotId};
use serde::{Deserialize, Serialize};

use crate::Event;

/// Where an arc comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ArcOrigin {
    /// Points of one pair, or consecutive pairs of one robot.
    Robot,
    /// Consecutive hops of one object.
    Object,
    /// Listed in the problem.
    Given,
    /// Found by the geometry.
    Discovered,
}

/// `before` happens strictly before `after`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Arc {
    /// What comes first.
    pub before: Event,
    /// What comes later.
    pub after: Event,
    /// Where it comes from.
    pub origin: ArcOrigin,
}

/// Arcs that would close a cycle, in order round it; the refused arc is the last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cycle(pub Vec<Arc>);

/// A state of the graph to which it can be taken back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checkpoint {
    arcs: usize,
    trail: usize,
}

/// Strict partial order on the events of a problem. The closure is a bit matrix; an arc costs O(n²/64).
#[derive(Clone, Debug)]
pub struct EventGraph {
    nodes: usize,
    words: usize,
    /// `after[node * words ..]`: the nodes strictly after `node`.
    after: Vec<u64>,
    arcs: Vec<Arc>,
    trail: Vec<(usize, u64)>,
}

impl EventGraph {
    /// A graph on the events of `pairs` pairs with no order at all.
    #[must_use]
    pub fn unordered(pairs: usize) -> Self {
        let nodes = pairs * Point::ALL.len();
        let words = nodes.div_ceil(64);
        Self { nodes, words, after: vec![0; nodes * words], arcs: Vec::new(), trail: Vec::new() }
    }

    /// The order that a problem gives: each robot's pairs in order, each object's hops, the listed orderings, and what its
    /// gate makes of them.
    ///
    /// # Errors
    /// The first cycle met.
    pub fn of_problem(problem: &Problem) -> Result<Self, Cycle> {
        let mut graph = Self::unordered(problem.pairs.len());
        for robot in 0..problem.robots.len() {
            graph.add_robot_chain(problem, RobotId::at(robot))?;
        }
        for object in 0..problem.movable.len() {
            for hops in problem.hops_of_object(model::ObjectId::at(object)).windows(2) {
                let (before, after) = ((hops[0], Point::Release), (hops[1], Point::Grasp));
                graph.add_gated(problem, GivenOrdering { before, after }, ArcOrigin::Object)?;
            }
        }
        for ordering in &problem.orderings {
            graph.add_gated(problem, *ordering, ArcOrigin::Given)?;
        }
        Ok(graph)
    }

    /// Adds an ordering, and that of the whole actions, if the problem's gate wants it.
    fn add_gated(&mut self, problem: &Problem, ordering: GivenOrdering, origin: ArcOrigin) -> Result<(), Cycle> {
        for GivenOrdering { before, after } in [Some(ordering), problem.gated(ordering)].into_iter().flatten() {
            self.add(Event::new(before.0, before.1), Event::new(after.0, after.1), origin)?;
        }
        Ok(())
    }

    fn add_robot_chain(&mut self, problem: &Problem, robot: RobotId) -> Result<(), Cycle> {
        let chain: Vec<Event> =
            problem.pairs_of_robot(robot).flat_map(|pair| Point::ALL.map(|point| Event::new(pair, point))).collect();
        for step in chain.windows(2) {
            self.add(step[0], step[1], ArcOrigin::Robot)?;
        }
        Ok(())
    }

    /// Whether `a` happens strictly before `b` in every execution.
    #[must_use]
    pub fn precedes(&self, a: Event, b: Event) -> bool {
        self.reaches(a.node(), b.node())
    }

    /// `a` ≼ `b`.
    #[must_use]
    pub fn precedes_or_is(&self, a: Event, b: Event) -> bool {
        a == b || self.precedes(a, b)
    }

    /// All arcs in the order in which they were added.
    #[must_use]
    pub fn arcs(&self) -> &[Arc] {
        &self.arcs
    }

    /// Adds an ordering. One that follows already is recorded all the same.
    ///
    /// # Errors
    /// The cycle it would close; the graph is then as before.
    pub fn add(&mut self, before: Event, after: Event, origin: ArcOrigin) -> Result<(), Cycle> {
        let arc = Arc { before, after, origin };
        let (u, v) = (before.node(), after.node());
        if u == v || self.reaches(v, u) {
            let mut arcs = self.path(v, u);
            arcs.push(arc);
            return Err(Cycle(arcs));
        }
        self.arcs.push(arc);
        if !self.reaches(u, v) {
            for x in (0..self.nodes).filter(|x| *x == u || self.reaches(*x, u)).collect::<Vec<_>>() {
                self.join(x, v);
            }
        }
        Ok(())
    }

    /// The present state, for [`EventGraph::undo`].
    #[must_use]
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint { arcs: self.arcs.len(), trail: self.trail.len() }
    }

    /// Takes back every arc added since `checkpoint`.
    pub fn undo(&mut self, checkpoint: Checkpoint) {
        while self.trail.len() > checkpoint.trail {
            if let Some((word, old)) = self.trail.pop() {
                self.after[word] = old;
            }
        }
        self.arcs.truncate(checkpoint.arcs);
    }

    /// Discovered arcs because of which `a` ≼ `b`: as few as one way from `a` to `b` can have.
    #[must_use]
    pub fn discovered_between(&self, a: Event, b: Event) -> Vec<(Event, Event)> {
        let mut least: Vec<Option<(usize, Option<usize>)>> = vec![None; self.nodes];
        least[a.node()] = Some((0, None));
        let mut queue = std::collections::VecDeque::from([(0, a.node())]);
        while let Some((cost, node)) = queue.pop_front() {
            if least[node].is_some_and(|(known, _)| known < cost) {
                continue;
            }
            for (index, arc) in self.arcs.iter().enumerate().filter(|(_, arc)| arc.before.node() == node) {
                let is_discovered = arc.origin == ArcOrigin::Discovered;
                let (next, cost) = (arc.after.node(), cost + usize::from(is_discovered));
                if least[next].is_none_or(|(known, _)| cost < known) {
                    least[next] = Some((cost, Some(index)));
                    if is_discovered { queue.push_back((cost, next)) } else { queue.push_front((cost, next)) }
                }
            }
        }
        let (mut arcs, mut node) = (Vec::new(), b.node());
        while let Some((_, Some(index))) = least[node] {
            let arc = self.arcs[index];
            arcs.extend((arc.origin == ArcOrigin::Discovered).then_some((arc.before, arc.after)));
            node = arc.before.node();
        }
        arcs.reverse();
        arcs
    }

    fn reaches(&self, from: usize, to: usize) -> bool {
        self.after[from * self.words + to / 64] >> (to % 64) & 1 == 1
    }

    /// Everything at or after `to` is now after `from`.
    fn join(&mut self, from: usize, to: usize) {
        for word in 0..self.words {
            let itself = if to / 64 == word { 1 << (to % 64) } else { 0 };
            let joined = self.after[from * self.words + word] | self.after[to * self.words + word] | itself;
            let old = std::mem::replace(&mut self.after[from * self.words + word], joined);
            if old != joined {
                self.trail.push((from * self.words + word, old));
            }
        }
    }

    /// Arcs of a shortest path between two nodes; empty if they are one.
    fn path(&self, from: usize, to: usize) -> Vec<Arc> {
        let mut reached_by: Vec<Option<usize>> = vec![None; self.nodes];
        let mut queue = std::collections::VecDeque::from([from]);
        while let Some(node) = queue.pop_front() {
            for (index, arc) in self.arcs.iter().enumerate().filter(|(_, arc)| arc.before.node() == node) {
                let next = arc.after.node();
                if next != from && reached_by[next].is_none() {
                    reached_by[next] = Some(index);
                    queue.push_back(next);
                }
            }
        }
        let mut arcs = Vec::new();
        let mut node = to;
        while let (true, Some(index)) = (node != from, reached_by[node]) {
            arcs.push(self.arcs[index]);
            node = self.arcs[index].before.node();
        }
        arcs.reverse();
        arcs
    }

    /// All events, in node order.
    pub fn events(&self) -> impl Iterator<Item = Event> + use<> {
        (0..self.nodes).map(Event::of_node)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use model::PairId;

    fn event(pair: usize, point: Point) -> Event {
        Event::new(PairId::at(pair), point)
    }

    #[test]
    fn an_arc_that_would_close_a_cycle_is_refused_and_names_the_cycle() {
        let mut graph = EventGraph::unordered(3);
        let (a, b, c) = (event(0, Point::Grasp), event(1, Point::Release), event(2, Point::Grasp));
        graph.add(a, b, ArcOrigin::Given).unwrap();
        graph.add(b, c, ArcOrigin::Given).unwrap();
        let Cycle(arcs) = graph.add(c, a, ArcOrigin::Discovered).unwrap_err();
        let around: Vec<(Event, Event)> = arcs.iter().map(|arc| (arc.before, arc.after)).collect();
        assert_eq!(around, [(a, b), (b, c), (c, a)]);
        assert!(graph.precedes(a, c) && !graph.precedes(c, a));
        assert_eq!(graph.add(a, a, ArcOrigin::Given).unwrap_err().0.len(), 1);
    }

    #[test]
    fn closure_equals_that_of_repeated_search_and_undo_restores_it() {
        let mut state = 7_u64;
        let mut next = move |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            usize::try_from((state >> 33) % n).unwrap()
        };
        for round in 0..200 {
            let mut graph = EventGraph::unordered(4);
            let events: Vec<Event> = graph.events().collect();
            let mut marks = vec![(graph.checkpoint(), graph.after.clone())];
            for _ in 0..30 {
                let (u, v) = (events[next(28)], events[next(28)]);
                let refused = graph.add(u, v, ArcOrigin::Given).is_err();
                let closure = searched_closure(&graph);
                assert_eq!(graph.after, closure, "round {round}");
                assert_eq!(refused, u == v || closure[v.node()] >> u.node() & 1 == 1, "round {round}");
                marks.push((graph.checkpoint(), graph.after.clone()));
            }
            for (mark, after) in marks.iter().rev() {
                graph.undo(*mark);
                assert_eq!(&graph.after, after, "round {round}");
            }
        }
    }

    #[test]
    fn discovered_arcs_between_two_events_suffice_and_no_fewer_would() {
        let mut state = 23_u64;
        let mut next = move |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            usize::try_from((state >> 33) % n).unwrap()
        };
        let mut lengths = [0; 4];
        for round in 0..400 {
            let mut graph = EventGraph::unordered(2);
            let events: Vec<Event> = graph.events().collect();
            for i in 0..14 {
                let origin = if i < 7 { ArcOrigin::Discovered } else { ArcOrigin::Given };
                let _ = graph.add(events[next(14)], events[next(14)], origin);
            }
            let (a, b) = (events[next(14)], events[next(14)]);
            let found = graph.discovered_between(a, b);
            if !graph.precedes(a, b) {
                assert_eq!(found, [], "round {round}");
                continue;
            }
            let discovered: Vec<Arc> =
                graph.arcs.iter().filter(|arc| arc.origin == ArcOrigin::Discovered).copied().collect();
            let precedes_with = |kept: &dyn Fn(&Arc) -> bool| {
                let mut fewer = EventGraph::unordered(2);
                for arc in graph.arcs.iter().filter(|arc| arc.origin != ArcOrigin::Discovered || kept(arc)) {
                    fewer.add(arc.before, arc.after, arc.origin).unwrap();
                }
                fewer.precedes(a, b)
            };
            assert!(found.iter().all(|o| discovered.iter().any(|arc| (arc.before, arc.after) == *o)), "round {round}");
            assert!(precedes_with(&|arc| found.contains(&(arc.before, arc.after))), "round {round}");
            for subset in 0_u32..1 << discovered.len() {
                let kept = |arc: &Arc| discovered.iter().position(|d| d == arc).is_some_and(|i| subset >> i & 1 == 1);
                let is_enough = (subset.count_ones() as usize) < found.len() && precedes_with(&kept);
                assert!(!is_enough, "round {round}: {found:?} is not the least");
            }
            lengths[found.len().min(3)] += 1;
        }
        assert!(lengths[0] > 20 && lengths[1] > 20 && lengths[2] > 5, "{lengths:?}");
    }

    fn searched_closure(graph: &EventGraph) -> Vec<u64> {
        (0..graph.nodes)
            .map(|start| {
                let (mut seen, mut stack) = (0_u64, vec![start]);
                while let Some(node) = stack.pop() {
                    for arc in graph.arcs.iter().filter(|arc| arc.before.node() == node) {
                        let next = arc.after.node();
                        if seen >> next & 1 == 0 {
                            seen |= 1 << next;
                            stack.push(next);
                        }
                    }
                }
                seen
            })
            .collect()
    }
}
