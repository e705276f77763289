//! All solutions of one network: those of its components, combined lazily by least total effort.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::network::{Network, Overlaps, Stop};
use crate::ordered::Component;

/// A lazy enumeration of the solutions of a network by (effort, values). Where the next one is hard to find, another
/// solution may come before it.
#[derive(Clone, Debug)]
pub(crate) struct Solutions {
    network: Network,
    components: Vec<Component>,
    frontier: BinaryHeap<Reverse<Combination>>,
    /// The last combination given out; its successors are made only when more is wanted.
    last: Option<Combination>,
    /// A solution, until the enumeration has begun.
    known: Option<Vec<usize>>,
    /// Steps in search of the next solution in order, after which any solution is taken.
    patience: u64,
}

/// One solution for each component. Ordered by effort, then values; what is unresolved comes before its like.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Combination {
    /// Of an unresolved combination, a lower bound.
    effort: u32,
    /// A value for each site; of an unresolved combination, zeros in the raised component.
    values: Vec<usize>,
    resolved: bool,
    /// For each component, which of its solutions.
    picks: Vec<usize>,
    /// The component whose pick was raised last: only it and later ones are raised further, so that none comes twice.
    raised: usize,
}

impl Solutions {
    /// All solutions of a network of which one is known.
    pub fn new(network: Network, known: Vec<usize>, patience: u64) -> Self {
        let components = network.components().into_iter().map(|sites| Component::new(&network, sites)).collect();
        Self { network, components, frontier: BinaryHeap::new(), last: None, known: Some(known), patience }
    }

    /// The next solution: a value for each site.
    pub fn next(&mut self, overlaps: &mut dyn Overlaps) -> Result<Option<Vec<usize>>, Stop> {
        if let Some(known) = self.known.take() {
            self.begin(&known, overlaps)?;
        }
        if let Some(last) = self.last.take() {
            self.push_successors(&last);
        }
        while let Some(Reverse(combination)) = self.frontier.pop() {
            if combination.resolved {
                let values = combination.values.clone();
                self.last = Some(combination);
                return Ok(Some(values));
            }
            if let Some(closer) = self.resolve(combination, overlaps)? {
                self.frontier.push(Reverse(closer));
            }
        }
        Ok(None)
    }

    fn begin(&mut self, known: &[usize], overlaps: &mut dyn Overlaps) -> Result<(), Stop> {
        let mut steps = self.patience;
        for component in &mut self.components {
            while component.found.is_empty() && !component.exhausted && steps > 0 {
                component.search(&self.network, &mut steps, overlaps)?;
            }
            if component.found.is_empty() {
                component.prefer(known);
            }
        }
        let picks = vec![0; self.components.len()];
        let (effort, values) = self.combine(&picks);
        self.frontier.push(Reverse(Combination { effort, values, resolved: true, picks, raised: 0 }));
        Ok(())
    }

    fn push_successors(&mut self, last: &Combination) {
        for raised in last.raised..self.components.len() {
            let mut next = last.clone();
            next.picks[raised] += 1;
            next.raised = raised;
            next.resolved = false;
            self.components[raised].sites.iter().for_each(|site| next.values[*site] = 0);
            self.frontier.push(Reverse(next));
        }
    }

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
            let mut steps = self.patience;
            component.search(&self.network, &mut steps, overlaps)?;
            if steps == 0 {
                component.leap(&self.network, self.patience, overlaps)?;
            }
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
