//! Contradictions: pairs of objects that collide wherever they stand in a region must be there one after the other, and
//! whichever way round that is done, the orders close a cycle.

use std::collections::BTreeSet;

use model::Problem;
use plan::{Cause, Certificate, CycleArc, CycleOrigin, Exclusion};
use skeleton::{Arc, ArcOrigin, Cycle, EventGraph};

use crate::guests::Guests;
use crate::layout::Layout;
use crate::report;

/// Branchings after which the search for a contradiction is given up.
const MOST_BRANCHINGS: u32 = 2_000;

/// Proves that no order keeps apart all pairs that need it.
pub(crate) fn contradiction(problem: &Problem, layout: &Layout) -> Option<(Vec<Cause>, Certificate)> {
    let pairs = always_colliding(problem, layout);
    let mut search = Search { layout, pairs: &pairs, steps: Vec::new(), branchings: 0 };
    if !search.refutes(&mut layout.graph.clone()) {
        return None;
    }
    let (blamed, cycles) = search.needed_steps();
    let sites = [pairs[blamed].sites.0, pairs[blamed].sites.1].map(|site| &layout.sites[site]);
    let placed = sites.into_iter().filter_map(|site| report::no_placement(problem, site));
    let causes = placed.chain(cycles.last().map(|cycle| report::cycle(problem, cycle))).collect();
    Some((causes, certificate(problem, layout, &pairs, &cycles)))
}

/// Proves that the given order itself is none.
pub(crate) fn given_cycle(problem: &Problem, cycle: &Cycle) -> (Vec<Cause>, Certificate) {
    let arcs = joined(&cycle.0).map(|arc| cycle_arc(problem, &arc, |_| 0)).collect();
    (vec![report::cycle(problem, cycle)], Certificate::Cycle { exclusions: Vec::new(), cycles: vec![arcs] })
}

/// Two sites of one region that collide wherever the two objects stand in it.
struct Pair {
    sites: (usize, usize),
    exclusion: Exclusion,
}

fn always_colliding(problem: &Problem, layout: &Layout) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for guests in Guests::of_regions(problem, layout) {
        let region = problem.regions[guests.region.index()].name.clone();
        for (i, first) in guests.sites.iter().enumerate() {
            for second in &guests.sites[..i] {
                if layout.neighbours[first.0].contains(&second.0) && guests.exceed(first.1 + second.1) {
                    let stays = [*first, *second].map(|guest| Guests::cover(problem, layout, guest));
                    let (region, region_area_m2) = (region.clone(), guests.region_area_m2);
                    let exclusion = Exclusion { region, region_area_m2, stays };
                    pairs.push(Pair { sites: (first.0, second.0), exclusion });
                }
            }
        }
    }
    pairs
}

/// Searches for an order on events that keeps every pair apart, and notes why it fails.
struct Search<'a> {
    layout: &'a Layout,
    pairs: &'a [Pair],
    steps: Vec<Step>,
    branchings: u32,
}

/// What was found out about a pair.
enum Step {
    /// One way round closes a cycle.
    Forced { pair: usize, cycle: Cycle },
    /// Every way round closes a cycle.
    Refuted { pair: usize, cycles: Vec<Cycle> },
}

/// What putting one site before another does.
enum Way {
    /// It cannot be: one is there from the start, or the other never leaves.
    None,
    /// It closes a cycle.
    Closes(Cycle),
    /// It is possible.
    Open,
}

