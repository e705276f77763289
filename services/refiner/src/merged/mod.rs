//! The paper's ablations (Sec. IV): placement merged with the next step, or with the next two.
//!
//! Hops are placed one after another, and before the next one is placed its pair's alternatives (and roadmaps) are asked
//! for: chronological backtracking over hops, with causes conflict-directed (Prosser,
//! doi:10.1111/j.1467-8640.1993.tb00310.x). What is complete is refined as any placement candidate. Samples, random values,
//! jobs of later steps, budgets and nogoods are the same as without merging, so only the pipeline differs.

mod dead_end;
mod pair;
mod partial;

use contract::{Answer, CauseTally, Decision, HopChoice, HopJob, LedgerEntry, Literal, Request, StageKind};
use model::{FailurePolicy, PairId};
use skeleton::{Event, Occupancy, Skeleton};

use crate::asking::misfit;
use crate::budgets::Budgets;
use crate::candidate::Found;
use crate::conflict::{Conflict, Halt, Stuck};
use crate::search::{LevelEnd, Search, literals_of};
use dead_end::DeadEnd;
use partial::Partial;

/// Choices asked for at once.
const WINDOW: u32 = 256;

/// Why nothing comes of some places.
enum End {
    /// They cannot be completed.
    Dead(DeadEnd),
    /// As much was tried as a level may try.
    Enough,
    /// The run ends.
    Halted(Halt),
}

/// Places every hop of one level, one after the other.
struct HopByHop<'s, 'a> {
    search: &'s mut Search<'a>,
    level: u32,
    budgets: Budgets<'a>,
    skeleton: &'s Skeleton,
    /// Pairs in the sequence in which their hops are placed.
    hops: Vec<PairId>,
    nogoods: Vec<Vec<Literal>>,
    /// Places tried.
    tried: u64,
    /// Complete placements refined.
    complete: u32,
}

impl Search<'_> {
    /// One level with merged steps.
    pub(crate) fn level_hop_by_hop(&mut self, level: u32, skeleton: &Skeleton) -> Result<LevelEnd, Halt> {
        let budgets = Budgets::at(&self.problem().levels, level, &self.statement.options);
        self.place_at(level);
        let nothing = Partial::new(self, level, budgets, skeleton);
        let (hops, nogoods) = (in_topological_order(skeleton, self.problem().pairs.len()), Vec::new());
        let mut merged = HopByHop { search: self, level, budgets, skeleton, hops, nogoods, tried: 0, complete: 0 };
        match merged.descend(&nothing) {
            Ok(found) => Ok(LevelEnd::Solved(found)),
            Err(End::Dead(_) | End::Enough) => Ok(LevelEnd::Exhausted),
            Err(End::Halted(halt)) => Err(halt),
        }
    }
}

/// All pairs, one that releases earlier in every execution before one that releases later.
fn in_topological_order(skeleton: &Skeleton, pairs: usize) -> Vec<PairId> {
    let mut open: Vec<PairId> = (0..pairs).map(PairId::at).collect();
    let mut sequence = Vec::new();
    let earlier = |a: PairId, b: PairId| skeleton.graph.precedes(Event::release(a), Event::release(b));
    while let Some(next) = open.iter().position(|pair| !open.iter().any(|other| earlier(*other, *pair))) {
        sequence.push(open.remove(next));
    }
    sequence
}

