//! Orders taken from one way in which everything could happen in sequence: for regions so full that the least orders are
//! hard to find.

use std::collections::BTreeMap;

use model::Problem;
use skeleton::{Event, EventGraph};

use crate::layout::Layout;

/// Grasps and releases in a sequence that the given order allows, and that keeps regions empty: whatever can be grasped
/// is, and only then is something released, where the most room is left.
pub(crate) fn sparse_sequence(problem: &Problem, layout: &Layout) -> Vec<Event> {
    let mut open: Vec<Event> = (0..problem.pairs.len())
        .map(model::PairId::at)
        .flat_map(|pair| [Event::grasp(pair), Event::release(pair)])
        .collect();
    let mut load = Loads::at_start(problem);
    let mut sequence = Vec::new();
    while !open.is_empty() {
        let ready = |event: &&Event| !open.iter().any(|other| layout.graph.precedes(*other, **event));
        let next =
            open.iter().filter(ready).min_by(|a, b| load.after(problem, **a).total_cmp(&load.after(problem, **b)));
        let Some(next) = next.copied() else { break };
        load.change(problem, next);
        open.retain(|event| *event != next);
        sequence.push(next);
    }
    sequence
}

/// Area (m²) of the objects' bounds in each region.
struct Loads(BTreeMap<usize, f64>);

impl Loads {
    fn at_start(problem: &Problem) -> Self {
        let mut loads = Self(BTreeMap::new());
        for pair in problem.pairs.iter().filter(|pair| pair.hop == 1) {
            *loads.0.entry(pair.from.index()).or_insert(0.0) += area(problem, pair);
        }
        loads
    }

    fn change(&mut self, problem: &Problem, event: Event) {
        let pair = problem.pair(event.pair);
        if event.point == model::Point::Grasp {
            *self.0.entry(pair.from.index()).or_insert(0.0) -= area(problem, pair);
        } else {
            *self.0.entry(pair.to.index()).or_insert(0.0) += area(problem, pair);
        }
    }

    /// How full (as a share of its area) the region is into which an event puts something; a grasp fills none.
    fn after(&self, problem: &Problem, event: Event) -> f64 {
        let pair = problem.pair(event.pair);
        if event.point == model::Point::Grasp {
            return f64::NEG_INFINITY;
        }
        let [x, y] = problem.regions[pair.to.index()].size;
        (self.0.get(&pair.to.index()).unwrap_or(&0.0) + area(problem, pair)) / (x * y)
    }
}

fn area(problem: &Problem, pair: &model::Pair) -> f64 {
    let [x, y] = crate::footprint::Footprint::of(&problem.movable[pair.object.index()]).extent(0.0);
    x * y
}

/// The orders (by index) that a sequence obeys, without those that others imply.
pub(crate) fn orders_of(layout: &Layout, sequence: &[Event]) -> Vec<usize> {
    let rank = |event: Event| sequence.iter().position(|other| *other == event);
    let obeyed = |index: &usize| rank(layout.orders[*index].before) < rank(layout.orders[*index].after);
    irredundant(layout, &(0..layout.orders.len()).filter(obeyed).collect::<Vec<_>>())
}

/// Those of some compatible orders that are not implied by the others and the given order.
pub(crate) fn irredundant(layout: &Layout, orders: &[usize]) -> Vec<usize> {
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

/// The order by which `graph`, an extension of the given order, keeps two sites apart; `None` if it does not, or if the
/// given order does.
pub(crate) fn order_between(layout: &Layout, graph: &EventGraph, a: usize, b: usize) -> Option<usize> {
    let between = |first: usize, second: usize| {
        let (before, after) = layout.order_events(first, second)?;
        let added = graph.precedes(before, after) && !layout.graph.precedes(before, after);
        let is_it = |order: &crate::layout::Order| (order.first, order.second) == (first, second);
        if added { layout.orders.iter().position(is_it) } else { None }
    };
    between(a, b).or_else(|| between(b, a))
}
