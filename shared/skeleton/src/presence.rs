//! What may be present when: the exact rule on intervals of events.

use model::ObjectId;
use serde::{Deserialize, Serialize};

use crate::{Event, EventGraph};

/// A pose that an object takes: pose 0 is its start, pose i the one after its i-th hop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Occupancy {
    /// Object.
    pub object: ObjectId,
    /// Hop that put it there.
    pub hop: u32,
}

/// A closed interval between two events; `None` stands for the start of time as `from`, its end as `to`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Interval {
    /// First event.
    pub from: Option<Event>,
    /// Last event.
    pub to: Option<Event>,
}

/// Whether something is there during an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Presence {
    /// In no execution that the order allows.
    Never,
    /// At some instant of the interval in some execution.
    Possible,
    /// Throughout the interval in every execution.
    Certain,
}

impl EventGraph {
    /// Whether `present` overlaps `during`, over all executions that the order allows.
    #[must_use]
    pub fn presence(&self, present: Interval, during: Interval) -> Presence {
        let (gone_before, comes_after) = (self.ends_by(present.to, during.from), self.ends_by(during.to, present.from));
        if gone_before || comes_after {
            return Presence::Never;
        }
        let there_before = present.from.is_none_or(|p| during.from.is_some_and(|a| self.precedes_or_is(p, a)));
        let there_after = present.to.is_none_or(|g| during.to.is_some_and(|b| self.precedes_or_is(b, g)));
        if there_before && there_after { Presence::Certain } else { Presence::Possible }
    }

    /// Whether two intervals can overlap in some execution.
    #[must_use]
    pub fn may_overlap(&self, a: Interval, b: Interval) -> bool {
        self.presence(a, b) != Presence::Never
    }

    /// `end` ≼ `begin`, where a missing end is never and a missing begin is before everything.
    fn ends_by(&self, end: Option<Event>, begin: Option<Event>) -> bool {
        matches!((end, begin), (Some(end), Some(begin)) if self.precedes_or_is(end, begin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ArcOrigin;

    /// All linear extensions of a small order, as positions of each event.
    fn linear_extensions(graph: &EventGraph, events: &[Event]) -> Vec<Vec<usize>> {
        fn extend(graph: &EventGraph, events: &[Event], done: &mut Vec<usize>, all: &mut Vec<Vec<usize>>) {
            if done.len() == events.len() {
                let mut position = vec![0; events.len()];
                done.iter().enumerate().for_each(|(p, e)| position[*e] = p);
                all.push(position);
                return;
            }
            for e in 0..events.len() {
                let ready = (0..events.len()).all(|f| !graph.precedes(events[f], events[e]) || done.contains(&f));
                if ready && !done.contains(&e) {
                    done.push(e);
                    extend(graph, events, done, all);
                    done.pop();
                }
            }
        }
        let mut all = Vec::new();
        extend(graph, events, &mut Vec::new(), &mut all);
        all
    }

    #[test]
    fn presence_agrees_with_brute_force_over_all_linear_extensions() {
        let mut state = 11_u64;
        let mut next = move |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % n) as usize
        };
        let (mut checks, mut kinds) = (0_u64, [0_u64; 3]);
        for round in 0..600 {
            let mut graph = EventGraph::unordered(1);
            let events: Vec<Event> = graph.events().collect();
            for _ in 0..next(9) {
                let _ = graph.add(events[next(7)], events[next(7)], ArcOrigin::Given);
            }
            let extensions = linear_extensions(&graph, &events);
            let end = |i: usize| if i == 7 { None } else { Some(events[i]) };
            for _ in 0..60 {
                let pick = [next(8), next(8), next(8), next(8)];
                let [present, during] =
                    [[0, 1], [2, 3]].map(|[f, t]| Interval { from: end(pick[f]), to: end(pick[t]) });
                let ordered = |i: Interval| match (i.from, i.to) {
                    (Some(from), Some(to)) => graph.precedes(from, to),
                    _ => true,
                };
                if !ordered(present) || !ordered(during) {
                    continue;
                }
                // Open overlap: two intervals that only share an end point do not meet.
                let (mut some, mut every) = (false, true);
                for position in &extensions {
                    let at = |i: usize, missing: i64| if i == 7 { missing } else { position[i] as i64 };
                    let (p, g) = (at(pick[0], -1), at(pick[1], 99));
                    let (a, b) = (at(pick[2], -1), at(pick[3], 99));
                    some |= p < b && a < g;
                    every &= p <= a && b <= g;
                }
                let expected = match (some, every) {
                    (false, _) => Presence::Never,
                    (true, true) => Presence::Certain,
                    (true, false) => Presence::Possible,
                };
                assert_eq!(graph.presence(present, during), expected, "round {round}");
                checks += 1;
                kinds[expected as usize] += 1;
            }
        }
        assert!(checks > 1000 && kinds.iter().all(|n| *n > 50), "{checks} checks, {kinds:?} of each kind");
    }
}
