//! Sets of orders under which the poses have solutions, small sets first.
//!
//! Under each set the poses form a finite constraint network: what may be there at the same time must not collide; what an
//! added order keeps apart must collide, else that order is not forced. A set without a solution is extended only by
//! orders that could keep apart a pair of a crowd, so that orders appear where the geometry asks for them; a set with
//! solutions is extended by every order. Sizes are tried in ascending order, each by a depth-first search.
//!
//! The search is limited, in the number of sets of one size and in the work on each network. If it finds nothing because
//! of that, a set is taken from one sequence of all events and thinned out; then all begins anew with higher limits.

use std::collections::{BTreeMap, BTreeSet};

use contract::CauseTally;
use model::Problem;
use skeleton::EventGraph;

use crate::bits::{self, BitRows};
use crate::crowds::{Crowds, Need};
use crate::layout::{Layout, Order};
use crate::network::{Network, Overlaps, Relation, Stop};
use crate::nogoods::Nogoods;
use crate::report;
use crate::sequence::{irredundant, order_between, orders_of, sparse_sequence};
use crate::solutions::Solutions;
use crate::solve::{Solvability, solve};

/// Sets visited in one round, at first.
const FIRST_SETS: u64 = 2048;
/// Values tried for one network before it is left undecided, at first.
const FIRST_TRIES: u64 = 50_000;
/// Values tried to see whether an order taken from a sequence can be left out.
const THINNING_TRIES: u64 = 2_000;
/// Orders of the problem for which a visit to a set costs one more work unit.
const ORDERS_PER_UNIT: u64 = 8;
/// Factor of both limits from round to round.
const LIMIT_GROWTH: u64 = 8;

/// Indices of orders, ascending.
pub(crate) type OrderSet = Vec<usize>;

/// A lazy search for sets of orders.
pub(crate) struct OrderSets<'a> {
    problem: &'a Problem,
    layout: &'a Layout,
    domains: &'a BitRows,
    nogoods: Nogoods,
    crowds: Crowds,
    verdicts: BTreeMap<OrderSet, Verdict>,
    given_out: BTreeSet<OrderSet>,
    size: usize,
    limits: Limits,
    pass: Pass,
    /// Whether a set is to be taken from a sequence next; at most once.
    sequence: SequenceState,
    /// Sites that some refutation speaks of.
    at_fault: BTreeSet<usize>,
    causes: CauseTally,
}

/// Limits of one round.
struct Limits {
    sets: u64,
    sets_left: u64,
    /// Values tried for one network.
    tries: u64,
    /// Whether one was met.
    met: bool,
}

/// Whether a set was taken from a sequence.
#[derive(PartialEq, Eq)]
enum SequenceState {
    NotNeeded,
    Due,
    Done,
}

/// Depth-first search for sets of at most one size.
#[derive(Default)]
struct Pass {
    pending: Vec<OrderSet>,
    seen: BTreeSet<OrderSet>,
    /// Least size that a set left aside needs.
    next_size: Option<usize>,
}

/// What is known of a set of orders.
#[derive(Clone)]
enum Verdict {
    /// There are solutions, such as this one.
    Solvable(Vec<usize>),
    /// No solution without further orders.
    Crowded(Need),
    /// Neither it nor any larger set has a solution.
    Hopeless,
    /// So many tries did not tell.
    Undecided { tries: u64 },
}

impl<'a> OrderSets<'a> {
    pub fn new(problem: &'a Problem, layout: &'a Layout, domains: &'a BitRows, nogoods: Nogoods) -> Self {
        Self {
            problem,
            layout,
            domains,
            nogoods,
            crowds: Crowds::default(),
            verdicts: BTreeMap::new(),
            given_out: BTreeSet::new(),
            size: 0,
            limits: Limits { sets: FIRST_SETS, sets_left: FIRST_SETS, tries: FIRST_TRIES, met: false },
            pass: Pass::begin(),
            sequence: SequenceState::NotNeeded,
            at_fault: BTreeSet::new(),
            causes: CauseTally::default(),
        }
    }

    /// The next set of the present size with its solutions; `None` when no more is found.
    pub fn next(&mut self, overlaps: &mut dyn Overlaps) -> Result<Option<(OrderSet, Solutions)>, Stop> {
        if self.sequence == SequenceState::Due {
            self.sequence = SequenceState::Done;
            let found = self.set_of_sequence(overlaps)?;
            return Ok(found.and_then(|(set, values)| self.give_out(set, values)));
        }
        while let Some(set) = self.pass.pending.pop() {
            if self.pass.seen.contains(&set) {
                continue;
            }
            if self.limits.sets_left == 0 {
                self.limits.met = true;
                self.pass.next_size = None;
                return Ok(None);
            }
            self.limits.sets_left -= 1;
            self.pass.seen.insert(set.clone());
            overlaps.spend(1 + self.layout.orders.len() as u64 / ORDERS_PER_UNIT)?;
            let graph = self.layout.graph_with(&set);
            let usable = self.usable(&set, &graph);
            let verdict = self.verdict(&set, &graph, &usable, overlaps)?;
            self.extend(&set, &verdict, &usable);
            if let (Verdict::Solvable(values), false) = (verdict, self.given_out.contains(&set)) {
                return Ok(self.give_out(set, values));
            }
        }
        Ok(None)
    }

