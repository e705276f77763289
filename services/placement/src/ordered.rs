//! Solutions of one component of a network, one after another, by effort and then lexicographically.

use std::collections::BTreeSet;

use crate::bits::{self, BitRows};
use crate::network::{Network, Overlaps, Stop};
use crate::solve::{Solvability, solve};

/// What a value costs: the bit length of its index, so 0, 1, 2, 2, 3, 3, 3, 3, 4… A search by least total effort treats
/// all hops alike, yet comes to late samples of a single hop long before it has tried every combination of earlier ones.
pub(crate) fn effort(value: usize) -> u32 {
    usize::BITS - value.leading_zeros()
}

/// One solution: a value for each of the component's sites.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Solution {
    pub effort: u32,
    pub values: Vec<usize>,
}

/// A lazy enumeration: depth-first with forward checking, level by level of total effort.
#[derive(Clone, Debug)]
pub(crate) struct Component {
    /// Ascending.
    pub sites: Vec<usize>,
    /// Solutions found so far, in order.
    pub found: Vec<Solution>,
    /// No further solution has less effort than this.
    pub level: u32,
    /// Whether there is none left.
    pub exhausted: bool,
    greatest_effort: u32,
    /// Solutions that came out of turn.
    preferred: BTreeSet<Vec<usize>>,
    chosen: Vec<Option<usize>>,
    path: Vec<Frame>,
}

#[derive(Clone, Debug)]
struct Frame {
    domains: BitRows,
    /// Least value not yet tried at this depth.
    next_value: usize,
    /// Effort of the choices above.
    effort: u32,
}

impl Component {
    pub fn new(network: &Network, sites: Vec<usize>) -> Self {
        let efforts = sites.iter().map(|site| effort_range(network.domains.row(*site)));
        let (level, greatest_effort, solvable) =
            efforts.fold((0, 0, true), |(low, high, solvable), range| match range {
                Some((least, greatest)) => (low + least, high + greatest, solvable),
                None => (low, high, false),
            });
        let (found, chosen, path) = (Vec::new(), vec![None; network.len()], Vec::new());
        Self { sites, found, level, exhausted: !solvable, greatest_effort, preferred: BTreeSet::new(), chosen, path }
    }

    /// Searches until the next solution, to the end of a level, or for `steps`. Either `found` grows, or `level`, or it is
    /// exhausted, or there are no steps left.
    pub fn search(&mut self, network: &Network, steps: &mut u64, overlaps: &mut dyn Overlaps) -> Result<(), Stop> {
        if self.exhausted {
            return Ok(());
        }
        if self.path.is_empty() {
            self.path.push(Frame { domains: network.domains.clone(), next_value: 0, effort: 0 });
        }
        while let Some(depth) = self.path.len().checked_sub(1) {
            if *steps == 0 {
                return Ok(());
            }
            *steps -= 1;
            if self.step(depth, network, overlaps)? {
                return Ok(());
            }
        }
        self.level += 1;
        self.exhausted = self.level > self.greatest_effort;
        Ok(())
    }

    /// Tries one value at the deepest frame. `true`: a solution was found.
    fn step(&mut self, depth: usize, network: &Network, overlaps: &mut dyn Overlaps) -> Result<bool, Stop> {
        let site = self.sites[depth];
        self.chosen[site] = None;
        let frame = &mut self.path[depth];
        let value = bits::next_from(frame.domains.row(site), frame.next_value);
        let Some(value) = value.filter(|value| frame.effort + effort(*value) <= self.level) else {
            self.path.pop();
            return Ok(false);
        };
        overlaps.spend(1)?;
        frame.next_value = value + 1;
        let spent = frame.effort + effort(value);
        self.chosen[site] = Some(value);
        if depth + 1 == self.sites.len() {
            return Ok(spent == self.level && self.keep_solution(spent));
        }
        let mut domains = frame.domains.clone();
        let empty = network.propagate(overlaps, &mut domains, &self.chosen, site, |_| true, |_, _| ())?;
        if empty.is_none() && self.level_in_reach(depth + 1, spent, &domains) {
            self.path.push(Frame { domains, next_value: 0, effort: spent });
        }
        Ok(false)
    }

    fn level_in_reach(&self, depth: usize, spent: u32, domains: &BitRows) -> bool {
        let (mut least, mut greatest) = (spent, spent);
        for site in &self.sites[depth..] {
            let Some((low, high)) = effort_range(domains.row(*site)) else { return false };
            least += low;
            greatest += high;
        }
        (least..=greatest).contains(&self.level)
    }

    /// Puts a known solution before those that are not found yet.
    pub fn prefer(&mut self, values: &[usize]) {
        let values: Vec<usize> = self.sites.iter().map(|site| values[*site]).collect();
        let effort = values.iter().map(|value| effort(*value)).sum();
        self.preferred.insert(values.clone());
        self.found.push(Solution { effort, values });
    }

    /// Looks for any further solution, out of turn.
    pub fn leap(&mut self, network: &Network, mut tries: u64, overlaps: &mut dyn Overlaps) -> Result<(), Stop> {
        let mut rest = network.clone();
        for solution in &self.found {
            rest.ban(self.sites.iter().copied().zip(solution.values.iter().copied()).collect());
        }
        match solve(&rest, &self.sites, &mut tries, overlaps)? {
            Solvability::Solution(values) => self.prefer(&values),
            Solvability::AtFault(_) => self.exhausted = true,
            Solvability::Undecided(_) => {}
        }
        Ok(())
    }

    /// Keeps the chosen values as a solution, unless it is the preferred one. `true`: it is kept.
    fn keep_solution(&mut self, effort: u32) -> bool {
        let values: Vec<usize> = self.sites.iter().filter_map(|site| self.chosen[*site]).collect();
        let is_new = !self.preferred.contains(&values);
        if is_new {
            self.found.push(Solution { effort, values });
        }
        is_new
    }
}

fn effort_range(domain: &[u64]) -> Option<(u32, u32)> {
    Some((effort(bits::next_from(domain, 0)?), effort(bits::greatest(domain)?)))
}
