//! Contradicting orderings: a cycle among each robot's order, each object's hops and the given orderings.

use super::at::At;
use super::syntax::OrderingFile;
use super::task::Pairs;
use crate::problem_error::{FindingKind, Found, Source};
use crate::{GivenOrdering, PairId, Point};

/// Why one event comes before another.
#[derive(Clone, Copy)]
enum Why {
    /// Both are of one pair.
    Pair,
    /// One robot does one pair after the other.
    Robot,
    /// The object must have been placed before it is picked again.
    Hop,
    /// The problem says so (index).
    Given(usize),
}

struct Arc {
    to: usize,
    why: Why,
}

/// Finds a cycle and tells it.
pub(crate) fn refuse_cycle(
    source: &Source,
    file: &[At<OrderingFile>],
    pairs: &Pairs,
    orderings: &[GivenOrdering],
    gated: &dyn Fn(GivenOrdering) -> Option<GivenOrdering>,
) -> Found<()> {
    let arcs = arcs(pairs, orderings, gated);
    let Some(cycle) = find_cycle(&arcs) else { return Ok(()) };
    let step = |(event, why): &(usize, Why)| {
        let (pair, point) = (&pairs.pairs[event / 7], Point::ALL[event % 7]);
        let why = match why {
            Why::Pair => "the pair's own order".to_owned(),
            Why::Robot => "the robot's order".to_owned(),
            Why::Hop => "the object's way".to_owned(),
            Why::Given(index) => format!("ordering {}", index + 1),
        };
        format!("{} {} comes first by {why}", pair.name, point.name())
    };
    let told: Vec<String> = shorten(&cycle).iter().map(step).collect();
    let given = cycle.iter().find_map(|(_, why)| if let Why::Given(index) = why { Some(*index) } else { None });
    let place = given.map_or_else(|| pairs.spans[cycle[0].0 / 7], |index| file[index].span);
    Err(source
        .finding(place, FindingKind::CyclicOrder, format!("orderings form a cycle:\n{}", told.join(",\nthen ")))
        .help("remove or reverse one of the orderings"))
}

fn event(pair: PairId, point: Point) -> usize {
    pair.index() * 7 + point as usize
}

fn arcs(
    pairs: &Pairs,
    orderings: &[GivenOrdering],
    gated: &dyn Fn(GivenOrdering) -> Option<GivenOrdering>,
) -> Vec<Vec<Arc>> {
    let count = pairs.pairs.len();
    let mut arcs: Vec<Vec<Arc>> = (0..count * 7).map(|_| Vec::new()).collect();
    let mut add = |from: usize, to: usize, why: Why| arcs[from].push(Arc { to, why });
    for pair in 0..count {
        for point in 0..6 {
            add(pair * 7 + point, pair * 7 + point + 1, Why::Pair);
        }
        if pair + 1 < count && pairs.pairs[pair].robot == pairs.pairs[pair + 1].robot {
            add(event(PairId::at(pair), Point::Done), event(PairId::at(pair + 1), Point::Start), Why::Robot);
        }
    }
    let mut add_gated = |ordering: GivenOrdering, why: Why| {
        for GivenOrdering { before, after } in [Some(ordering), gated(ordering)].into_iter().flatten() {
            add(event(before.0, before.1), event(after.0, after.1), why);
        }
    };
    let mut hops: Vec<usize> = (0..count).collect();
    hops.sort_by_key(|pair| (pairs.pairs[*pair].object, pairs.pairs[*pair].hop));
    for two in hops.windows(2) {
        if pairs.pairs[two[0]].object == pairs.pairs[two[1]].object {
            let (before, after) = ((PairId::at(two[0]), Point::Release), (PairId::at(two[1]), Point::Grasp));
            add_gated(GivenOrdering { before, after }, Why::Hop);
        }
    }
    for (index, ordering) in orderings.iter().enumerate() {
        add_gated(*ordering, Why::Given(index));
    }
    arcs
}

/// A shortest cycle through the first event that lies on one: each event with the reason why it precedes the next.
fn find_cycle(arcs: &[Vec<Arc>]) -> Option<Vec<(usize, Why)>> {
    let backwards = reversed(arcs);
    let mut removed = vec![false; arcs.len()];
    trim(arcs, &backwards, &mut removed);
    trim(&backwards, arcs, &mut removed);
    (0..arcs.len()).filter(|event| !removed[*event]).find_map(|event| cycle_through(arcs, event))
}

fn reversed(arcs: &[Vec<Arc>]) -> Vec<Vec<Arc>> {
    let mut backwards: Vec<Vec<Arc>> = (0..arcs.len()).map(|_| Vec::new()).collect();
    for (from, arcs) in arcs.iter().enumerate() {
        for arc in arcs {
            backwards[arc.to].push(Arc { to: from, why: arc.why });
        }
    }
    backwards
}

/// Removes all events that nothing precedes, again and again: what is left lies on cycles or behind them.
fn trim(arcs: &[Vec<Arc>], backwards: &[Vec<Arc>], removed: &mut [bool]) {
    let mut incoming: Vec<usize> =
        backwards.iter().map(|arcs| arcs.iter().filter(|arc| !removed[arc.to]).count()).collect();
    let mut free: Vec<usize> = (0..arcs.len()).filter(|event| !removed[*event] && incoming[*event] == 0).collect();
    while let Some(event) = free.pop() {
        removed[event] = true;
        for arc in arcs[event].iter().filter(|arc| !removed[arc.to]) {
            incoming[arc.to] -= 1;
            if incoming[arc.to] == 0 {
                free.push(arc.to);
            }
        }
    }
}

/// Breadth-first search from an event back to itself.
fn cycle_through(arcs: &[Vec<Arc>], origin: usize) -> Option<Vec<(usize, Why)>> {
    let mut reached_from: Vec<Option<(usize, Why)>> = (0..arcs.len()).map(|_| None).collect();
    let mut queue = std::collections::VecDeque::from([origin]);
    while let Some(event) = queue.pop_front() {
        for arc in &arcs[event] {
            if reached_from[arc.to].is_none() {
                reached_from[arc.to] = Some((event, arc.why));
                queue.push_back(arc.to);
            }
        }
        if let Some((mut from, why)) = reached_from[origin] {
            let mut cycle = vec![(from, why)];
            while from != origin {
                let (before, why) = reached_from[from]?;
                cycle.push((before, why));
                from = before;
            }
            cycle.reverse();
            return Some(cycle);
        }
    }
    None
}

/// Leaves out the points inside a pair, and inside a robot's sequence, that the cycle only passes.
fn shorten(cycle: &[(usize, Why)]) -> Vec<(usize, Why)> {
    let plain = |index: usize| matches!(cycle[index % cycle.len()].1, Why::Pair);
    let keep = |index: &usize| !(plain(*index) && plain(index + cycle.len() - 1));
    (0..cycle.len()).filter(keep).map(|index| cycle[index]).collect()
}
