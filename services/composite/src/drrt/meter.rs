//! Counting work.

use contract::{Interrupted, JobContext};

/// Places of cooperative planning looked at for one work unit.
const PLACES_PER_UNIT: u32 = 32;

/// The work of one search: the job's budget, and a limit of its own.
pub(super) struct Meter<'c, 'j> {
    context: &'c mut JobContext<'j>,
    spent: u64,
    limit: u64,
    places: u32,
}

impl<'c, 'j> Meter<'c, 'j> {
    /// A search that may spend `limit` work units of the job's.
    pub fn new(context: &'c mut JobContext<'j>, limit: u64) -> Self {
        Self { context, spent: 0, limit, places: 0 }
    }

    /// Spends work units; whether the search may go on.
    ///
    /// # Errors
    /// [`Interrupted::Cancelled`].
    pub fn spend(&mut self, units: u64) -> Result<bool, Interrupted> {
        self.spent = self.spent.saturating_add(units);
        Ok(self.context.spend(units)? && self.spent <= self.limit)
    }

    /// Counts a place; every so many cost a work unit.
    ///
    /// # Errors
    /// [`Interrupted::Cancelled`].
    pub fn count_place(&mut self) -> Result<bool, Interrupted> {
        self.places += 1;
        if self.places < PLACES_PER_UNIT {
            return Ok(true);
        }
        self.places = 0;
        self.spend(1)
    }

    /// Work units spent by this search.
    pub fn spent(&self) -> u64 {
        self.spent
    }
}
