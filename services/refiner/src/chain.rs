//! The cheapest way through the pairs of one robot: one alternative of each, and a step from each to the next.
//!
//! A transit joins the alternatives of two consecutive pairs of a robot and nothing else, so a robot's alternatives form
//! a chain, and which are best is found exactly (Viterbi, doi:10.1109/TIT.1967.1054010).

use std::ops::RangeInclusive;

/// What an alternative or a step costs, the first number first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Cost {
    /// How often a failure was laid to it that rests on other robots, too.
    pub(crate) penalties: u32,
    /// Poses in its way for which an ordering would have to be added.
    pub(crate) obstructions: u32,
    /// Poses that may be in its way.
    pub(crate) possible: u32,
    /// Its rank among the alternatives.
    pub(crate) rank: u32,
}

impl std::ops::Add for Cost {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            penalties: self.penalties.saturating_add(other.penalties),
            obstructions: self.obstructions.saturating_add(other.obstructions),
            possible: self.possible.saturating_add(other.possible),
            rank: self.rank.saturating_add(other.rank),
        }
    }
}

/// Alternatives of a robot's pairs in order. `None`: it cannot be.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chain {
    /// `alternatives[pair][alternative]`.
    pub(crate) alternatives: Vec<Vec<Option<Cost>>>,
    /// `steps[pair][alternative][alternative of the next pair]`.
    pub(crate) steps: Vec<Vec<Vec<Option<Cost>>>>,
}

impl Chain {
    /// The cheapest alternatives, of several the first; or a shortest run of pairs through which there is no way.
    pub(crate) fn best(&self) -> Result<Vec<usize>, RangeInclusive<usize>> {
        let last = self.alternatives.len();
        let reached = self.reach(0, last);
        if let Some(dead) = reached.iter().position(|layer| is_dead(layer)) {
            let leads_nowhere = |from: &usize| self.reach(*from, dead + 1).last().is_some_and(|layer| is_dead(layer));
            let from = (0..=dead).rev().find(leads_nowhere);
            return Err(from.unwrap_or(0)..=dead);
        }
        let Some(layer) = reached.last() else { return Ok(Vec::new()) };
        let cheapest = (0..layer.len()).filter(|i| layer[*i].is_some()).min_by_key(|i| (layer[*i], *i));
        let mut best: Vec<usize> = cheapest.into_iter().collect();
        for layer in reached[1..].iter().rev() {
            best.extend(best.last().and_then(|at| layer[*at]).map(|(_, from)| from));
        }
        best.reverse();
        Ok(best)
    }

    /// Least cost to every alternative of the pairs `from..to`, and the alternative before it.
    fn reach(&self, from: usize, to: usize) -> Vec<Vec<Option<(Cost, usize)>>> {
        let mut reached: Vec<Vec<Option<(Cost, usize)>>> = Vec::new();
        for pair in from..to {
            let own = |i: usize| self.alternatives[pair][i];
            let layer = (0..self.alternatives[pair].len()).map(|i| match reached.last() {
                None => own(i).map(|cost| (cost, 0)),
                Some(before) => {
                    let through = |j: usize| Some((before[j]?.0 + self.steps[pair - 1][j][i]? + own(i)?, j));
                    (0..before.len()).filter_map(through).min()
                }
            });
            let layer = layer.collect();
            reached.push(layer);
        }
        reached
    }
}

fn is_dead(layer: &[Option<(Cost, usize)>]) -> bool {
    layer.iter().all(Option::is_none)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random_chain(seed: u64) -> Chain {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let mut next = move |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % n
        };
        let pairs = 1 + next(4) as usize;
        let lengths: Vec<usize> = (0..pairs).map(|_| next(4) as usize).collect();
        let often = next(5);
        let mut cost = || (next(5) >= often).then(|| Cost { rank: next(4) as u32, ..Cost::default() });
        let alternatives = lengths.iter().map(|n| (0..*n).map(|_| cost()).collect()).collect();
        let steps =
            lengths.windows(2).map(|n| (0..n[0]).map(|_| (0..n[1]).map(|_| cost()).collect()).collect()).collect();
        Chain { alternatives, steps }
    }

    /// Costs of all ways through pairs `from..=to`.
    fn all_ways(chain: &Chain, from: usize, to: usize) -> Vec<(Cost, Vec<usize>)> {
        let mut ways: Vec<(Cost, Vec<usize>)> = vec![(Cost::default(), Vec::new())];
        for pair in from..=to {
            let mut longer = Vec::new();
            for (cost, way) in &ways {
                for i in 0..chain.alternatives[pair].len() {
                    let step = way.last().map_or(Some(Cost::default()), |j| chain.steps[pair - 1][*j][i]);
                    if let (Some(step), Some(own)) = (step, chain.alternatives[pair][i]) {
                        longer.push((*cost + step + own, [way.clone(), vec![i]].concat()));
                    }
                }
            }
            ways = longer;
        }
        ways
    }

    #[test]
    fn the_best_way_is_the_cheapest_of_all_and_a_run_without_way_is_as_short_as_can_be() {
        let (mut ways, mut dead) = (0, 0);
        for seed in 0..4000 {
            let chain = random_chain(seed);
            let last = chain.alternatives.len() - 1;
            let all = all_ways(&chain, 0, last);
            match chain.best() {
                Ok(best) => {
                    let least = all.iter().map(|(cost, _)| *cost).min();
                    let own = all.iter().find(|(_, way)| *way == best).map(|(cost, _)| *cost);
                    assert!(least.is_some() && own == least, "seed {seed}: {best:?}");
                    ways += 1;
                }
                Err(run) => {
                    assert!(all_ways(&chain, *run.start(), *run.end()).is_empty(), "seed {seed}: {run:?}");
                    let shorter = [(run.start() + 1, *run.end()), (*run.start(), run.end().wrapping_sub(1))];
                    for (from, to) in shorter.into_iter().filter(|(from, to)| from <= to && *to <= last) {
                        assert!(!all_ways(&chain, from, to).is_empty(), "seed {seed}: {run:?}");
                    }
                    dead += 1;
                }
            }
        }
        assert!(ways > 500 && dead > 500, "{ways} {dead}");
    }
}
