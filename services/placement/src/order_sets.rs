//! Sets of orders under which the poses have solutions, small sets first.
//!
//! A set without a solution is extended only by orders that could keep apart a pair of a crowd, so that orders appear where
//! the geometry asks for them; a set with solutions is extended by every order. Sizes are tried in ascending order, each by
//! a depth-first search.
//!
//! The search is limited, in the whole and in the work on each network. If it finds nothing because of that, a set is taken
//! from one sequence of all events and thinned out; then all begins anew with higher limits.

use std::collections::BTreeSet;

use contract::CauseTally;

use crate::bits;
use crate::network::{Overlaps, Stop};
use crate::sequence::set_of_sequence;
use crate::solutions::Solutions;
use crate::verdict::{Judge, Setting, Verdict};

/// Factor of limits from round to round.
const LIMIT_GROWTH: u64 = 8;
/// Work units of a visit to a set, besides one for each order of the problem.
const VISIT: u64 = 60;

/// Indices of orders, ascending.
pub(crate) type OrderSet = Vec<usize>;

/// How long to search in order before something out of order is taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patience {
    /// Work (tries, and visits to sets) of the first round.
    pub work: u64,
    /// Values tried for one network in the first round before it is left undecided.
    pub tries: u64,
    /// Steps towards the next solution of one network.
    pub steps: u64,
}

impl Default for Patience {
    fn default() -> Self {
        Self { work: 1_000_000, tries: 50_000, steps: 20_000 }
    }
}

/// A lazy search for sets of orders.
pub(crate) struct OrderSets<'a> {
    judge: Judge<'a>,
    patience: Patience,
    given_out: BTreeSet<OrderSet>,
    size: usize,
    limits: Limits,
    pass: Pass,
    sequence: SequenceState,
}

/// Limits of one round.
struct Limits {
    work: u64,
    left: u64,
    /// Values tried for one network.
    tries: u64,
    /// Whether one was met.
    met: bool,
}

/// Whether a set is taken from a sequence; at most once.
#[derive(PartialEq, Eq)]
enum SequenceState {
    NotNeeded,
    Due,
    Done,
}

/// Depth-first search for sets of at most one size.
#[derive(Default)]
struct Pass {
    pending: Vec<OrderSet>,
    seen: BTreeSet<OrderSet>,
    /// Least size that a set left aside needs.
    next_size: Option<usize>,
}

impl<'a> OrderSets<'a> {
    pub fn new(judge: Judge<'a>, patience: Patience) -> Self {
        let (given_out, pass, sequence) = (BTreeSet::new(), Pass::begin(), SequenceState::NotNeeded);
        let limits = Limits::new(patience.work, patience.tries);
        Self { judge, patience, given_out, size: 0, limits, pass, sequence }
    }

    /// The next set of the present size with its solutions; `None` when no more is found.
    pub fn next(&mut self, overlaps: &mut dyn Overlaps) -> Result<Option<(OrderSet, Solutions)>, Stop> {
        if self.sequence == SequenceState::Due {
            self.sequence = SequenceState::Done;
            let found = set_of_sequence(&mut self.judge, overlaps)?;
            return Ok(found.and_then(|(set, values)| self.give_out(set, values)));
        }
        while let Some(orders) = self.pass.pending.pop() {
            if !self.pass.seen.insert(orders.clone()) {
                continue;
            }
            if self.limits.left == 0 {
                self.limits.met = true;
                self.pass.next_size = None;
                return Ok(None);
            }
            let set = Setting::new(self.judge.layout, orders);
            let verdict = self.verdict(&set, overlaps)?;
            self.extend(&set, &verdict);
            if let (Verdict::Solvable(values), false) = (verdict, self.given_out.contains(&set.orders)) {
                return Ok(self.give_out(set.orders, values));
            }
        }
        Ok(None)
    }

    fn verdict(&mut self, set: &Setting, overlaps: &mut dyn Overlaps) -> Result<Verdict, Stop> {
        let visit = VISIT + self.judge.layout.orders.len() as u64;
        overlaps.spend(visit)?;
        let tried_before = self.judge.tried;
        let verdict = self.judge.verdict(set, self.limits.tries, overlaps)?;
        self.limits.left = self.limits.left.saturating_sub(visit + self.judge.tried - tried_before);
        self.limits.met |= matches!(verdict, Verdict::Undecided { .. });
        Ok(verdict)
    }

    fn give_out(&mut self, set: OrderSet, known: Vec<usize>) -> Option<(OrderSet, Solutions)> {
        let network = self.judge.network(&set, &self.judge.layout.graph_with(&set))?;
        self.given_out.insert(set.clone());
        Some((set, Solutions::new(network, known, self.patience.steps)))
    }

    /// Goes on to the next size. `false`: there are no more sets.
    pub fn grow(&mut self) -> bool {
        let next = self.pass.next_size.filter(|size| *size <= self.judge.layout.orders.len());
        if let Some(size) = next {
            self.size = size;
        } else if self.limits.met && self.given_out.is_empty() && self.sequence == SequenceState::NotNeeded {
            self.sequence = SequenceState::Due;
            return true;
        } else if self.limits.met {
            self.size = 0;
            self.limits = self.limits.raised();
        } else {
            return false;
        }
        self.pass = Pass::begin();
        true
    }

    /// What stood in the way so far; see [`Judge::into_causes`].
    pub fn into_causes(self, rejected: &[CauseTally]) -> CauseTally {
        self.judge.into_causes(rejected)
    }

    /// Puts the sets one larger on the list, or says that they are left aside.
    fn extend(&mut self, set: &Setting, verdict: &Verdict) {
        let (helpful, least) = match verdict {
            Verdict::Hopeless | Verdict::Undecided { .. } => return,
            Verdict::Solvable(_) => (&set.usable, 1),
            Verdict::Crowded(need) => (&need.helpful, need.least.max(1)),
        };
        if set.orders.len() + least > self.size {
            self.pass.leave_aside(set.orders.len() + least);
            return;
        }
        let larger = bits::indices(helpful).map(|index| {
            let mut larger = set.orders.clone();
            larger.insert(larger.partition_point(|other| *other < index), index);
            larger
        });
        let larger: Vec<OrderSet> = larger.collect();
        self.pass.pending.extend(larger.into_iter().rev());
    }
}

impl Limits {
    fn new(work: u64, tries: u64) -> Self {
        Self { work, left: work, tries, met: false }
    }

    fn raised(&self) -> Self {
        Self::new(self.work.saturating_mul(LIMIT_GROWTH), self.tries.saturating_mul(LIMIT_GROWTH))
    }
}

impl Pass {
    fn begin() -> Self {
        Self { pending: vec![Vec::new()], ..Self::default() }
    }

    fn leave_aside(&mut self, size: usize) {
        self.next_size = Some(self.next_size.map_or(size, |other| other.min(size)));
    }
}