impl<'a> HopByHop<'_, 'a> {
    /// Completes a placement: the next hop at each of its places in turn, and so on.
    fn descend(&mut self, partial: &Partial<'a>) -> Result<Found, End> {
        let at = partial.len();
        let Some(pair) = self.hops.get(at).copied() else { return self.complete(partial) };
        let mut dead = DeadEnd::default();
        for first in (0..).step_by(WINDOW as usize) {
            let choices = self.choices(partial, pair, first, &mut dead)?;
            let more = choices.len() == WINDOW as usize;
            for choice in choices {
                let failed = match self.place(partial, choice) {
                    Err(End::Dead(failed)) => failed,
                    ended => return ended,
                };
                if self.with_causes() && !failed.hops.contains(&at) {
                    return Err(End::Dead(failed));
                }
                dead.merge(failed);
            }
            if !more {
                break;
            }
        }
        dead.hops.remove(&at);
        Err(End::Dead(dead))
    }

    /// The next choices for a hop. That there are no others depends on what their samples collide with.
    fn choices(
        &mut self,
        partial: &Partial<'a>,
        pair: PairId,
        first: u32,
        dead: &mut DeadEnd,
    ) -> Result<Vec<HopChoice>, End> {
        let job = self.budgets.job(Request::Hop(HopJob {
            pair,
            level: self.level,
            placed: partial.placement.placements.clone(),
            orders: partial.placement.orders.iter().map(|order| (order.before, order.after)).collect(),
            first,
            count: WINDOW,
        }));
        match self.search.ask_one(&job)?.result {
            Ok(Answer::Hop { choices, against, causes }) => {
                if choices.is_empty() && first == 0 {
                    self.search.causes.count_all(&causes);
                    dead.cause = causes.into_iter().next().map(|(cause, _)| cause);
                }
                dead.hops.extend(against.iter().filter_map(|occupancy| self.position(*occupancy)));
                if !against.is_empty() {
                    dead.hops.extend(&partial.ordering);
                }
                Ok(choices)
            }
            Ok(_) => Err(Halt::from(misfit(StageKind::Placement)).into()),
            Err(report) => {
                self.search.causes.count_all(&report.causes);
                dead.hops.extend(0..partial.len());
                Ok(Vec::new())
            }
        }
    }

    /// Places one more hop, does its pair, and goes on.
    fn place(&mut self, partial: &Partial<'a>, choice: HopChoice) -> Result<Found, End> {
        let most = u64::from(self.search.statement.options.candidates).saturating_mul(self.hops.len() as u64);
        if self.tried >= most {
            return Err(End::Enough);
        }
        self.tried += 1;
        let orders = choice.orders.iter().map(|order| (order.before, order.after)).collect();
        let decision = Decision::Hop { pair: choice.placed.pair, sample: choice.placed.sample, orders };
        self.search.commit(LedgerEntry::Decided(decision.clone()));
        let mut next = partial.with(choice)?;
        let ended = match self.excluded(&next) {
            Some(dead) => Err(End::Dead(dead)),
            None => self.serve(&mut next).and_then(|()| self.descend(&next)),
        };
        if let Err(End::Dead(dead)) = &ended {
            self.search.backtrack(StageKind::Placement, decision, dead.cause.clone());
        }
        ended
    }

    /// Does the pair of the last hop.
    fn serve(&mut self, partial: &mut Partial<'a>) -> Result<(), End> {
        let Some(pair) = partial.placement.placements.last().map(|placed| placed.pair) else { return Ok(()) };
        match partial.candidate.serve(self.search, pair) {
            Ok(()) => Ok(()),
            Err(Stuck::Halted(halt)) => Err(End::Halted(halt)),
            Err(Stuck::Failed(conflict)) if self.search.policy(StageKind::Transition) == FailurePolicy::Stop => {
                self.search.commit(LedgerEntry::Stopped { stage: StageKind::Transition });
                Err(End::Halted(Halt::Stopped(conflict.causes.ranked())))
            }
            Err(Stuck::Failed(conflict)) => Err(End::Dead(self.learn(&conflict, partial))),
        }
    }

    /// Refines a complete placement like any other candidate.
    fn complete(&mut self, partial: &Partial<'a>) -> Result<Found, End> {
        let number = self.complete;
        if number >= self.search.statement.options.candidates {
            return Err(End::Enough);
        }
        self.complete += 1;
        self.search.commit(LedgerEntry::Decided(Decision::Placement(number)));
        let candidate = partial.whole(number, self.skeleton);
        match self.search.refine(self.level, self.skeleton, &candidate) {
            Ok(found) => Ok(found),
            Err(Stuck::Halted(halt)) => Err(End::Halted(halt)),
            Err(Stuck::Failed(conflict)) => {
                let decision = Decision::Placement(number);
                self.search.backtrack(StageKind::Placement, decision, conflict.first_cause());
                Err(End::Dead(self.learn(&conflict, partial)))
            }
        }
    }

    fn with_causes(&self) -> bool {
        self.search.policy(StageKind::Transition).tells_causes()
    }

    /// What a conflict says about the places so far; with causes it is kept as a nogood.
    fn learn(&mut self, conflict: &Conflict, partial: &Partial<'a>) -> DeadEnd {
        self.search.met = CauseTally::default();
        self.search.causes.count_all(&conflict.causes.clone().ranked());
        let literals = literals_of(self.search.problem(), conflict, &partial.placement);
        let dead = self.dead_end(&literals, partial, conflict.first_cause());
        if self.with_causes() {
            self.search.learn(self.level, conflict, &literals);
            self.nogoods.push(literals);
        }
        dead
    }

    /// The nogood that rules out the places so far, if there is one.
    fn excluded(&self, partial: &Partial<'a>) -> Option<DeadEnd> {
        let holds = |nogood: &&Vec<Literal>| nogood.iter().all(|literal| partial.holds(literal));
        let nogood = self.nogoods.iter().find(holds)?;
        Some(self.dead_end(nogood, partial, None))
    }

    /// The hops that literals speak of. An ordering may follow from all that were added.
    fn dead_end(&self, literals: &[Literal], partial: &Partial<'a>, cause: Option<plan::Cause>) -> DeadEnd {
        let mut dead = DeadEnd { cause, ..DeadEnd::default() };
        for literal in literals {
            match literal {
                Literal::Pose { occupancy, .. } => dead.hops.extend(self.position(*occupancy)),
                Literal::Order { .. } => dead.hops.extend(&partial.ordering),
                Literal::Alternative { .. } => {}
            }
        }
        dead
    }

    /// Which hop in the sequence makes an object stand there; a start pose is nobody's choice.
    fn position(&self, occupancy: Occupancy) -> Option<usize> {
        let hop = (occupancy.hop as usize).checked_sub(1)?;
        let pair = self.skeleton.hops.get(occupancy.object.index())?.get(hop)?;
        self.hops.iter().position(|other| other == pair)
    }
}

impl From<Halt> for End {
    fn from(halt: Halt) -> Self {
        Self::Halted(halt)
    }
}
