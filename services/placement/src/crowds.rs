//! Sets of sites that cannot all be taken at once, learnt once and for all order sets.

use std::collections::BTreeMap;

use skeleton::EventGraph;

use crate::bits;
use crate::layout::Layout;
use crate::network::{Network, Overlaps, Stop};
use crate::solve::{Solvability, solve};

/// Most sites for which the least number of orders is counted exactly.
const MOST_IN_A_QUEUE: usize = 9;

/// What a set of orders lacks to have solutions.
#[derive(Clone, Debug)]
pub(crate) struct Need {
    /// Pairs of sites that cannot all stay apart.
    pub pairs: Crowd,
    /// Orders of which every larger set with solutions has at least one.
    pub helpful: Vec<u64>,
    /// How many orders are lacking, at least.
    pub least: usize,
}

/// Pairs of sites that cannot all stay apart.
type Crowd = Vec<(usize, usize)>;

/// What is known of sites that do not go together. It rests on samples and unconditional nogoods alone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Crowds {
    /// Small crowds first.
    known: Vec<Crowd>,
    /// Sites of which no two can be taken at once: they must queue.
    queue: Vec<usize>,
}

impl Crowds {
    /// What the known crowds say of an order on events, if one of them stands in its way; `usable` are the orders that
    /// may be added to it. Of several crowds the one is named that the fewest orders help.
    pub fn need(&self, layout: &Layout, graph: &EventGraph, usable: &[u64]) -> Option<Need> {
        let all_meet = |pairs: &&Crowd| pairs.iter().all(|(a, b)| layout.may_coexist(graph, *a, *b));
        let mut helpful_of_pair = BTreeMap::new();
        let mut met: Vec<(Vec<u64>, &Crowd)> = Vec::new();
        for pairs in self.known.iter().filter(all_meet) {
            let mut helpful = vec![0; usable.len()];
            for pair in pairs {
                let of_pair = helpful_of_pair.entry(*pair).or_insert_with(|| layout.helpful(graph, *pair, usable));
                bits::unite(&mut helpful, of_pair);
            }
            met.push((helpful, pairs));
        }
        met.sort_by_key(|(helpful, _)| bits::count(helpful));
        // Crowds that have no helpful order in common need one each.
        let (mut taken, mut least) = (vec![0; usable.len()], 0);
        for (helpful, _) in &met {
            if helpful.iter().zip(&taken).all(|(word, taken)| word & taken == 0) {
                bits::unite(&mut taken, helpful);
                least += 1;
            }
        }
        let least = least.max(self.least_orders(layout, graph));
        let (helpful, pairs) = met.into_iter().next()?;
        Some(Need { pairs: pairs.clone(), helpful, least })
    }

    /// Learns a crowd, as small as it can be found, among sites that `network` shows to be one. Answers with the number of
    /// values tried.
    pub fn learn(
        &mut self,
        layout: &Layout,
        network: &Network,
        mut sites: Vec<usize>,
        tries: u64,
        overlaps: &mut dyn Overlaps,
    ) -> Result<u64, Stop> {
        let (mut kept, mut tried) = (0, 0);
        while kept < sites.len() {
            let mut fewer = sites.clone();
            fewer.remove(kept);
            let mut left = tries;
            match solve(network, &fewer, &mut left, overlaps)? {
                Solvability::AtFault(at_fault) => sites = at_fault,
                Solvability::Solution(_) | Solvability::Undecided(_) => kept += 1,
            }
            tried += tries - left;
        }
        let pairs = network.apart_among(&sites);
        self.known.insert(self.known.partition_point(|other| other.len() <= pairs.len()), pairs.clone());
        if let (true, [(a, b)]) = (self.queue.is_empty(), &pairs[..]) {
            self.queue = self.longest_queue(layout, network, [*a, *b], overlaps)?;
        }
        Ok(tried)
    }

    /// Grows a pair to sites of which every two collide at all samples. Such pairs are learnt as crowds.
    fn longest_queue(
        &mut self,
        layout: &Layout,
        network: &Network,
        pair: [usize; 2],
        overlaps: &mut dyn Overlaps,
    ) -> Result<Vec<usize>, Stop> {
        let mut queue = pair.to_vec();
        for site in layout.neighbours[pair[0]].iter().copied() {
            let fits = !queue.contains(&site) && queue.iter().all(|member| layout.neighbours[*member].contains(&site));
            if !fits || queue.len() == MOST_IN_A_QUEUE {
                continue;
            }
            let mut blocked = true;
            for member in queue.iter().copied() {
                blocked = blocked && never_apart(network, member, site, overlaps)?;
            }
            if blocked {
                self.known.extend(queue.iter().map(|member| vec![((*member).min(site), (*member).max(site))]));
                queue.push(site);
            }
        }
        self.known.sort_by_key(Vec::len);
        self.known.dedup();
        Ok(queue)
    }

    /// A lower bound on the number of orders that must still be added. Sites that must queue end up in one sequence, and
    /// an order makes at most one of its consecutive steps: so the bound is the least number of steps between sites that
    /// no order connects yet, over all sequences (the jump number of their partial order).
    fn least_orders(&self, layout: &Layout, graph: &EventGraph) -> usize {
        let n = self.queue.len();
        let before = |a: usize, b: usize| {
            let events = layout.order_events(self.queue[a], self.queue[b]);
            events.is_some_and(|(leaves, comes)| graph.precedes_or_is(leaves, comes))
        };
        let earlier: Vec<usize> = (0..n).map(|b| (0..n).filter(|a| before(*a, b)).map(|a| 1 << a).sum()).collect();
        // jumps[set][last]: of sequences of a set of sites that end with one of them.
        let mut jumps = vec![[usize::MAX; MOST_IN_A_QUEUE]; 1 << n];
        for set in 1_usize..1 << n {
            for last in (0..n).filter(|last| set >> last & 1 == 1) {
                let rest = set & !(1 << last);
                if earlier[last] & !rest != 0
                    || earlier.iter().enumerate().any(|(i, e)| rest >> i & 1 == 1 && e >> last & 1 == 1)
                {
                    continue;
                }
                let step = |previous: usize| {
                    let connected = earlier[last] >> previous & 1 == 1;
                    jumps[rest][previous].saturating_add(usize::from(!connected))
                };
                let ways = (0..n).filter(|previous| rest >> previous & 1 == 1).map(step);
                jumps[set][last] = ways.min().unwrap_or(0);
            }
        }
        let whole = jumps.last().map_or(0, |ends| ends.iter().copied().min().unwrap_or(0));
        if n < 2 || whole == usize::MAX { 0 } else { whole }
    }
}

/// Whether two sites collide at all of their samples.
fn never_apart(network: &Network, a: usize, b: usize, overlaps: &mut dyn Overlaps) -> Result<bool, Stop> {
    for value in bits::indices(network.domains.row(a)) {
        let colliding = overlaps.row(a, value, b)?;
        if network.domains.row(b).iter().zip(colliding).any(|(free, collide)| free & !collide != 0) {
            return Ok(false);
        }
    }
    Ok(true)
}
