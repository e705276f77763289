//! A set of orders taken from one sequence of all events: for regions so full that the least orders are hard to find.

use std::collections::{BTreeMap, BTreeSet};

use model::{Pair, PairId, Point, Problem};
use skeleton::{Event, EventGraph};

use crate::bits;
use crate::footprint::Footprint;
use crate::layout::Layout;
use crate::network::{Overlaps, Stop};
use crate::order_sets::OrderSet;
use crate::solve::Solvability;
use crate::verdict::Judge;

/// Values tried under the orders of the whole sequence.
const WHOLE_TRIES: u64 = 50_000;
/// Values tried to see whether an order can be left out.
const THINNING_TRIES: u64 = 2_000;

/// A set of orders, and values that solve its network. Of the orders of a sequence those are left out, one by one, that
/// are found to be needless. If the rest are not all forced, those are taken that the collisions of the values force.
pub(crate) fn set_of_sequence(
    judge: &mut Judge<'_>,
    overlaps: &mut dyn Overlaps,
) -> Result<Option<(OrderSet, Vec<usize>)>, Stop> {
    let layout = judge.layout;
    let mut orders = orders_of(layout, &sparse_sequence(judge.problem, layout));
    let Some(mut values) = values_under(judge, &orders, WHOLE_TRIES, overlaps)? else { return Ok(None) };
    for index in orders.clone() {
        let fewer: OrderSet = orders.iter().copied().filter(|other| *other != index).collect();
        if let Some(better) = values_under(judge, &fewer, THINNING_TRIES, overlaps)? {
            (orders, values) = (fewer, better);
        }
    }
    let graph = layout.graph_with(&orders);
    let Some(network) = judge.network(&orders, &graph) else { return Ok(None) };
    if let Solvability::Solution(values) = judge.solve(&network, THINNING_TRIES, overlaps)? {
        return Ok(Some((orders, values)));
    }
    let forced = irredundant(layout, &forced_by(layout, &graph, &values, overlaps)?);
    let network = judge.network(&forced, &layout.graph_with(&forced));
    Ok(network.filter(|network| network.admits(&values)).map(|_| (forced, values)))
}

/// Values with which everything that may meet under some orders is apart, if they are easily found.
fn values_under(
    judge: &mut Judge<'_>,
    orders: &[usize],
    tries: u64,
    overlaps: &mut dyn Overlaps,
) -> Result<Option<Vec<usize>>, Stop> {
    let Some(network) = judge.plain_network(&judge.layout.graph_with(orders)) else { return Ok(None) };
    match judge.solve(&network, tries, overlaps)? {
        Solvability::Solution(values) => Ok(Some(values)),
        Solvability::AtFault(_) | Solvability::Undecided(_) => Ok(None),
    }
}

/// Orders by which `graph` keeps apart what collides.
fn forced_by(
    layout: &Layout,
    graph: &EventGraph,
    values: &[usize],
    overlaps: &mut dyn Overlaps,
) -> Result<Vec<usize>, Stop> {
    let mut forced = BTreeSet::new();
    for (a, b) in layout.pairs() {
        if bits::contains(overlaps.row(a, values[a], b)?, values[b]) {
            forced.extend(order_between(layout, graph, a, b));
        }
    }
    Ok(forced.into_iter().collect())
}

/// The order by which `graph`, an extension of the given order, keeps two neighbours apart.
fn order_between(layout: &Layout, graph: &EventGraph, a: usize, b: usize) -> Option<usize> {
    let parts = |first: usize, second: usize| {
        layout.order_events(first, second).is_some_and(|(before, after)| graph.precedes(before, after))
    };
    let between = |order: &crate::layout::Order| {
        let ends = (order.first, order.second);
        (ends == (a, b) || ends == (b, a)) && parts(order.first, order.second)
    };
    layout.orders.iter().position(between)
}

/// The orders (by index) that a sequence obeys, without those that others imply.
fn orders_of(layout: &Layout, sequence: &[Event]) -> OrderSet {
    let rank: BTreeMap<Event, usize> = sequence.iter().enumerate().map(|(rank, event)| (*event, rank)).collect();
    let obeyed = |index: &usize| rank.get(&layout.orders[*index].before) < rank.get(&layout.orders[*index].after);
    irredundant(layout, &(0..layout.orders.len()).filter(obeyed).collect::<Vec<_>>())
}

/// Those of some compatible orders that are not implied by the others and the given order.
fn irredundant(layout: &Layout, orders: &[usize]) -> OrderSet {
    let whole = layout.graph_with(orders);
    let implied = |index: &usize| {
        let order = &layout.orders[*index];
        // By way of another order's two ends: a way back to the first could only be a cycle.
        orders.iter().filter(|other| *other != index).map(|other| &layout.orders[*other]).any(|other| {
            whole.precedes_or_is(order.before, other.before) && whole.precedes_or_is(other.after, order.after)
        })
    };
    orders.iter().copied().filter(|index| !implied(index)).collect()
}

/// Grasps and releases in a sequence that the given order allows, and that keeps regions empty: whatever can be grasped
/// is, and only then is something released, where the most room is left.
fn sparse_sequence(problem: &Problem, layout: &Layout) -> Vec<Event> {
    let pairs = (0..problem.pairs.len()).map(PairId::at);
    let mut open: Vec<Event> = pairs.flat_map(|pair| [Event::grasp(pair), Event::release(pair)]).collect();
    let mut loads = Loads::at_start(problem);
    let mut sequence = Vec::new();
    while !open.is_empty() {
        let ready = |event: &&Event| !open.iter().any(|other| layout.graph.precedes(*other, **event));
        let by_load = |a: &&Event, b: &&Event| loads.after(problem, **a).total_cmp(&loads.after(problem, **b));
        let Some(next) = open.iter().filter(ready).min_by(by_load).copied() else { break };
        loads.change(problem, next);
        open.retain(|event| *event != next);
        sequence.push(next);
    }
    sequence
}

/// Area (m²) of the objects' bounds in each region.
struct Loads(Vec<f64>);

impl Loads {
    fn at_start(problem: &Problem) -> Self {
        let mut loads = Self(vec![0.0; problem.regions.len()]);
        for pair in problem.pairs.iter().filter(|pair| pair.hop == 1) {
            loads.0[pair.from.index()] += area(problem, pair);
        }
        loads
    }

    fn change(&mut self, problem: &Problem, event: Event) {
        let pair = problem.pair(event.pair);
        if event.point == Point::Grasp {
            self.0[pair.from.index()] -= area(problem, pair);
        } else {
            self.0[pair.to.index()] += area(problem, pair);
        }
    }

    /// How full (as a share of its area) the region is into which an event puts something; a grasp fills none.
    fn after(&self, problem: &Problem, event: Event) -> f64 {
        let pair = problem.pair(event.pair);
        if event.point == Point::Grasp {
            return f64::NEG_INFINITY;
        }
        let [x, y] = problem.regions[pair.to.index()].size;
        (self.0[pair.to.index()] + area(problem, pair)) / (x * y)
    }
}

fn area(problem: &Problem, pair: &Pair) -> f64 {
    let [x, y] = Footprint::of(&problem.movable[pair.object.index()]).extent(0.0);
    x * y
}
