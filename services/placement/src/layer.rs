//! Solutions under all sets of orders of one size, merged.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::network::{Network, Overlaps, Stop};
use crate::ordered::Component;

/// The networks of one layer, each with its set of orders, and a frontier of combinations of component solutions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layer {
    branches: Vec<Branch>,
    frontier: BinaryHeap<Reverse<Combination>>,
    /// The last combination given out; its successors are made only when more is wanted.
    last: Option<Combination>,
}

/// A solvable network.
#[derive(Clone, Debug)]
struct Branch {
    orders: Vec<usize>,
    network: Network,
    components: Vec<Component>,
}

/// One solution for each component of a branch. Ordered by effort, then values; what is unresolved comes before its like.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Combination {
    /// Of an unresolved combination, a lower bound.
    effort: u32,
    /// A value for each site; of an unresolved combination, zeros in the raised component.
    values: Vec<usize>,
    resolved: bool,
    branch: usize,
    /// For each component, which of its solutions.
    picks: Vec<usize>,
    /// The component whose pick was raised last: only it and later ones are raised further, so that none comes twice.
    raised: usize,
}

/// A solution with its set of orders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Solved {
    /// A value for each site.
    pub values: Vec<usize>,
    /// Indices of orders, ascending.
    pub orders: Vec<usize>,
}

impl Layer {
    /// Adds a solvable network. Branches must be added in ascending order of their sets of orders.
    pub fn add(&mut self, orders: Vec<usize>, network: Network, overlaps: &mut dyn Overlaps) -> Result<(), Stop> {
        let mut components: Vec<Component> =
            network.components().into_iter().map(|sites| Component::new(&network, sites)).collect();
        for component in &mut components {
            while component.found.is_empty() && !component.exhausted {
                component.search(&network, overlaps)?;
            }
        }
        if components.iter().any(|component| component.found.is_empty()) {
            return Ok(());
        }
        let picks = vec![0; components.len()];
        let branch = self.branches.len();
        self.branches.push(Branch { orders, network, components });
        let (effort, values) = self.branches[branch].combine(&picks);
        self.frontier.push(Reverse(Combination { effort, values, resolved: true, branch, picks, raised: 0 }));
        Ok(())
    }

    /// The next solution by (effort, values, set of orders).
    pub fn next(&mut self, overlaps: &mut dyn Overlaps) -> Result<Option<Solved>, Stop> {
        if let Some(last) = self.last.take() {
            self.push_successors(&last);
        }
        while let Some(Reverse(combination)) = self.frontier.pop() {
            if combination.resolved {
                let orders = self.branches[combination.branch].orders.clone();
                let values = combination.values.clone();
                self.last = Some(combination);
                return Ok(Some(Solved { values, orders }));
            }
            if let Some(closer) = self.branches[combination.branch].resolve(combination, overlaps)? {
                self.frontier.push(Reverse(closer));
            }
        }
        Ok(None)
    }

    fn push_successors(&mut self, last: &Combination) {
        let components = &self.branches[last.branch].components;
        for raised in last.raised..components.len() {
            let mut next = last.clone();
            next.picks[raised] += 1;
            next.raised = raised;
            next.resolved = false;
            components[raised].sites.iter().for_each(|site| next.values[*site] = 0);
            self.frontier.push(Reverse(next));
        }
    }
}

impl Branch {
    /// Effort and values of a combination whose solutions have all been found.
    fn combine(&self, picks: &[usize]) -> (u32, Vec<usize>) {
        let mut values = vec![0; self.network.len()];
        let mut effort = 0;
        for (component, pick) in self.components.iter().zip(picks) {
            let solution = &component.found[*pick];
            effort += solution.effort;
            component.sites.iter().zip(&solution.values).for_each(|(site, value)| values[*site] = *value);
        }
        (effort, values)
    }

    /// One step towards the raised component's solution; `None` if it has no more.
    fn resolve(&mut self, mut at: Combination, overlaps: &mut dyn Overlaps) -> Result<Option<Combination>, Stop> {
        let component = &mut self.components[at.raised];
        if component.found.len() <= at.picks[at.raised] {
            component.search(&self.network, overlaps)?;
        }
        let (found, level, exhausted) = (component.found.len(), component.level, component.exhausted);
        if found > at.picks[at.raised] {
            (at.effort, at.values) = self.combine(&at.picks);
            at.resolved = true;
        } else if exhausted {
            return Ok(None);
        } else {
            at.effort = self.rest_of_effort(&at) + level;
        }
        Ok(Some(at))
    }

    /// Effort of all components but the raised one.
    fn rest_of_effort(&self, at: &Combination) -> u32 {
        let others = self.components.iter().zip(&at.picks).enumerate().filter(|(index, _)| *index != at.raised);
        others.map(|(_, (component, pick))| component.found[*pick].effort).sum()
    }
}
