//! Orderings that a mode's roadmap forces: a pose that is in every way must come later or be gone before.

use contract::{Decision, DiscoveredOrder, LedgerEntry, StageKind};
use model::{PairId, Point};
use plan::{BodyRef, Cause};
use skeleton::{ArcOrigin, Event, Interval, Mode, ModeKind, Occupancy, Presence};

use crate::candidate::{Candidate, Found, Modes};
use crate::conflict::{Choice, Conflict, Stuck};
use crate::search::Search;

/// Other ways to do a pair that are looked at before an ordering is added.
const DETOURS: u32 = 12;

/// A possible pose that is in every way of a mode.
pub(crate) struct Obstructed {
    mode: Mode,
    occupancy: Occupancy,
}

impl Candidate<'_> {
    /// The first mode that some possible pose obstructs wherever the robot goes.
    pub(crate) fn obstructed(&self, modes: &Modes) -> Option<Obstructed> {
        let answers = modes.iter().flatten().zip(self.skeleton.modes.iter().flatten());
        answers
            .filter_map(|(answer, mode)| Some(Obstructed { mode: *mode, occupancy: *answer.in_the_way.first()? }))
            .find(|obstructed| !self.branches(obstructed).is_empty())
    }

    /// Least commitment: a few other ways to do the pair are looked at before an ordering is added. Whether the pair is now
    /// done in another way.
    pub(crate) fn detour(&mut self, search: &mut Search<'_>, obstructed: &Obstructed) -> bool {
        let Some(pair) = obstructed.mode.pair else { return false };
        let detour = &mut self.detours[pair.index()];
        if detour.steps == 0 {
            detour.from = self.choices[pair.index()].position();
        }
        let goes_on = detour.steps < DETOURS;
        if goes_on {
            self.step_aside(search, pair);
        }
        goes_on
    }

    /// A failure on a detour costs the detour, not the alternative from which it began. Whether the pair was on one.
    pub(crate) fn leaves_detour(&mut self, search: &mut Search<'_>, pair: PairId) -> bool {
        let on_one = (1..DETOURS).contains(&self.detours[pair.index()].steps);
        if on_one {
            self.step_aside(search, pair);
        }
        on_one
    }

    /// The next alternative of a detour; after the last one that from which it began.
    fn step_aside(&mut self, search: &mut Search<'_>, pair: PairId) {
        let (choice, detour) = (&mut self.choices[pair.index()], &mut self.detours[pair.index()]);
        if detour.steps + 1 < DETOURS && choice.step() {
            detour.steps += 1;
        } else {
            detour.steps = DETOURS;
            choice.take_back(detour.from);
        }
        if let Some(index) = choice.chosen().map(|chosen| chosen.index) {
            search.commit(LedgerEntry::Decided(Decision::Alternative { pair, index }));
        }
    }

    /// Tries both orderings of an obstruction, each as a branch that is taken back if nothing comes of it.
    pub(crate) fn order(&mut self, search: &mut Search<'_>, obstructed: &Obstructed) -> Result<Found, Stuck> {
        let mut conflict = Conflict::of(self.depends_on(obstructed), &[], None);
        for order in self.branches(obstructed) {
            let (kept, checkpoint) = (self.choices.clone(), self.skeleton.graph.checkpoint());
            if self.skeleton.graph.add(order.before, order.after, ArcOrigin::Discovered).is_err() {
                continue;
            }
            self.orders.push(order.clone());
            search.commit(LedgerEntry::Decided(Decision::Order(order.clone())));
            match self.settle(search) {
                Err(Stuck::Failed(failed)) => {
                    search.backtrack(StageKind::Roadmap, Decision::Order(order), failed.first_cause());
                    conflict.merge(failed);
                }
                ended => return ended,
            }
            self.orders.pop();
            self.skeleton.graph.undo(checkpoint);
            self.choices = kept;
        }
        Err(Stuck::Failed(conflict))
    }

    fn depends_on(&self, obstructed: &Obstructed) -> Vec<Choice> {
        let pairs = [obstructed.mode.begins.map(|event| event.pair), obstructed.mode.pair];
        let mut choices: Vec<Choice> = pairs.into_iter().flatten().map(Choice::Alternative).collect();
        choices.push(Choice::Pose(obstructed.occupancy));
        choices
    }

    /// The orderings that end the obstruction and contradict none: the pose comes after the mode, or is gone before.
    fn branches(&self, obstructed: &Obstructed) -> Vec<DiscoveredOrder> {
        let Obstructed { mode, occupancy } = obstructed;
        let Interval { from, to } = self.skeleton.interval_of(*occupancy);
        // A pose that is gone before the mode's event can be waited for.
        let is_gone = |to: Event| mode.ends.is_none_or(|ends| self.skeleton.graph.precedes_or_is(to, ends));
        let never = self.skeleton.graph.presence(Interval { from, to }, mode.interval()) == Presence::Never;
        if never || to.is_some_and(is_gone) {
            return Vec::new();
        }
        let comes_later = from.zip(leaves(mode)).map(|(comes, left)| (left, comes));
        let gone_before = to.zip(arrives(mode));
        [comes_later, gone_before]
            .into_iter()
            .flatten()
            .filter(|(before, after)| before != after && !self.skeleton.graph.precedes(*after, *before))
            .map(|(before, after)| DiscoveredOrder { before, after, cause: self.because(obstructed) })
            .collect()
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
