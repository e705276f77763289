//! All candidates in canonical order: by number of orders; sets of orders of one size take turns.

use std::collections::BTreeSet;

use contract::CauseTally;

use crate::network::{Overlaps, Stop};
use crate::order_sets::{OrderSet, OrderSets};
use crate::ordered::effort;
use crate::solutions::Solutions;

/// What the search for a further set of orders costs, against further candidates of the sets at hand.
const SET_EFFORT: u32 = 4;

/// A lazy enumeration of the candidates of one level.
pub(crate) struct Enumeration<'a> {
    sets: OrderSets<'a>,
    /// Sets of the present size, numbered as they were found.
    branches: Vec<Branch>,
    /// Turn and number of each branch that is not exhausted.
    turns: BTreeSet<(u32, usize)>,
    /// Whether all sets of the present size have been found.
    all_found: bool,
}

/// A set of orders with its candidates.
struct Branch {
    orders: OrderSet,
    solutions: Solutions,
    given_out: usize,
}

/// A candidate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Solved {
    /// A value for each site.
    pub values: Vec<usize>,
    /// Indices of orders, ascending.
    pub orders: OrderSet,
}

impl<'a> Enumeration<'a> {
    pub fn new(sets: OrderSets<'a>) -> Self {
        Self { sets, branches: Vec::new(), turns: BTreeSet::new(), all_found: false }
    }

    /// The next candidate; `None` when every combination has been given out.
    pub fn next(&mut self, overlaps: &mut dyn Overlaps) -> Result<Option<Solved>, Stop> {
        loop {
            let turn = self.turns.first().copied();
            let number = self.branches.len();
            if !self.all_found && turn.is_none_or(|(turn, _)| turn > turn_of(number, 0)) {
                self.find_set(overlaps)?;
            } else if let Some((_, number)) = turn {
                if let Some(solved) = self.take_turn(number, overlaps)? {
                    return Ok(Some(solved));
                }
            } else if self.sets.grow() {
                (self.branches, self.all_found) = (Vec::new(), false);
            } else {
                return Ok(None);
            }
        }
    }

    /// What stood in the way so far; see [`OrderSets::into_causes`].
    pub fn into_causes(self, rejected: &[CauseTally]) -> CauseTally {
        self.sets.into_causes(rejected)
    }

    fn find_set(&mut self, overlaps: &mut dyn Overlaps) -> Result<(), Stop> {
        match self.sets.next(overlaps)? {
            None => self.all_found = true,
            Some((orders, solutions)) => {
                self.turns.insert((turn_of(self.branches.len(), 0), self.branches.len()));
                self.branches.push(Branch { orders, solutions, given_out: 0 });
            }
        }
        Ok(())
    }

    fn take_turn(&mut self, number: usize, overlaps: &mut dyn Overlaps) -> Result<Option<Solved>, Stop> {
        let branch = &mut self.branches[number];
        let values = branch.solutions.next(overlaps)?;
        self.turns.remove(&(turn_of(number, branch.given_out), number));
        Ok(values.map(|values| {
            branch.given_out += 1;
            self.turns.insert((turn_of(number, branch.given_out), number));
            Solved { values, orders: branch.orders.clone() }
        }))
    }
}

/// When candidate `rank` of set `number` has its turn. Ever later ones of one set alternate with ever more sets.
fn turn_of(number: usize, rank: usize) -> u32 {
    SET_EFFORT * effort(number) + effort(rank)
}
