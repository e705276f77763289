//! Which alternatives survive the objects that stand in their way.

use std::collections::BTreeSet;

use contract::{Alternative, Answer, BlockersJob, Job, Request, StageKind};
use model::{Holding, PairId, Standing};
use plan::{BodyRef, Cause};
use skeleton::{Event, Interval, Occupancy, Presence, Skeleton};

use crate::asking::misfit;
use crate::candidate::Candidate;
use crate::conflict::{Choice, Conflict, Stuck};
use crate::search::Search;

/// Poses that may be present at an instant, certain ones first.
struct Present {
    occupancies: Vec<Occupancy>,
    certain: usize,
}

/// Poses that block one alternative at its two events.
#[derive(Default)]
struct InTheWay {
    certain: BTreeSet<Occupancy>,
    possible: BTreeSet<Occupancy>,
}

impl Candidate<'_> {
    /// Drops alternatives that a certainly present pose blocks; those that only possible poses block come last.
    pub(crate) fn drop_blocked(&mut self, search: &mut Search<'_>, pairs: &[PairId]) -> Result<(), Stuck> {
        let mut jobs: Vec<Job> = Vec::new();
        for pair in pairs {
            jobs.extend(self.blocker_jobs(*pair));
        }
        let mut outcomes = search.ask(&jobs)?.into_iter();
        for pair in pairs.iter().copied() {
            let instants = self.instants(pair);
            let mut found = Vec::new();
            for alternative in self.choices[pair.index()].left().to_vec() {
                let mut in_the_way = InTheWay::default();
                for present in instants.iter().filter(|present| !present.occupancies.is_empty()) {
                    match outcomes.next().map(|outcome| outcome.result) {
                        Some(Ok(Answer::Blocked(which))) => in_the_way.add(present, &which),
                        _ => return Err(misfit(StageKind::Transition).into()),
                    }
                }
                found.push((alternative, in_the_way));
            }
            self.keep_free(pair, found).map_err(Stuck::Failed)?;
        }
        Ok(())
    }

    fn blocker_jobs(&self, pair: PairId) -> Vec<Job> {
        let instants = self.instants(pair);
        let mut jobs = Vec::new();
        for alternative in self.choices[pair.index()].left() {
            for (reach, present) in [&alternative.pick, &alternative.place].into_iter().zip(&instants) {
                if present.occupancies.is_empty() {
                    continue;
                }
                jobs.push(self.budgets.job(Request::Blockers(BlockersJob {
                    robot: self.problem.pair(pair).robot,
                    holding: Holding { object: self.problem.pair(pair).object, grasp: alternative.grasp },
                    reach: reach.clone(),
                    standing: self.standings(present),
                })));
            }
        }
        jobs
    }

    fn standings(&self, present: &Present) -> Vec<Standing> {
        present.occupancies.iter().map(|occupancy| self.standing(*occupancy)).collect()
    }

    /// What may stand where at the grasp and at the release of a pair, its own object apart.
    fn instants(&self, pair: PairId) -> [Present; 2] {
        [Event::grasp(pair), Event::release(pair)].map(|event| self.present_at(pair, event))
    }

    fn present_at(&self, pair: PairId, event: Event) -> Present {
        let own = self.problem.pair(pair).object;
        let instant = Interval { from: Some(event), to: Some(event) };
        let of_kind = |wanted: Presence| {
            self.skeleton.occupancies().filter(move |occupancy| {
                let interval = self.skeleton.interval_of(*occupancy);
                occupancy.object != own
                    && self.is_placed(*occupancy)
                    && self.skeleton.graph.presence(interval, instant) == wanted
            })
        };
        let mut occupancies: Vec<Occupancy> = of_kind(Presence::Certain).collect();
        let certain = occupancies.len();
        occupancies.extend(of_kind(Presence::Possible));
        Present { occupancies, certain }
    }

    fn keep_free(&mut self, pair: PairId, found: Vec<(Alternative, InTheWay)>) -> Result<(), Conflict> {
        let (mut kept, mut dropped) = (Vec::new(), Vec::new());
        for (alternative, in_the_way) in found {
            if in_the_way.certain.is_empty() {
                kept.push((in_the_way.possible.len(), alternative));
            } else {
                dropped.push(in_the_way.certain);
            }
        }
        kept.sort_by_key(|(possible, alternative)| (*possible, alternative.index));
        let list: Vec<Alternative> = kept.into_iter().map(|(_, alternative)| alternative).collect();
        let cover = cover(&dropped);
        let causes: Vec<(Cause, u64)> = cover.iter().map(|occupancy| (self.blocked_by(pair, *occupancy), 1)).collect();
        let conflict = Conflict::of(cover.iter().copied().map(Choice::Pose), &causes, None);
        let is_empty = list.is_empty();
        self.choices[pair.index()].keep(list, conflict.clone());
        if !is_empty {
            return Ok(());
        }
        self.used_up.insert(pair);
        let mut conflict = Conflict { under_any_orderings: self.are_always_there(pair, &cover), ..conflict };
        conflict.choices.extend(
            [self.skeleton.picked(self.problem, pair), self.skeleton.placed(self.problem, pair)].map(Choice::Pose),
        );
        Err(conflict)
    }

    /// Whether poses that are certain at an event of a pair are so without any discovered ordering.
    fn are_always_there(&self, pair: PairId, occupancies: &BTreeSet<Occupancy>) -> bool {
        let Ok(given) = Skeleton::of_problem(self.problem) else { return false };
        [Event::grasp(pair), Event::release(pair)].into_iter().all(|event| {
            let instant = Interval { from: Some(event), to: Some(event) };
            let is_certain = |skeleton: &Skeleton, occupancy: Occupancy| {
                skeleton.graph.presence(skeleton.interval_of(occupancy), instant) == Presence::Certain
            };
            occupancies.iter().all(|one| !is_certain(&self.skeleton, *one) || is_certain(&given, *one))
        })
    }

    fn blocked_by(&self, pair: PairId, occupancy: Occupancy) -> Cause {
        let pair = self.problem.pair(pair);
        Cause::NoPath {
            pair: Some(pair.name.clone()),
            robot: self.problem.robot(pair.robot).name.clone(),
            blocking: vec![BodyRef::Object(self.problem.movable[occupancy.object.index()].name.clone())],
        }
    }
}