impl Search<'_> {
    /// Whether no way round was found for all pairs; `false` also when the search is given up.
    fn refutes(&mut self, graph: &mut EventGraph) -> bool {
        loop {
            let (mut open, mut forced) = (None, false);
            for pair in 0..self.pairs.len() {
                let (a, b) = self.pairs[pair].sites;
                if !self.layout.may_coexist(graph, a, b) {
                    continue;
                }
                match [(a, b), (b, a)].map(|(first, second)| self.way(graph, first, second)) {
                    // Two that both stay for ever are no contradiction of orders.
                    [Way::None, Way::None] => {}
                    [Way::Open, Way::Open] => open = open.or(Some(pair)),
                    [Way::Open, blocked] | [blocked, Way::Open] => {
                        forced = true;
                        self.force(graph, pair, blocked);
                    }
                    blocked => {
                        let cycles = blocked.into_iter().filter_map(Way::cycle).collect();
                        self.steps.push(Step::Refuted { pair, cycles });
                        return true;
                    }
                }
            }
            if !forced {
                return open.is_some_and(|pair| self.refutes_both_ways(graph, pair));
            }
        }
    }

    fn refutes_both_ways(&mut self, graph: &mut EventGraph, pair: usize) -> bool {
        self.branchings += 1;
        let (a, b) = self.pairs[pair].sites;
        self.branchings <= MOST_BRANCHINGS
            && [(a, b), (b, a)].into_iter().all(|(first, second)| {
                let checkpoint = graph.checkpoint();
                self.add(graph, first, second);
                let refuted = self.refutes(graph);
                graph.undo(checkpoint);
                refuted
            })
    }

    fn force(&mut self, graph: &mut EventGraph, pair: usize, blocked: Way) {
        let (a, b) = self.pairs[pair].sites;
        if !self.add(graph, a, b) {
            self.add(graph, b, a);
        }
        if let Some(cycle) = blocked.cycle() {
            self.steps.push(Step::Forced { pair, cycle });
        }
    }

    fn way(&self, graph: &mut EventGraph, first: usize, second: usize) -> Way {
        let Some((before, after)) = self.layout.order_events(first, second) else { return Way::None };
        let checkpoint = graph.checkpoint();
        let added = graph.add(before, after, ArcOrigin::Discovered);
        graph.undo(checkpoint);
        added.map_or_else(Way::Closes, |()| Way::Open)
    }

    /// Adds an order, if it closes no cycle.
    fn add(&self, graph: &mut EventGraph, first: usize, second: usize) -> bool {
        let events = self.layout.order_events(first, second);
        events.is_some_and(|(before, after)| graph.add(before, after, ArcOrigin::Discovered).is_ok())
    }

    /// The pair refuted last, and the cycles on which the refutations rest, in the order in which they were met.
    fn needed_steps(&self) -> (usize, Vec<Cycle>) {
        let (mut blamed, mut needed, mut cycles) = (0, BTreeSet::new(), Vec::new());
        for step in self.steps.iter().rev() {
            let kept = match step {
                Step::Forced { pair, cycle } if needed.contains(pair) => vec![cycle.clone()],
                Step::Forced { .. } => continue,
                Step::Refuted { pair, cycles } => {
                    blamed = if needed.is_empty() { *pair } else { blamed };
                    needed.insert(*pair);
                    cycles.clone()
                }
            };
            needed.extend(kept.iter().flat_map(|cycle| self.pairs_on(cycle)));
            cycles.extend(kept);
        }
        cycles.reverse();
        (blamed, cycles)
    }

    fn pairs_on(&self, cycle: &Cycle) -> Vec<usize> {
        let discovered = cycle.0.iter().filter(|arc| arc.origin == ArcOrigin::Discovered);
        discovered.filter_map(|arc| pair_of(self.layout, self.pairs, arc)).collect()
    }
}

impl Way {
    fn cycle(self) -> Option<Cycle> {
        if let Self::Closes(cycle) = self { Some(cycle) } else { None }
    }
}

/// The pair that an arc keeps apart.
fn pair_of(layout: &Layout, pairs: &[Pair], arc: &Arc) -> Option<usize> {
    let keeps_apart = |(a, b)| {
        let events = Some((arc.before, arc.after));
        layout.order_events(a, b) == events || layout.order_events(b, a) == events
    };
    pairs.iter().position(|pair| keeps_apart(pair.sites))
}

/// Only the exclusions on the cycles are listed, in the order in which they are met there.
fn certificate(problem: &Problem, layout: &Layout, pairs: &[Pair], cycles: &[Cycle]) -> Certificate {
    let mut listed: Vec<usize> = Vec::new();
    let arcs = cycles.iter().map(|cycle| {
        let number = |arc: &Arc| {
            let pair = pair_of(layout, pairs, arc).unwrap_or(0);
            listed.iter().position(|other| *other == pair).unwrap_or_else(|| {
                listed.push(pair);
                listed.len() - 1
            })
        };
        let mut number = number;
        joined(&cycle.0).map(|arc| cycle_arc(problem, &arc, &mut number)).collect()
    });
    let cycles = arcs.collect();
    Certificate::Cycle { exclusions: listed.into_iter().map(|pair| pairs[pair].exclusion.clone()).collect(), cycles }
}

/// The arcs round a cycle, a robot's consecutive ones as one.
fn joined(arcs: &[Arc]) -> impl Iterator<Item = Arc> {
    let mut joined: Vec<Arc> = Vec::new();
    for arc in arcs {
        match joined.last_mut() {
            Some(last) if last.origin == ArcOrigin::Robot && arc.origin == ArcOrigin::Robot => last.after = arc.after,
            _ => joined.push(*arc),
        }
    }
    joined.into_iter()
}

fn cycle_arc(problem: &Problem, arc: &Arc, mut exclusion: impl FnMut(&Arc) -> usize) -> CycleArc {
    let origin = match arc.origin {
        ArcOrigin::Robot => CycleOrigin::Robot,
        ArcOrigin::Object => CycleOrigin::Object,
        ArcOrigin::Given => CycleOrigin::Given,
        ArcOrigin::Discovered => CycleOrigin::Excluded { exclusion: exclusion(arc) as u32 },
    };
    CycleArc { before: report::point(problem, arc.before), after: report::point(problem, arc.after), origin }
}
