//! Whether a network has a solution at all; if not, which sites are at fault.
//!
//! Depth-first, smallest domain first, with forward checking and conflict-directed backjumping (Prosser, Computational
//! Intelligence 9 (1993) 268, doi:10.1111/j.1467-8640.1993.tb00310.x).

use crate::bits::{self, BitRows};
use crate::network::{Network, Overlaps, Stop};

/// What is found out about a network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Solvability {
    /// There is a solution: this value for each site (0 for sites that were not asked about).
    Solution(Vec<usize>),
    /// The constraints of these sites (ascending) among one another leave none.
    AtFault(Vec<usize>),
    /// The limit was met; this site was left without a value most often.
    Undecided(usize),
}

/// Searches for values of `sites` (ascending), trying at most as many values as are `left`.
pub(crate) fn solve(
    network: &Network,
    sites: &[usize],
    left: &mut u64,
    overlaps: &mut dyn Overlaps,
) -> Result<Solvability, Stop> {
    let len = network.len();
    let mut search = Search { network, sites, overlaps, chosen: vec![None; len], wiped_out: vec![0; len], left };
    Ok(match search.extend(&network.domains, &BitRows::new(len, len))? {
        End::Solved => Solvability::Solution(search.chosen.iter().map(|value| value.unwrap_or(0)).collect()),
        End::Conflict(conflict) => Solvability::AtFault(bits::indices(&conflict.involved).collect()),
        End::Limit => {
            let most = sites.iter().copied().rev().max_by_key(|site| search.wiped_out[*site]);
            Solvability::Undecided(most.unwrap_or(0))
        }
    })
}

struct Search<'a> {
    network: &'a Network,
    sites: &'a [usize],
    overlaps: &'a mut dyn Overlaps,
    chosen: Vec<Option<usize>>,
    /// How often each site was left without a value.
    wiped_out: Vec<u64>,
    /// Values that may still be tried.
    left: &'a mut u64,
}

enum End {
    Solved,
    Conflict(Conflict),
    Limit,
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
        let open = self.sites.iter().copied().filter(|site| self.chosen[*site].is_none());
        open.min_by_key(|site| bits::count(domains.row(*site)))
    }

    /// `pruned_by`: for each site, the sites whose choices took values from it.
    fn extend(&mut self, domains: &BitRows, pruned_by: &BitRows) -> Result<End, Stop> {
        let Some(site) = self.smallest_domain(domains) else { return Ok(End::Solved) };
        let mut total = self.conflict_at(site, pruned_by);
        for value in bits::indices(domains.row(site)) {
            let conflict = match self.try_value(site, value, domains, pruned_by)? {
                End::Conflict(conflict) => conflict,
                end => return Ok(end),
            };
            if !bits::contains(&conflict.culprits, site) {
                return Ok(End::Conflict(conflict));
            }
            bits::unite(&mut total.culprits, &conflict.culprits);
            bits::unite(&mut total.involved, &conflict.involved);
        }
        bits::remove(&mut total.culprits, site);
        Ok(End::Conflict(total))
    }

    /// Leaves the value chosen if that is a part of a solution.
    fn try_value(&mut self, site: usize, value: usize, domains: &BitRows, pruned_by: &BitRows) -> Result<End, Stop> {
        let Some(left) = self.left.checked_sub(1) else { return Ok(End::Limit) };
        *self.left = left;
        self.overlaps.spend(1)?;
        let (mut domains, mut pruned_by) = (domains.clone(), pruned_by.clone());
        self.chosen[site] = Some(value);
        let among = |other: usize| self.sites.binary_search(&other).is_ok();
        let record = |pruned: usize, by: usize| bits::insert(pruned_by.row_mut(pruned), by);
        let empty = self.network.propagate(self.overlaps, &mut domains, &self.chosen, site, among, record)?;
        let end = match empty {
            Some(other) => {
                self.wiped_out[other] += 1;
                End::Conflict(self.conflict_at(other, &pruned_by))
            }
            None => self.extend(&domains, &pruned_by)?,
        };
        if !matches!(end, End::Solved) {
            self.chosen[site] = None;
        }
        Ok(end)
    }

    fn conflict_at(&self, site: usize, pruned_by: &BitRows) -> Conflict {
        let mut involved = vec![0; bits::words_for(self.chosen.len())];
        bits::insert(&mut involved, site);
        Conflict { culprits: pruned_by.row(site).to_vec(), involved }
    }
}
