//! One pair whose two poses have just become known: its alternatives, and where that is merged, too, its roadmaps.
//!
//! Hops that are not placed yet do not count. Whatever fails here fails with them, too: they only add obstacles.

use contract::Merge;
use model::PairId;

use crate::candidate::Candidate;
use crate::conflict::Stuck;
use crate::search::Search;

/// Modes looked at before the next hop is placed all the same.
const LOOKS: u32 = 256;

impl Candidate<'_> {
    /// Finds a way to do the pair.
    pub(crate) fn serve(&mut self, search: &mut Search<'_>, pair: PairId) -> Result<(), Stuck> {
        self.ask_alternatives(search, &[pair])?;
        if search.statement.options.merge != Merge::PlacementToRoadmap {
            return self.has_alternative(search, pair);
        }
        self.looks = LOOKS;
        match self.ways_of(search, &[self.problem.pair(pair).robot]) {
            // Nothing is known, and nothing given up.
            Err(Stuck::Failed(_)) if self.looks == 0 => Ok(()),
            Err(stuck) => Err(stuck),
            Ok(_) => Ok(()),
        }
    }
}
