//! Orderings that a mode's roadmap forces: a pose that is in every way must come later or be gone before.

use contract::{Decision, DiscoveredOrder, LedgerEntry, StageKind};
use model::Point;
use plan::{BodyRef, Cause};
use skeleton::{ArcOrigin, Event, Mode, ModeKind, Occupancy, Presence};

use crate::candidate::{Candidate, Found, Modes};
use crate::conflict::{Choice, Conflict, Order, Stuck};
use crate::known::Assumed;
use crate::search::Search;

/// A possible pose that is in every way of a mode.
pub(crate) struct Obstructed {
    mode: Mode,
    occupancy: Occupancy,
}

impl Candidate<'_> {
    /// The first mode that some possible pose obstructs wherever the robot goes.
    pub(crate) fn obstructed(&self, modes: &Modes) -> Option<Obstructed> {
        let mut answers = modes.iter().flatten().zip(self.skeleton.modes.iter().flatten());
        answers.find_map(|(answer, mode)| {
            let occupancy = self.first_to_order(mode, &answer.in_the_way)?;
            Some(Obstructed { mode: *mode, occupancy })
        })
    }

    /// The first of some poses that an ordering has to keep away from a mode, and can for all that is known of orderings.
    pub(crate) fn first_to_order(&self, mode: &Mode, in_the_way: &[Occupancy]) -> Option<Occupancy> {
        let allowed = |(before, after): &Order| before != after && !self.skeleton.graph.precedes(*after, *before);
        let needs_order = |pose: &&Occupancy| self.keeping_away(mode, **pose).iter().any(allowed);
        in_the_way.iter().find(needs_order).copied()
    }

    /// Tries the orderings that end an obstruction, each as a branch that is taken back if nothing comes of it. Without a
    /// plan the pose is to be reckoned with from now on.
    pub(crate) fn order(&mut self, search: &mut Search<'_>, obstructed: &Obstructed) -> Result<Option<Found>, Stuck> {
        let Obstructed { mode, occupancy } = obstructed;
        let mut why = Conflict::of([Choice::Pose(*occupancy)], &[(self.because(obstructed), 1)], None);
        for (before, after) in self.keeping_away(mode, *occupancy) {
            if before == after || self.skeleton.graph.precedes(after, before) {
                why.orders.extend(self.skeleton.graph.discovered_between(after, before));
                continue;
            }
            let refuted = self.refuted.iter().find(|conflict| self.is_refuted(conflict, (before, after))).cloned();
            let mut failed = match refuted {
                Some(failed) => failed,
                None => match self.branch(search, obstructed, (before, after))? {
                    Ok(found) => return Ok(Some(found)),
                    Err(failed) => failed,
                },
            };
            failed.orders.remove(&(before, after));
            why.merge(failed);
        }
        if self.patience == 0 {
            return Err(Stuck::Failed(why));
        }
        let Conflict { choices, orders, causes, .. } = why;
        self.known_mut(mode).assumed.push(Assumed { pose: *occupancy, orders, choices, causes });
        self.close_if_blocked(search, mode, *occupancy)?;
        Ok(None)
    }

    /// Whether a conflict shows that an ordering cannot be added to the present ones.
    fn is_refuted(&self, conflict: &Conflict, order: Order) -> bool {
        let mut others = conflict.orders.clone();
        others.remove(&order) && self.hold(&others)
    }

    /// Completes the candidate with one more ordering. A failure that does not rest on it is one without it, too.
    fn branch(
        &mut self,
        search: &mut Search<'_>,
        obstructed: &Obstructed,
        (before, after): Order,
    ) -> Result<Result<Found, Conflict>, Stuck> {
        let checkpoint = self.skeleton.graph.checkpoint();
        let order = DiscoveredOrder { before, after, cause: self.because(obstructed) };
        if self.skeleton.graph.add(before, after, ArcOrigin::Discovered).is_err() {
            return Ok(Err(Conflict::default()));
        }
        self.orders.push(order.clone());
        search.commit(LedgerEntry::Decided(Decision::Order(order.clone())));
        let failed = match self.settle(search) {
            Err(Stuck::Failed(failed)) => failed,
            ended => return ended.map(Ok),
        };
        search.backtrack(StageKind::Roadmap, Decision::Order(order), failed.first_cause());
        self.orders.pop();
        self.skeleton.graph.undo(checkpoint);
        if !failed.orders.contains(&(before, after)) {
            return Err(Stuck::Failed(failed));
        }
        self.refuted.push(failed.clone());
        Ok(Err(failed))
    }

    /// The orderings that would keep a pose away from a mode: it comes after the mode, or is gone before. None where it is
    /// away by the mode's event anyway.
    fn keeping_away(&self, mode: &Mode, occupancy: Occupancy) -> Vec<Order> {
        let present = self.skeleton.interval_of(occupancy);
        // A pose that is gone before the mode's event can be waited for.
        let is_gone = |to: Event| mode.ends.is_none_or(|ends| self.skeleton.graph.precedes_or_is(to, ends));
        let never = self.skeleton.graph.presence(present, mode.interval()) == Presence::Never;
        if never || present.to.is_some_and(is_gone) {
            return Vec::new();
        }
        let comes_later = present.from.zip(leaves(mode)).map(|(comes, left)| (left, comes));
        let gone_before = present.to.zip(arrives(mode));
        comes_later.into_iter().chain(gone_before).collect()
    }

    fn because(&self, obstructed: &Obstructed) -> Cause {
        let pair = obstructed.mode.pair.map(|pair| self.problem.pair(pair).name.clone());
        let object = &self.problem.movable[obstructed.occupancy.object.index()];
        Cause::NoPath {
            pair,
            robot: self.problem.robot(obstructed.mode.id.robot).name.clone(),
            blocking: vec![BodyRef::Object(object.name.clone())],
        }
    }
}

/// When a robot has left the way of a mode behind it: its arm is folded again.
fn leaves(mode: &Mode) -> Option<Event> {
    let pair = mode.pair?;
    Some(Event::new(pair, if mode.kind == ModeKind::Transit { Point::Carry } else { Point::Done }))
}

/// When a robot comes to the end of a mode's way: it arrives at the stand. A closing return sets out when its arm is home.
fn arrives(mode: &Mode) -> Option<Event> {
    match (mode.kind, mode.pair) {
        (ModeKind::Transit, Some(pair)) => Some(Event::new(pair, Point::AtPick)),
        (ModeKind::Transfer, Some(pair)) => Some(Event::new(pair, Point::AtPlace)),
        _ => mode.begins.map(|event| Event::new(event.pair, Point::Done)),
    }
}
