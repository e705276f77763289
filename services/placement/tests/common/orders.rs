//! Orders without those that follow from others.

use model::Problem;
use skeleton::{ArcOrigin, Event, EventGraph};

/// Of orders that hold together those that neither the problem nor the others imply.
pub fn irredundant(problem: &Problem, orders: &[(Event, Event)]) -> Vec<(Event, Event)> {
    let implied = |i: usize| {
        let mut graph = EventGraph::of_problem(problem).unwrap();
        let others = orders.iter().enumerate().filter(|(other, _)| *other != i);
        others.for_each(|(_, (before, after))| graph.add(*before, *after, ArcOrigin::Discovered).unwrap());
        graph.precedes(orders[i].0, orders[i].1)
    };
    let mut kept: Vec<(Event, Event)> = (0..orders.len()).filter(|i| !implied(*i)).map(|i| orders[i]).collect();
    kept.sort_unstable();
    kept
}