impl InTheWay {
    fn add(&mut self, present: &Present, which: &[bool]) {
        for (k, occupancy) in present.occupancies.iter().enumerate() {
            if which.get(k).copied().unwrap_or(false) {
                let kind = if k < present.certain { &mut self.certain } else { &mut self.possible };
                kind.insert(*occupancy);
            }
        }
    }
}

/// A small set of poses of which every one of `sets` has at least one: greedy, so not always the least.
fn cover(sets: &[BTreeSet<Occupancy>]) -> BTreeSet<Occupancy> {
    let mut covering = BTreeSet::new();
    let mut open: Vec<&BTreeSet<Occupancy>> = sets.iter().collect();
    while !open.is_empty() {
        let all: BTreeSet<Occupancy> = open.iter().flat_map(|set| set.iter().copied()).collect();
        let hits = |occupancy: &Occupancy| open.iter().filter(|set| set.contains(occupancy)).count();
        let Some(best) = all.into_iter().max_by_key(|occupancy| (hits(occupancy), std::cmp::Reverse(*occupancy)))
        else {
            return covering;
        };
        open.retain(|set| !set.contains(&best));
        covering.insert(best);
    }
    covering
}

#[cfg(test)]
mod tests {
    use super::*;
    use model::ObjectId;

    fn set(objects: &[u32]) -> BTreeSet<Occupancy> {
        objects.iter().map(|object| Occupancy { object: ObjectId(*object), hop: 1 }).collect()
    }

    #[test]
    fn a_cover_meets_every_set_and_prefers_poses_that_meet_many() {
        assert_eq!(cover(&[set(&[1, 2]), set(&[2, 3]), set(&[2])]), set(&[2]));
        assert_eq!(cover(&[set(&[1]), set(&[2])]), set(&[1, 2]));
        assert_eq!(cover(&[]), set(&[]));
    }
}
