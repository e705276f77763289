//! Why there is no way through a run of a robot's pairs: as few poses and orderings as can be.

use model::PairId;
use skeleton::{Event, Mode};

use crate::around::instant;
use crate::candidate::Candidate;
use crate::conflict::{Choice, Conflict};
use crate::known::NoWay;
use crate::reaches::Blocked;
use crate::ways::Scene;

/// The reasons for which an alternative, or a step between two, cannot be; one is enough.
type Reasons = Vec<Conflict>;

impl Candidate<'_> {
    /// What it rests on that there is no way through some consecutive pairs of a robot.
    pub(crate) fn dead_end(&mut self, scene: &Scene, run: &[PairId]) -> Conflict {
        self.used_up.extend(run);
        let closed = self.closed(scene, run);
        let mut conflict = least(&closed);
        conflict.choices.extend(run.iter().flat_map(|pair| self.ends(*pair)));
        conflict
    }

    /// Every alternative and step of the run that cannot be, with the reasons. What is no dead end by itself is none of
    /// the others' matter: steps from and to closed alternatives are left out.
    fn closed(&self, scene: &Scene, run: &[PairId]) -> Vec<Reasons> {
        let mut closed = Vec::new();
        let mut open: Vec<Vec<usize>> = Vec::new();
        for pair in run {
            let reasons: Vec<Reasons> =
                (0..self.offered[pair.index()].len()).map(|i| self.against(scene, *pair, i)).collect();
            open.push((0..reasons.len()).filter(|i| reasons[*i].is_empty()).collect());
            closed.extend(reasons.into_iter().filter(|reasons| !reasons.is_empty()));
        }
        for (pairs, open) in run.windows(2).zip(open.windows(2)) {
            let Some(mode) = self.transit_of(pairs[1]) else { continue };
            let around = scene.about(&mode);
            let no_ways: Vec<&NoWay> = self.no_ways_now(&mode, around).collect();
            for i in &open[0] {
                for j in &open[1] {
                    let between = |no_way: &&&NoWay| no_way.ends == [Some(*i), Some(*j)];
                    let reasons: Reasons =
                        no_ways.iter().filter(between).map(|no_way| self.why(&mode, no_way)).collect();
                    if !reasons.is_empty() {
                        closed.push(reasons);
                    }
                }
            }
        }
        closed
    }

    /// The reasons against one alternative, whatever its neighbours.
    fn against(&self, scene: &Scene, pair: PairId, number: usize) -> Reasons {
        let mut reasons = Reasons::new();
        let nothing = Blocked::default();
        let blocked = self.blocked[pair.index()][number].as_ref().unwrap_or(&nothing);
        for (end, event) in [Event::grasp(pair), Event::release(pair)].into_iter().enumerate() {
            for pose in blocked.by[end].intersection(&scene.events[pair.index()][end].certain) {
                let mut why =
                    Conflict::of([Choice::Pose(*pose)], &[(self.blocked_by(pair, *pose), 1)], blocked.told_by[end]);
                why.orders = self.orders_keeping(*pose, instant(event));
                reasons.push(why);
            }
        }
        for mode in self.skeleton.modes[self.problem.pair(pair).robot.index()].iter() {
            let ends = self.pairs_at_ends(mode);
            if !ends.contains(&Some(pair)) {
                continue;
            }
            // A mode without any way is the matter of the pair that it leads to.
            let is_own = |no_way: &&NoWay| match no_way.ends {
                [None, None] => ends[1].or(ends[0]) == Some(pair),
                closed => (0..2).all(|end| closed[end].is_none_or(|other| ends[end] == Some(pair) && other == number)),
            };
            let no_ways = self.no_ways_now(mode, scene.about(mode)).filter(is_own);
            reasons.extend(no_ways.map(|no_way| self.why(mode, no_way)));
        }
        reasons
    }

    /// What it rests on that a mode has no way, the alternatives at its ends apart.
    fn why(&self, mode: &Mode, no_way: &NoWay) -> Conflict {
        let mut why = Conflict::default();
        no_way.certain.iter().for_each(|pose| why.merge(self.why_certain(mode, *pose)));
        why.choices.extend(&no_way.choices);
        why.orders.extend(&no_way.orders);
        why.causes.count_all(&no_way.causes.clone().ranked());
        why.proof = no_way.proof.or(why.proof);
        why
    }

    fn transit_of(&self, pair: PairId) -> Option<Mode> {
        let modes = &self.skeleton.modes[self.problem.pair(pair).robot.index()];
        modes.iter().find(|mode| mode.pair == Some(pair) && !mode.is_holding()).copied()
    }
}

