//! Whether the poses have a solution under a set of orders, and if not, what is lacking.
//!
//! Under each set the poses form a finite constraint network: what may be there at the same time must not collide; what an
//! added order keeps apart must collide, else that order is not forced.

use std::collections::{BTreeMap, BTreeSet};

use contract::CauseTally;
use model::Problem;
use skeleton::EventGraph;

use crate::bits::{self, BitRows};
use crate::crowds::{Crowds, Need};
use crate::layout::{Layout, Order};
use crate::network::{Network, Overlaps, Relation, Stop};
use crate::nogoods::Nogoods;
use crate::order_sets::OrderSet;
use crate::report;
use crate::solve::{Solvability, solve};

/// What is known of a set of orders.
#[derive(Clone, Debug)]
pub(crate) enum Verdict {
    /// There are solutions, such as this one.
    Solvable(Vec<usize>),
    /// No solution without further orders.
    Crowded(Need),
    /// Neither it nor any larger set has a solution.
    Hopeless,
    /// So many tries did not tell.
    Undecided { tries: u64 },
}

/// A set of orders with what follows from it.
#[derive(Clone, Debug)]
pub(crate) struct Setting {
    pub orders: OrderSet,
    /// The given order with these orders.
    pub graph: EventGraph,
    /// Orders that may be added to it: they are new, close no cycle, and leave each of its orders necessary.
    pub usable: Vec<u64>,
}

impl Setting {
    pub fn new(layout: &Layout, orders: OrderSet) -> Self {
        let graph = layout.graph_with(&orders);
        let implies = |order: &Order, implied: &Order| {
            graph.precedes_or_is(implied.before, order.before) && graph.precedes_or_is(order.after, implied.after)
        };
        let mut usable = vec![0; bits::words_for(layout.orders.len())];
        for (index, order) in layout.orders.iter().enumerate() {
            let open = !graph.precedes_or_is(order.after, order.before) && !graph.precedes(order.before, order.after);
            if open && !orders.iter().any(|other| implies(order, &layout.orders[*other])) {
                bits::insert(&mut usable, index);
            }
        }
        Self { orders, graph, usable }
    }
}

/// Judges sets of orders, and remembers.
pub(crate) struct Judge<'a> {
    pub problem: &'a Problem,
    pub layout: &'a Layout,
    domains: &'a BitRows,
    nogoods: Nogoods,
    crowds: Crowds,
    verdicts: BTreeMap<OrderSet, Verdict>,
    /// Values tried so far.
    pub tried: u64,
    /// Sites that some refutation speaks of.
    at_fault: BTreeSet<usize>,
    causes: CauseTally,
}

impl<'a> Judge<'a> {
    pub fn new(problem: &'a Problem, layout: &'a Layout, domains: &'a BitRows, nogoods: Nogoods) -> Self {
        let (crowds, verdicts, at_fault) = (Crowds::default(), BTreeMap::new(), BTreeSet::new());
        let causes = CauseTally::default();
        Self { problem, layout, domains, nogoods, crowds, verdicts, tried: 0, at_fault, causes }
    }

    /// The verdict on a set; each network is left undecided after so many `tries`.
    pub fn verdict(&mut self, set: &Setting, tries: u64, overlaps: &mut dyn Overlaps) -> Result<Verdict, Stop> {
        let known = self.verdicts.get(&set.orders);
        match known {
            Some(verdict @ (Verdict::Hopeless | Verdict::Solvable(_))) => return Ok(verdict.clone()),
            Some(verdict @ Verdict::Undecided { tries: spent }) if *spent >= tries => return Ok(verdict.clone()),
            _ => {}
        }
        let is_new = known.is_none();
        let verdict = match (self.crowds.need(self.layout, &set.graph, &set.usable), known) {
            (Some(need), _) => Verdict::Crowded(need),
            (None, Some(Verdict::Crowded(need))) => Verdict::Crowded(need.clone()),
            (None, _) => self.judge(set, tries, overlaps)?,
        };
        if let (true, Verdict::Crowded(need)) = (is_new, &verdict) {
            self.blame_pairs(&set.graph, &need.pairs);
        }
        self.verdicts.insert(set.orders.clone(), verdict.clone());
        Ok(verdict)
    }

