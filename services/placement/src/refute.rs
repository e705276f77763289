//! Whether a network has a solution at all; if not, which sites are at fault.
//!
//! Depth-first, smallest domain first, with forward checking and conflict-directed backjumping (Prosser, Computational
//! Intelligence 9 (1993) 268, doi:10.1111/j.1467-8640.1993.tb00310.x).

use crate::bits::{self, BitRows};
use crate::network::{Network, Overlaps, Stop};

/// Sites (as a set) whose constraints among one another leave no solution; `None` if there is a solution.
pub(crate) fn sites_at_fault(network: &Network, overlaps: &mut dyn Overlaps) -> Result<Option<Vec<u64>>, Stop> {
    let sites = network.len();
    let mut search = Search { network, overlaps, chosen: vec![None; sites] };
    let conflict = search.extend(&network.domains, &BitRows::new(sites, sites))?;
    Ok(conflict.map(|conflict| conflict.involved))
}

struct Search<'a> {
    network: &'a Network,
    overlaps: &'a mut dyn Overlaps,
    chosen: Vec<Option<usize>>,
}

/// Why a partial assignment cannot be completed.
struct Conflict {
    /// Sites whose choices are to blame.
    culprits: Vec<u64>,
    /// Sites that the refutation speaks of.
    involved: Vec<u64>,
}

impl Search<'_> {
    fn smallest_domain(&self, domains: &BitRows) -> Option<usize> {
        (0..self.chosen.len())
            .filter(|site| self.chosen[*site].is_none())
            .min_by_key(|site| bits::count(domains.row(*site)))
    }

    /// `pruned_by`: for each site, the sites whose choices took values from it.
    fn extend(&mut self, domains: &BitRows, pruned_by: &BitRows) -> Result<Option<Conflict>, Stop> {
        let Some(site) = self.smallest_domain(domains) else { return Ok(None) };
        let mut total = self.wiped_out(site, pruned_by);
        for value in bits::indices(domains.row(site)) {
            let Some(conflict) = self.try_value(site, value, domains, pruned_by)? else { return Ok(None) };
            if !bits::contains(&conflict.culprits, site) {
                return Ok(Some(conflict));
            }
            bits::unite(&mut total.culprits, &conflict.culprits);
            bits::unite(&mut total.involved, &conflict.involved);
        }
        bits::remove(&mut total.culprits, site);
        Ok(Some(total))
    }

    fn try_value(
        &mut self,
        site: usize,
        value: usize,
        domains: &BitRows,
        pruned_by: &BitRows,
    ) -> Result<Option<Conflict>, Stop> {
        self.overlaps.spend(1)?;
        let (mut domains, mut pruned_by) = (domains.clone(), pruned_by.clone());
        self.chosen[site] = Some(value);
        let record = |pruned: usize, by: usize| bits::insert(pruned_by.row_mut(pruned), by);
        let empty = self.network.propagate(self.overlaps, &mut domains, &self.chosen, site, record)?;
        let conflict = match empty {
            Some(other) => Some(self.wiped_out(other, &pruned_by)),
            None => self.extend(&domains, &pruned_by)?,
        };
        self.chosen[site] = None;
        Ok(conflict)
    }

    fn wiped_out(&self, site: usize, pruned_by: &BitRows) -> Conflict {
        let mut involved = vec![0; bits::words_for(self.chosen.len())];
        bits::insert(&mut involved, site);
        Conflict { culprits: pruned_by.row(site).to_vec(), involved }
    }
}
