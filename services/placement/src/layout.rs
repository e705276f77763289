//! Sites: every pose that an object takes, when it is taken, and which sites could be in each other's way.

use crate::bits;
use model::{ObjectId, PairId, Problem, RegionId, Removal};
use skeleton::{Event, EventGraph, Interval, Occupancy, Skeleton};

/// A pose that an object takes. Sites are numbered by object, then hop.
#[derive(Clone, Debug)]
pub(crate) struct Site {
    pub occupancy: Occupancy,
    /// The pair that places it; a start pose has none.
    pub placed_by: Option<PairId>,
    /// The release that begins it; a start pose is there from the start.
    pub comes: Option<Event>,
    /// The grasp that ends it, or the release after it, as the problem's removals are; the last pose stays.
    pub leaves: Option<Event>,
}

impl Site {
    /// Object.
    pub fn object(&self) -> ObjectId {
        self.occupancy.object
    }

    /// The region that the object is brought to.
    pub fn region(&self, problem: &Problem) -> Option<RegionId> {
        self.placed_by.map(|pair| problem.pair(pair).to)
    }

    fn interval(&self) -> Interval {
        Interval { from: self.comes, to: self.leaves }
    }
}

/// An order that could keep two sites from being taken at the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Order {
    /// The site that is left first.
    pub first: usize,
    /// The site that is taken later.
    pub second: usize,
    /// Grasp of the first's object, or its release elsewhere.
    pub before: Event,
    /// Release of the second's.
    pub after: Event,
}

/// The sites of a problem, without their samples.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub sites: Vec<Site>,
    /// Sites of other objects that may be taken at the same time and could be in the way, ascending.
    pub neighbours: Vec<Vec<usize>>,
    /// Orders between neighbours that the given order allows, by their events.
    pub orders: Vec<Order>,
    /// The given order.
    pub graph: EventGraph,
    pairs: usize,
}

impl Layout {
    /// The layout of a problem; `near(a, b)` says whether bodies at two sites could come close to each other.
    /// A start pose that is never left has no neighbours: it is an obstacle, like fixed objects.
    pub fn new(problem: &Problem, skeleton: &Skeleton, near: impl Fn(usize, usize) -> bool) -> Self {
        let sites: Vec<Site> = skeleton.occupancies().map(|occupancy| site(problem, skeleton, occupancy)).collect();
        let mut neighbours = vec![Vec::new(); sites.len()];
        for a in 0..sites.len() {
            for b in 0..sites.len() {
                if related(&skeleton.graph, &sites[a], &sites[b]) && near(a, b) {
                    neighbours[a].push(b);
                }
            }
        }
        let orders = possible_orders(&skeleton.graph, &sites, &neighbours);
        Self { sites, neighbours, orders, graph: skeleton.graph.clone(), pairs: problem.pairs.len() }
    }

    /// All pairs of neighbours, the smaller site first.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let of_site = |(a, others): (usize, &Vec<usize>)| others.iter().map(move |b| (a, *b)).collect::<Vec<_>>();
        self.neighbours.iter().enumerate().flat_map(of_site).filter(|(a, b)| a < b)
    }

    /// The order that would put `first` before `second`, if there is one at all.
    pub fn order_events(&self, first: usize, second: usize) -> Option<(Event, Event)> {
        self.sites[first].leaves.zip(self.sites[second].comes)
    }

    /// Whether an event is one of the problem's.
    pub fn has_event(&self, event: Event) -> bool {
        event.pair.index() < self.pairs
    }

    /// The given order with some of `orders` (by index) added. They must not close a cycle.
    pub fn graph_with(&self, orders: &[usize]) -> EventGraph {
        let mut graph = self.graph.clone();
        for order in orders.iter().map(|order| &self.orders[*order]) {
            let added = graph.add(order.before, order.after, skeleton::ArcOrigin::Discovered);
            debug_assert!(added.is_ok(), "a set of orders that is no order");
        }
        graph
    }

    /// Of the `usable` orders those that could be the first new one on a way that puts one of two sites before the other.
    pub fn helpful(&self, graph: &EventGraph, (a, b): (usize, usize), usable: &[u64]) -> Vec<u64> {
        let mut helpful = vec![0; usable.len()];
        let ways = [(a, b), (b, a)].into_iter().filter_map(|(first, second)| self.order_events(first, second));
        for (before, after) in ways.filter(|(before, after)| !graph.precedes_or_is(*after, *before)) {
            for index in bits::indices(usable) {
                let order = &self.orders[index];
                if graph.precedes_or_is(before, order.before) && !graph.precedes(after, order.after) {
                    bits::insert(&mut helpful, index);
                }
            }
        }
        helpful
    }

    /// Whether two sites may be taken at the same time under `graph`.
    pub fn may_coexist(&self, graph: &EventGraph, a: usize, b: usize) -> bool {
        graph.may_overlap(self.sites[a].interval(), self.sites[b].interval())
    }
}

fn site(problem: &Problem, skeleton: &Skeleton, occupancy: Occupancy) -> Site {
    let Interval { from, to } = skeleton.interval_of(occupancy);
    let leaves = to.map(|grasp| match problem.settings.removal {
        Removal::Grasp => grasp,
        Removal::Completed => Event::release(grasp.pair),
    });
    Site { occupancy, placed_by: from.map(|event| event.pair), comes: from, leaves }
}

fn related(graph: &EventGraph, a: &Site, b: &Site) -> bool {
    let stays = |site: &Site| site.comes.is_none() && site.leaves.is_none();
    let placed = a.comes.is_some() || b.comes.is_some();
    placed && a.object() != b.object() && !stays(a) && !stays(b) && graph.may_overlap(a.interval(), b.interval())
}

fn possible_orders(graph: &EventGraph, sites: &[Site], neighbours: &[Vec<usize>]) -> Vec<Order> {
    let mut orders = Vec::new();
    for (first, others) in neighbours.iter().enumerate() {
        for second in others.iter().copied() {
            let (Some(before), Some(after)) = (sites[first].leaves, sites[second].comes) else { continue };
            if !graph.precedes_or_is(after, before) {
                orders.push(Order { first, second, before, after });
            }
        }
    }
    orders.sort_by_key(|order| (order.before, order.after));
    orders
}
