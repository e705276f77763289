//! The constraints on poses that hold under one set of orders, and what an assignment rules out.

use crate::bits::{self, BitRows};

/// Why a search ends before its answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Stop {
    /// The work units are used up.
    Budget,
    /// The job is over.
    Interrupted(contract::Interrupted),
}

/// Where the search learns which poses collide, and pays for its work.
pub(crate) trait Overlaps {
    /// The values of `second` at which it collides with `first` at `value`.
    fn row(&mut self, first: usize, value: usize, second: usize) -> Result<&[u64], Stop>;

    /// Pays.
    fn spend(&mut self, units: u64) -> Result<(), Stop>;
}

/// What the poses of two sites must do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    /// Both may be there at once: they must not collide.
    Apart,
    /// An order between them was added: they must collide, else the geometry does not force it.
    Overlapping,
}

/// Values of some sites that are not wanted together.
pub(crate) type Banned = Vec<(usize, usize)>;

/// A binary constraint network over sites. A site is a pose that an object takes, a value one of its samples.
#[derive(Clone, Debug)]
pub(crate) struct Network {
    /// Values that each site may take.
    pub domains: BitRows,
    links: Vec<Vec<(usize, Relation)>>,
    banned: Vec<Banned>,
    banned_of: Vec<Vec<usize>>,
}

impl Network {
    /// A network without constraints between sites.
    pub fn new(domains: BitRows, sites: usize) -> Self {
        Self { domains, links: vec![Vec::new(); sites], banned: Vec::new(), banned_of: vec![Vec::new(); sites] }
    }

    /// Number of sites.
    pub fn len(&self) -> usize {
        self.links.len()
    }

    /// Constrains two sites.
    pub fn link(&mut self, a: usize, b: usize, relation: Relation) {
        self.links[a].push((b, relation));
        self.links[b].push((a, relation));
    }

    /// Forbids a combination: a single value at once, more when all but one are assigned.
    pub fn ban(&mut self, values: Banned) {
        if let [(site, value)] = values[..] {
            bits::remove(self.domains.row_mut(site), value);
            return;
        }
        values.iter().for_each(|(site, _)| self.banned_of[*site].push(self.banned.len()));
        self.banned.push(values);
    }

    /// Whether values that obey the links are allowed for every single site, and form no banned combination.
    pub fn admits(&self, values: &[usize]) -> bool {
        let free = values.iter().enumerate().all(|(site, value)| bits::contains(self.domains.row(site), *value));
        free && !self.banned.iter().any(|ban| ban.iter().all(|(site, value)| values[*site] == *value))
    }

    /// Pairs of sites among `sites` (ascending) that must stay apart.
    pub fn apart_among(&self, sites: &[usize]) -> Vec<(usize, usize)> {
        let links = sites.iter().flat_map(|a| self.links[*a].iter().map(move |(b, relation)| (*a, *b, *relation)));
        links
            .filter(|(a, b, relation)| a < b && *relation == Relation::Apart && sites.binary_search(b).is_ok())
            .map(|(a, b, _)| (a, b))
            .collect()
    }

    /// Sites that constrain one another, directly or through others: sets of ascending sites, by their first one.
    pub fn components(&self) -> Vec<Vec<usize>> {
        let mut component_of: Vec<Option<usize>> = vec![None; self.len()];
        let mut components = Vec::new();
        for start in 0..self.len() {
            if component_of[start].is_some() {
                continue;
            }
            let mut members = vec![start];
            component_of[start] = Some(components.len());
            let mut next = 0;
            while next < members.len() {
                let site = members[next];
                let through_bans = self.banned_of[site].iter().flat_map(|ban| &self.banned[*ban]).map(|(s, _)| *s);
                for other in self.links[site].iter().map(|(other, _)| *other).chain(through_bans) {
                    if component_of[other].is_none() {
                        component_of[other] = Some(components.len());
                        members.push(other);
                    }
                }
                next += 1;
            }
            members.sort_unstable();
            components.push(members);
        }
        components
    }

    /// Takes from `domains` what the last choice, that of `site`, rules out at sites without a choice, as far as they are
    /// `among` those that count. Calls `pruned(other, by)` for what it takes. Answers with a site that is left without a
    /// value, if there is one.
    pub fn propagate(
        &self,
        overlaps: &mut dyn Overlaps,
        domains: &mut BitRows,
        chosen: &[Option<usize>],
        site: usize,
        among: impl Fn(usize) -> bool,
        mut pruned: impl FnMut(usize, usize),
    ) -> Result<Option<usize>, Stop> {
        let Some(value) = chosen[site] else { return Ok(None) };
        for (other, relation) in &self.links[site] {
            if chosen[*other].is_some() || !among(*other) {
                continue;
            }
            let colliding = overlaps.row(site, value, *other)?;
            let (mut changed, mut left) = (false, 0);
            for (word, collide) in domains.row_mut(*other).iter_mut().zip(colliding) {
                let kept = *word & if *relation == Relation::Apart { !collide } else { *collide };
                changed |= kept != *word;
                left |= kept;
                *word = kept;
            }
            if changed {
                pruned(*other, site);
            }
            if left == 0 {
                return Ok(Some(*other));
            }
        }
        Ok(self.propagate_bans(domains, chosen, site, among, pruned))
    }

    fn propagate_bans(
        &self,
        domains: &mut BitRows,
        chosen: &[Option<usize>],
        site: usize,
        among: impl Fn(usize) -> bool,
        mut pruned: impl FnMut(usize, usize),
    ) -> Option<usize> {
        for ban in self.banned_of[site].iter().map(|ban| &self.banned[*ban]) {
            let mut open = ban.iter().filter(|(s, value)| chosen[*s] != Some(*value));
            let (Some(&(other, value)), None) = (open.next(), open.next()) else { continue };
            if chosen[other].is_none() && among(other) && bits::contains(domains.row(other), value) {
                bits::remove(domains.row_mut(other), value);
                ban.iter().filter(|(s, _)| *s != other).for_each(|(s, _)| pruned(other, *s));
                if bits::count(domains.row(other)) == 0 {
                    return Some(other);
                }
            }
        }
        None
    }
}
