//! All placements in canonical order: fewest orders first, then least effort, then lexicographically.
//!
//! The tree of order sets is grown layer by layer. Under each set the poses form a finite constraint network: what may be
//! there at the same time must not collide; what an added order keeps apart must collide, else that order is not forced.
//! A set without a solution is extended only by orders that could keep apart a pair among the sites at fault, so that
//! orders appear where the geometry asks for them; a set with solutions is extended by every order, after the layer.

use std::collections::BTreeSet;

use contract::CauseTally;
use model::Problem;
use skeleton::EventGraph;

use crate::bits::{self, BitRows};
use crate::layer::{Layer, Solved};
use crate::layout::{Layout, Order};
use crate::network::{Network, Overlaps, Relation, Stop};
use crate::nogoods::Nogoods;
use crate::refute::sites_at_fault;
use crate::report;

/// A lazy enumeration over the samples of one level.
pub(crate) struct Enumeration<'a> {
    problem: &'a Problem,
    layout: &'a Layout,
    domains: &'a BitRows,
    nogoods: Nogoods,
    /// Sets of orders of the present layer, ascending, with what is known of each.
    sets: Vec<(Vec<usize>, Verdict)>,
    layer: Layer,
    begun: bool,
    /// Sites that some refutation speaks of.
    at_fault: BTreeSet<usize>,
    causes: CauseTally,
}

/// What is known of a set of orders.
enum Verdict {
    /// There are solutions.
    Solvable,
    /// No solution, because these pairs of sites cannot all stay apart.
    Crowded(Vec<(usize, usize)>),
    /// Neither it nor any larger set has a solution.
    Hopeless,
}

impl<'a> Enumeration<'a> {
    pub fn new(problem: &'a Problem, layout: &'a Layout, domains: &'a BitRows, nogoods: Nogoods) -> Self {
        let (sets, at_fault, causes) = (Vec::new(), BTreeSet::new(), CauseTally::default());
        Self { problem, layout, domains, nogoods, sets, layer: Layer::default(), begun: false, at_fault, causes }
    }

    /// The next candidate; `None` when every combination has been given out.
    pub fn next(&mut self, overlaps: &mut dyn Overlaps) -> Result<Option<Solved>, Stop> {
        loop {
            if let Some(solved) = self.layer.next(overlaps)? {
                return Ok(Some(solved));
            }
            let sets = if self.begun { self.larger_sets() } else { BTreeSet::from([Vec::new()]) };
            self.begun = true;
            if sets.is_empty() {
                return Ok(None);
            }
            self.begin_layer(sets, overlaps)?;
        }
    }

    /// What stood in the way so far; `rejected` says for each site why samples of it are not free.
    pub fn into_causes(mut self, rejected: &[CauseTally]) -> CauseTally {
        for site in self.at_fault {
            self.causes.count_all(&rejected[site].clone().ranked());
        }
        self.causes
    }

    fn begin_layer(&mut self, sets: BTreeSet<Vec<usize>>, overlaps: &mut dyn Overlaps) -> Result<(), Stop> {
        self.layer = Layer::default();
        self.sets.clear();
        for orders in sets {
            let graph = self.layout.graph_with(&orders);
            let verdict = match self.network(&orders, &graph) {
                None => Verdict::Hopeless,
                Some(network) => match sites_at_fault(&network, overlaps)? {
                    Some(sites) => self.crowded(&network, &graph, &sites),
                    None => {
                        self.layer.add(orders.clone(), network, overlaps)?;
                        Verdict::Solvable
                    }
                },
            };
            self.sets.push((orders, verdict));
        }
        Ok(())
    }

    /// The network under a set of orders; `None` if a nogood forbids these orders whatever the poses.
    fn network(&self, orders: &[usize], graph: &EventGraph) -> Option<Network> {
        let mut network = Network::new(self.domains.clone(), self.layout.sites.len());
        for (a, others) in self.layout.neighbours.iter().enumerate() {
            for b in others.iter().copied().filter(|b| a < *b && self.layout.may_coexist(graph, a, *b)) {
                network.link(a, b, Relation::Apart);
            }
        }
        for Order { first, second, .. } in orders.iter().map(|order| self.layout.orders[*order]) {
            network.link(first, second, Relation::Overlapping);
        }
        for banned in self.nogoods.under(graph) {
            if banned.is_empty() {
                return None;
            }
            network.ban(banned);
        }
        Some(network)
    }

    fn crowded(&mut self, network: &Network, graph: &EventGraph, sites: &[u64]) -> Verdict {
        self.at_fault.extend(bits::indices(sites));
        let pairs = network.apart_among(sites);
        for (a, b) in pairs.iter().copied() {
            self.causes.count(report::collision(self.problem, self.layout, a, b));
            for (first, second) in [(a, b), (b, a)] {
                if let Some(cycle) = self.cycle_of(graph, first, second) {
                    self.causes.count(cycle);
                }
            }
        }
        if pairs.is_empty() {
            for site in bits::indices(sites) {
                if let Some(cause) = report::no_placement(self.problem, &self.layout.sites[site]) {
                    self.causes.count(cause);
                }
            }
            return Verdict::Hopeless;
        }
        Verdict::Crowded(pairs)
    }

    fn cycle_of(&self, graph: &EventGraph, first: usize, second: usize) -> Option<plan::Cause> {
        let (before, after) = self.layout.order_events(first, second)?;
        if !graph.precedes_or_is(after, before) {
            return None;
        }
        let refused = graph.clone().add(before, after, skeleton::ArcOrigin::Discovered).err()?;
        Some(report::cycle(self.problem, &refused))
    }

    /// Sets of the next layer: each one order more than a set of this one.
    fn larger_sets(&self) -> BTreeSet<Vec<usize>> {
        let mut larger = BTreeSet::new();
        for (orders, verdict) in &self.sets {
            let wanted: &[(usize, usize)] = match verdict {
                Verdict::Hopeless => continue,
                Verdict::Solvable => &[],
                Verdict::Crowded(pairs) => pairs,
            };
            let graph = self.layout.graph_with(orders);
            for (index, order) in self.layout.orders.iter().enumerate() {
                let helps = wanted.is_empty() || wanted.iter().any(|pair| self.may_part(&graph, order, *pair));
                if helps && self.extends(&graph, orders, order) {
                    let mut set = orders.clone();
                    set.insert(set.partition_point(|other| *other < index), index);
                    larger.insert(set);
                }
            }
        }
        larger
    }

    /// Whether an order is new, closes no cycle, and leaves every order of the set necessary.
    fn extends(&self, graph: &EventGraph, orders: &[usize], order: &Order) -> bool {
        let implies = |implied: &Order| {
            graph.precedes_or_is(implied.before, order.before) && graph.precedes_or_is(order.after, implied.after)
        };
        !graph.precedes_or_is(order.after, order.before)
            && !graph.precedes(order.before, order.after)
            && !orders.iter().any(|other| implies(&self.layout.orders[*other]))
    }

    /// Whether an order could be the first new one on a way that puts one of two sites before the other.
    fn may_part(&self, graph: &EventGraph, order: &Order, (a, b): (usize, usize)) -> bool {
        [(a, b), (b, a)].into_iter().filter_map(|(first, second)| self.layout.order_events(first, second)).any(
            |(before, after)| {
                !graph.precedes_or_is(after, before)
                    && graph.precedes_or_is(before, order.before)
                    && !graph.precedes(after, order.after)
            },
        )
    }
}
