//! What stands about while a robot is in a mode, and at the two events of a pair.

use std::collections::BTreeSet;

use model::PairId;
use skeleton::{Event, Interval, Mode, Occupancy, Presence};

use crate::candidate::Candidate;
use crate::conflict::Order;

/// Poses about an interval under the present orderings.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Around {
    /// There throughout, or to be reckoned with as if they were.
    pub(crate) certain: BTreeSet<Occupancy>,
    /// There at some instant of some execution.
    pub(crate) possible: BTreeSet<Occupancy>,
}

impl Candidate<'_> {
    /// Poses about a mode; those that no ordering keeps away from it count as certain.
    pub(crate) fn around_mode(&self, mode: &Mode) -> Around {
        let mut around = self.around(mode.interval(), |_| true);
        for assumed in self.known(mode).assumed.iter().filter(|assumed| self.hold(&assumed.orders)) {
            if around.possible.remove(&assumed.pose) {
                around.certain.insert(assumed.pose);
            }
        }
        around
    }

    /// Poses about the grasp and the release of a pair, its own object apart.
    pub(crate) fn around_events(&self, pair: PairId) -> [Around; 2] {
        let own = self.problem.pair(pair).object;
        [Event::grasp(pair), Event::release(pair)].map(|event| self.around(instant(event), |pose| pose.object != own))
    }

    fn around(&self, during: Interval, counts: impl Fn(&Occupancy) -> bool) -> Around {
        let mut around = Around::default();
        for occupancy in self.skeleton.occupancies().filter(|pose| counts(pose) && self.is_placed(*pose)) {
            match self.skeleton.graph.presence(self.skeleton.interval_of(occupancy), during) {
                Presence::Certain => around.certain.insert(occupancy),
                Presence::Possible => around.possible.insert(occupancy),
                Presence::Never => continue,
            };
        }
        around
    }

    /// The discovered orderings because of which a pose is there throughout an interval.
    pub(crate) fn orders_keeping(&self, occupancy: Occupancy, during: Interval) -> BTreeSet<Order> {
        let present = self.skeleton.interval_of(occupancy);
        let ends = [(present.from, during.from), (during.to, present.to)];
        let ends = ends.into_iter().filter_map(|(earlier, later)| earlier.zip(later));
        ends.flat_map(|(earlier, later)| self.skeleton.graph.discovered_between(earlier, later)).collect()
    }

    /// Whether all these orderings are among the present ones.
    pub(crate) fn hold(&self, orders: &BTreeSet<Order>) -> bool {
        orders.iter().all(|order| self.orders.iter().any(|present| (present.before, present.after) == *order))
    }
}

/// The interval of one event.
pub(crate) fn instant(event: Event) -> Interval {
    Interval { from: Some(event), to: Some(event) }
}