/// The least that leaves everything closed: no part of it can be spared. Orderings are spared first.
fn least(closed: &[Reasons]) -> Conflict {
    let mut needed = Conflict::default();
    for reason in closed.iter().flatten() {
        needed.choices.extend(&reason.choices);
        needed.orders.extend(&reason.orders);
    }
    for order in needed.orders.clone() {
        needed.orders.remove(&order);
        if !suffices(&needed, closed) {
            needed.orders.insert(order);
        }
    }
    for choice in needed.choices.clone().into_iter().rev() {
        needed.choices.remove(&choice);
        if !suffices(&needed, closed) {
            needed.choices.insert(choice);
        }
    }
    for reasons in closed {
        if let Some(reason) = reasons.iter().find(|reason| is_part(reason, &needed)) {
            needed.causes.count_all(&reason.causes.clone().ranked());
            needed.proof = reason.proof.or(needed.proof);
        }
    }
    needed
}

/// Whether everything is closed for reasons among these.
fn suffices(needed: &Conflict, closed: &[Reasons]) -> bool {
    closed.iter().all(|reasons| reasons.iter().any(|reason| is_part(reason, needed)))
}

fn is_part(reason: &Conflict, of: &Conflict) -> bool {
    reason.choices.is_subset(&of.choices) && reason.orders.is_subset(&of.orders)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use model::{ObjectId, Point};
    use skeleton::Occupancy;

    fn poses(objects: &[u32]) -> BTreeSet<Choice> {
        objects.iter().map(|object| Choice::Pose(Occupancy { object: ObjectId(*object), hop: 1 })).collect()
    }

    fn reason(objects: &[u32], orders: &[u32]) -> Conflict {
        let order = |pair: &u32| (Event::new(PairId(*pair), Point::Grasp), Event::new(PairId(*pair), Point::Release));
        Conflict { choices: poses(objects), orders: orders.iter().map(order).collect(), ..Conflict::default() }
    }

    #[test]
    fn the_least_that_closes_everything_has_a_reason_for_each_and_nothing_to_spare() {
        // Both are closed by pose 1; pose 2 and an ordering are further reasons.
        let closed = [vec![reason(&[1], &[]), reason(&[2], &[])], vec![reason(&[1], &[]), reason(&[2], &[0])]];
        let found = least(&closed);
        assert_eq!((found.choices, found.orders.len()), (poses(&[1]), 0));
        // An ordering is spared where two poses do without.
        let found = least(&[vec![reason(&[1], &[0]), reason(&[2, 3], &[])]]);
        assert_eq!((found.choices, found.orders.len()), (poses(&[2, 3]), 0));
        // One of them can be closed only with it.
        let found = least(&[vec![reason(&[1], &[0])], vec![reason(&[2], &[]), reason(&[1], &[0])]]);
        assert_eq!((found.choices, found.orders.len()), (poses(&[1]), 1));
        assert_eq!(least(&[]).choices, poses(&[]));
    }

    #[test]
    fn nothing_of_the_least_can_be_spared_in_random_cases() {
        let mut state = 3_u64;
        let mut next = move |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % n) as u32
        };
        for case in 0..500 {
            let mut reasons = || {
                let mut some = || (0..next(3)).map(|_| next(6)).collect::<Vec<u32>>();
                reason(&some(), &some())
            };
            let closed: Vec<Reasons> = (0..4).map(|_| (0..3).map(|_| reasons()).collect()).collect();
            let found = least(&closed);
            assert!(suffices(&found, &closed), "case {case}");
            for order in &found.orders {
                let mut fewer = found.clone();
                fewer.orders.remove(order);
                assert!(!suffices(&fewer, &closed), "case {case}");
            }
            for choice in &found.choices {
                let mut fewer = found.clone();
                fewer.choices.remove(choice);
                assert!(!suffices(&fewer, &closed), "case {case}");
            }
        }
    }
}