    fn give_out(&mut self, set: OrderSet, known: Vec<usize>) -> Option<(OrderSet, Solutions)> {
        let network = self.network(&set, &self.layout.graph_with(&set), true)?;
        self.given_out.insert(set.clone());
        Some((set, Solutions::new(network, known)))
    }

    /// Goes on to the next size. `false`: there are no more sets.
    pub fn grow(&mut self) -> bool {
        let next = self.pass.next_size.filter(|size| *size <= self.layout.orders.len());
        if let Some(size) = next {
            self.size = size;
        } else if self.limits.met && self.given_out.is_empty() && self.sequence == SequenceState::NotNeeded {
            self.sequence = SequenceState::Due;
            return true;
        } else if self.limits.met {
            self.size = 0;
            self.limits = self.limits.raised();
        } else {
            return false;
        }
        self.pass = Pass::begin();
        true
    }

    /// What stood in the way so far; `rejected` says for each site why samples of it are not free.
    pub fn into_causes(mut self, rejected: &[CauseTally]) -> CauseTally {
        for site in self.at_fault {
            self.causes.count_all(&rejected[site].clone().ranked());
        }
        self.causes
    }

    /// Puts the sets one larger on the list, or says that they are left aside.
    fn extend(&mut self, set: &OrderSet, verdict: &Verdict, usable: &[u64]) {
        let (helpful, least) = match verdict {
            Verdict::Hopeless | Verdict::Undecided { .. } => return,
            Verdict::Solvable(_) => (usable, 1),
            Verdict::Crowded(need) => (&need.helpful[..], need.least.max(1)),
        };
        if set.len() + least > self.size {
            self.pass.leave_aside(set.len() + least);
            return;
        }
        let larger = bits::indices(helpful).map(|index| {
            let mut larger = set.clone();
            larger.insert(larger.partition_point(|other| *other < index), index);
            larger
        });
        let larger: Vec<OrderSet> = larger.collect();
        self.pass.pending.extend(larger.into_iter().rev());
    }

    /// Orders that are new to a set, close no cycle, and leave every order of the set necessary.
    fn usable(&self, set: &[usize], graph: &EventGraph) -> Vec<u64> {
        let orders = &self.layout.orders;
        let implies = |order: &Order, implied: &Order| {
            graph.precedes_or_is(implied.before, order.before) && graph.precedes_or_is(order.after, implied.after)
        };
        let mut usable = vec![0; bits::words_for(orders.len())];
        for (index, order) in orders.iter().enumerate() {
            let open = !graph.precedes_or_is(order.after, order.before) && !graph.precedes(order.before, order.after);
            if open && !set.iter().any(|other| implies(order, &orders[*other])) {
                bits::insert(&mut usable, index);
            }
        }
        usable
    }

    fn verdict(
        &mut self,
        set: &OrderSet,
        graph: &EventGraph,
        usable: &[u64],
        overlaps: &mut dyn Overlaps,
    ) -> Result<Verdict, Stop> {
        let known = self.verdicts.get(set);
        match known {
            Some(Verdict::Hopeless | Verdict::Solvable(_)) => return Ok(self.verdicts[set].clone()),
            Some(Verdict::Undecided { tries }) if *tries >= self.limits.tries => {
                self.limits.met = true;
                return Ok(Verdict::Undecided { tries: *tries });
            }
            _ => {}
        }
        let is_new = known.is_none();
        let verdict = match (self.crowds.need(self.layout, graph, usable), known) {
            (Some(need), _) => Verdict::Crowded(need),
            (None, Some(Verdict::Crowded(need))) => Verdict::Crowded(need.clone()),
            (None, _) => self.judge(set, graph, usable, overlaps)?,
        };
        if let (true, Verdict::Crowded(need)) = (is_new, &verdict) {
            self.blame(graph, &need.pairs);
        }
        self.verdicts.insert(set.clone(), verdict.clone());
        Ok(verdict)
    }

    fn judge(
        &mut self,
        set: &OrderSet,
        graph: &EventGraph,
        usable: &[u64],
        overlaps: &mut dyn Overlaps,
    ) -> Result<Verdict, Stop> {
        let (sites, tries) = (self.all_sites(), self.limits.tries);
        let Some(plain) = self.network(&[], graph, false) else { return Ok(Verdict::Hopeless) };
        match solve(&plain, &sites, tries, overlaps)? {
            Solvability::Solution(_) => {}
            Solvability::Undecided(site) => return Ok(self.undecided(site)),
            Solvability::AtFault(at_fault) if plain.apart_among(&at_fault).is_empty() => {
                self.blame_sites(&at_fault);
                return Ok(Verdict::Hopeless);
            }
            Solvability::AtFault(at_fault) => {
                self.crowds.learn(self.layout, &plain, at_fault, tries, overlaps)?;
                return Ok(self.crowds.need(self.layout, graph, usable).map_or(Verdict::Hopeless, Verdict::Crowded));
            }
        }
        let Some(network) = self.network(set, graph, true) else { return Ok(Verdict::Hopeless) };
        let at_fault = match solve(&network, &sites, tries, overlaps)? {
            Solvability::Solution(values) => return Ok(Verdict::Solvable(values)),
            Solvability::Undecided(site) => return Ok(self.undecided(site)),
            Solvability::AtFault(at_fault) => at_fault,
        };
        self.blame_sites(&at_fault);
        let pairs = network.apart_among(&at_fault);
        let mut helpful = vec![0; usable.len()];
        pairs.iter().for_each(|pair| bits::unite(&mut helpful, &self.layout.helpful(graph, *pair, usable)));
        Ok(if pairs.is_empty() { Verdict::Hopeless } else { Verdict::Crowded(Need { pairs, helpful, least: 1 }) })
    }