    /// First what must be apart is, then also what must collide does.
    fn judge(&mut self, set: &Setting, tries: u64, overlaps: &mut dyn Overlaps) -> Result<Verdict, Stop> {
        let Some(plain) = self.plain_network(&set.graph) else { return Ok(Verdict::Hopeless) };
        match self.solve(&plain, tries, overlaps)? {
            Solvability::Solution(_) => {}
            Solvability::Undecided(site) => return Ok(self.undecided(site, tries)),
            Solvability::AtFault(at_fault) if plain.apart_among(&at_fault).is_empty() => {
                self.blame_sites(&at_fault);
                return Ok(Verdict::Hopeless);
            }
            Solvability::AtFault(at_fault) => {
                self.tried += self.crowds.learn(self.layout, &plain, at_fault, tries, overlaps)?;
                let need = self.crowds.need(self.layout, &set.graph, &set.usable);
                return Ok(need.map_or(Verdict::Hopeless, Verdict::Crowded));
            }
        }
        let Some(network) = self.network(&set.orders, &set.graph) else { return Ok(Verdict::Hopeless) };
        let at_fault = match self.solve(&network, tries, overlaps)? {
            Solvability::Solution(values) => return Ok(Verdict::Solvable(values)),
            Solvability::Undecided(site) => return Ok(self.undecided(site, tries)),
            Solvability::AtFault(at_fault) => at_fault,
        };
        self.blame_sites(&at_fault);
        let pairs = network.apart_among(&at_fault);
        let mut helpful = vec![0; set.usable.len()];
        for pair in &pairs {
            bits::unite(&mut helpful, &self.layout.helpful(&set.graph, *pair, &set.usable));
        }
        Ok(if pairs.is_empty() { Verdict::Hopeless } else { Verdict::Crowded(Need { pairs, helpful, least: 1 }) })
    }

    /// Solves a network for all sites.
    pub fn solve(&mut self, network: &Network, tries: u64, overlaps: &mut dyn Overlaps) -> Result<Solvability, Stop> {
        let mut left = tries;
        let sites: Vec<usize> = (0..network.len()).collect();
        let solvability = solve(network, &sites, &mut left, overlaps)?;
        self.tried += tries - left;
        Ok(solvability)
    }

    /// The network under an order on events, of which `orders` were added. `None`: a nogood forbids them whatever the
    /// poses.
    pub fn network(&self, orders: &[usize], graph: &EventGraph) -> Option<Network> {
        let mut network = self.network_apart(graph);
        for order in orders.iter().map(|order| &self.layout.orders[*order]) {
            network.link(order.first, order.second, Relation::Overlapping);
        }
        self.with_bans(network, graph)
    }

    /// The same, but only with what is so under every set of orders with this order on events: nothing needs to collide,
    /// and nogoods that speak of added orders are left out.
    pub fn plain_network(&self, graph: &EventGraph) -> Option<Network> {
        self.with_bans(self.network_apart(graph), &self.layout.graph)
    }

    fn network_apart(&self, graph: &EventGraph) -> Network {
        let mut network = Network::new(self.domains.clone(), self.layout.sites.len());
        for (a, b) in self.layout.pairs() {
            if self.layout.may_coexist(graph, a, b) {
                network.link(a, b, Relation::Apart);
            }
        }
        network
    }

    fn with_bans(&self, mut network: Network, graph: &EventGraph) -> Option<Network> {
        for banned in self.nogoods.under(graph) {
            if banned.is_empty() {
                return None;
            }
            network.ban(banned);
        }
        Some(network)
    }

    /// What stood in the way so far; `rejected` says for each site why samples of it are not free.
    pub fn into_causes(mut self, rejected: &[CauseTally]) -> CauseTally {
        for site in self.at_fault {
            self.causes.count_all(&rejected[site].clone().ranked());
        }
        self.causes
    }

    fn undecided(&mut self, site: usize, tries: u64) -> Verdict {
        self.blame_sites(&[site]);
        Verdict::Undecided { tries }
    }

    fn blame_pairs(&mut self, graph: &EventGraph, pairs: &[(usize, usize)]) {
        for (a, b) in pairs.iter().copied() {
            self.at_fault.extend([a, b]);
            self.causes.count(report::collision(self.problem, self.layout, a, b));
            for (first, second) in [(a, b), (b, a)] {
                if let Some(cycle) = self.cycle_of(graph, first, second) {
                    self.causes.count(cycle);
                }
            }
        }
    }

    fn blame_sites(&mut self, sites: &[usize]) {
        self.at_fault.extend(sites);
        for site in sites {
            if let Some(cause) = report::no_placement(self.problem, &self.layout.sites[*site]) {
                self.causes.count(cause);
            }
        }
    }

    /// The cycle that putting one site before another would close, if it would.
    fn cycle_of(&self, graph: &EventGraph, first: usize, second: usize) -> Option<plan::Cause> {
        let (before, after) = self.layout.order_events(first, second)?;
        if !graph.precedes_or_is(after, before) {
            return None;
        }
        let refused = graph.clone().add(before, after, skeleton::ArcOrigin::Discovered).err()?;
        Some(report::cycle(self.problem, &refused))
    }
}
