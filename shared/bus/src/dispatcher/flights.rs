//! Offers on their way: who has which job, and since when.

use std::collections::BTreeMap;
use std::time::Duration;

use contract::JobId;

use crate::{HEARTBEAT, MemberId};

/// Heartbeats without a job after which its offer counts as lost.
const MISSED_BEATS: u32 = 2;

/// An offer that has not been answered.
pub(super) struct Flight {
    pub(super) member: MemberId,
    pub(super) offered: Duration,
    pub(super) speculative: bool,
    pub(super) started: bool,
    /// Nobody wants the answer any more; the worker has been told.
    pub(super) retired: bool,
    missed: u32,
}

/// All offers that have not been answered.
#[derive(Default)]
pub(super) struct Flights(BTreeMap<JobId, Flight>);

impl Flights {
    pub(super) fn get(&self, id: &JobId) -> Option<&Flight> {
        self.0.get(id)
    }

    pub(super) fn take_off(&mut self, now: Duration, id: JobId, member: MemberId, speculative: bool) {
        let flight = Flight { member, offered: now, speculative, started: false, retired: false, missed: 0 };
        self.0.insert(id, flight);
    }

    /// The worker has begun.
    pub(super) fn started(&mut self, member: MemberId, id: JobId) {
        if let Some(flight) = self.0.get_mut(&id).filter(|flight| flight.member == member) {
            flight.started = true;
        }
    }

    /// The worker has answered or declined. `false`: it was not (or not any more) its job.
    pub(super) fn land(&mut self, member: MemberId, id: JobId) -> bool {
        let its_own = self.0.get(&id).is_some_and(|flight| flight.member == member);
        if its_own {
            self.0.remove(&id);
        }
        its_own
    }

    /// A worker has gone.
    pub(super) fn land_all_of(&mut self, member: MemberId) {
        self.0.retain(|_, flight| flight.member != member);
    }

    /// A worker says what it holds. What it does not hold twice running is not with it.
    pub(super) fn beat(&mut self, now: Duration, member: MemberId, held: &[JobId]) {
        self.0.retain(|id, flight| {
            if flight.member != member {
                return true;
            }
            flight.missed = if held.contains(id) { 0 } else { flight.missed + 1 };
            flight.missed < MISSED_BEATS || now < flight.offered + MISSED_BEATS * HEARTBEAT
        });
    }

    /// Drops what is with workers that do not count as alive.
    pub(super) fn keep_alive(&mut self, is_alive: impl Fn(MemberId) -> bool) {
        self.0.retain(|_, flight| is_alive(flight.member));
    }

    /// Marks what is not `live` as retired. `true`: there was something.
    pub(super) fn retire(&mut self, is_live: impl Fn(&JobId) -> bool) -> bool {
        let mut any = false;
        for (id, flight) in &mut self.0 {
            if !flight.retired && !is_live(id) {
                flight.retired = true;
                any = true;
            }
        }
        any
    }

    /// Number of unanswered offers of each worker.
    pub(super) fn load(&self) -> BTreeMap<MemberId, usize> {
        let mut load = BTreeMap::new();
        for flight in self.0.values() {
            *load.entry(flight.member).or_insert(0) += 1;
        }
        load
    }
}