    fn all_sites(&self) -> Vec<usize> {
        (0..self.layout.sites.len()).collect()
    }

    fn undecided(&mut self, site: usize) -> Verdict {
        self.limits.met = true;
        self.blame_sites(&[site]);
        Verdict::Undecided { tries: self.limits.tries }
    }

    /// A set with a solution: from the orders of a sequence those are left out, one by one, that are found to be needless;
    /// of the rest those are kept that the solution's collisions force.
    fn set_of_sequence(&mut self, overlaps: &mut dyn Overlaps) -> Result<Option<(OrderSet, Vec<usize>)>, Stop> {
        let mut orders = orders_of(self.layout, &sparse_sequence(self.problem, self.layout));
        let Some(mut values) = self.values_under(&orders, FIRST_TRIES, overlaps)? else { return Ok(None) };
        for index in orders.clone() {
            let fewer: OrderSet = orders.iter().copied().filter(|other| *other != index).collect();
            if let Some(better) = self.values_under(&fewer, THINNING_TRIES, overlaps)? {
                (orders, values) = (fewer, better);
            }
        }
        let graph = self.layout.graph_with(&orders);
        let mut forced = BTreeSet::new();
        for (a, others) in self.layout.neighbours.iter().enumerate() {
            for b in others.iter().copied().filter(|b| a < *b) {
                let Some(order) = order_between(self.layout, &graph, a, b) else { continue };
                if bits::contains(overlaps.row(a, values[a], b)?, values[b]) {
                    forced.insert(order);
                }
            }
        }
        let set = irredundant(self.layout, &forced.into_iter().collect::<Vec<_>>());
        let network = self.network(&set, &self.layout.graph_with(&set), true);
        Ok(network.filter(|network| network.admits(&values)).map(|_| (set, values)))
    }

    /// Values with which everything that may meet under some orders is apart, if they are easily found.
    fn values_under(
        &self,
        orders: &[usize],
        tries: u64,
        overlaps: &mut dyn Overlaps,
    ) -> Result<Option<Vec<usize>>, Stop> {
        let Some(network) = self.network(&[], &self.layout.graph_with(orders), false) else { return Ok(None) };
        Ok(match solve(&network, &self.all_sites(), tries, overlaps)? {
            Solvability::Solution(values) => Some(values),
            Solvability::AtFault(_) | Solvability::Undecided(_) => None,
        })
    }

    /// The network under an order on events, of which `set` was added. `None`: a nogood forbids it whatever the poses.
    /// Without `conditional`, only those nogoods count that hold under every set of orders.
    fn network(&self, set: &[usize], graph: &EventGraph, conditional: bool) -> Option<Network> {
        let mut network = Network::new(self.domains.clone(), self.layout.sites.len());
        for (a, others) in self.layout.neighbours.iter().enumerate() {
            for b in others.iter().copied().filter(|b| a < *b && self.layout.may_coexist(graph, a, *b)) {
                network.link(a, b, Relation::Apart);
            }
        }
        for Order { first, second, .. } in set.iter().map(|order| self.layout.orders[*order]) {
            network.link(first, second, Relation::Overlapping);
        }
        for banned in self.nogoods.under(if conditional { graph } else { &self.layout.graph }) {
            if banned.is_empty() {
                return None;
            }
            network.ban(banned);
        }
        Some(network)
    }

    fn blame(&mut self, graph: &EventGraph, pairs: &[(usize, usize)]) {
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

    fn cycle_of(&self, graph: &EventGraph, first: usize, second: usize) -> Option<plan::Cause> {
        let (before, after) = self.layout.order_events(first, second)?;
        if !graph.precedes_or_is(after, before) {
            return None;
        }
        let refused = graph.clone().add(before, after, skeleton::ArcOrigin::Discovered).err()?;
        Some(report::cycle(self.problem, &refused))
    }
}

impl Limits {
    fn raised(&self) -> Self {
        let [sets, tries] = [self.sets, self.tries].map(|limit| limit.saturating_mul(LIMIT_GROWTH));
        Self { sets, sets_left: sets, tries, met: false }
    }
}

impl Pass {
    fn begin() -> Self {
        Self { pending: vec![Vec::new()], ..Self::default() }
    }

    fn leave_aside(&mut self, size: usize) {
        self.next_size = Some(self.next_size.map_or(size, |other| other.min(size)));
    }
}
