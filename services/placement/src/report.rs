//! Causes in the problem's own names.

use model::Problem;
use plan::{BodyRef, Cause, PairPoint};
use skeleton::{ArcOrigin, Cycle, Event};

use crate::layout::{Layout, Order, Site};

/// A standing object.
pub(crate) fn object(problem: &Problem, site: &Site) -> BodyRef {
    BodyRef::Object(object_name(problem, site))
}

fn object_name(problem: &Problem, site: &Site) -> String {
    problem.movable[site.object().index()].name.clone()
}

/// Two sites cannot both be taken.
pub(crate) fn collision(problem: &Problem, layout: &Layout, a: usize, b: usize) -> Cause {
    Cause::Collision { first: object(problem, &layout.sites[a]), second: object(problem, &layout.sites[b]) }
}

/// The object of a hop finds no place; a start pose needs none.
pub(crate) fn no_placement(problem: &Problem, site: &Site) -> Option<Cause> {
    let region = problem.regions[site.region(problem)?.index()].name.clone();
    Some(Cause::NoPlacement { object: object_name(problem, site), region })
}

/// Why an order was added.
pub(crate) fn overlap(problem: &Problem, layout: &Layout, order: &Order) -> Cause {
    let (first, second) = (&layout.sites[order.first], &layout.sites[order.second]);
    let region = second.region(problem).map_or(String::new(), |region| problem.regions[region.index()].name.clone());
    Cause::Overlap { region, leaves: object_name(problem, first), comes: object_name(problem, second) }
}

/// Orderings that contradict one another. Of a robot's own course only the ends are named.
pub(crate) fn cycle(problem: &Problem, Cycle(arcs): &Cycle) -> Cause {
    let passed = |index: usize| {
        let arriving = arcs[(index + arcs.len() - 1) % arcs.len()].origin;
        arriving == ArcOrigin::Robot && arcs[index].origin == ArcOrigin::Robot
    };
    let points = (0..arcs.len()).filter(|index| !passed(*index)).map(|index| point(problem, arcs[index].before));
    Cause::Cycle { points: points.collect() }
}

/// An event.
pub(crate) fn point(problem: &Problem, event: Event) -> PairPoint {
    PairPoint { pair: problem.pair(event.pair).name.clone(), point: event.point }
}
