//! Which alternatives survive the objects that stand in their way.

use contract::{Alternative, Answer, BlockersJob, Request, StageKind};
use model::{Holding, PairId, Standing};
use plan::{BodyRef, Cause};
use skeleton::{Event, Interval, Occupancy, Presence};

use crate::candidate::Candidate;
use crate::search::{Search, Stuck, misfit};

/// Poses that may be present at an instant, certain ones first.
struct Present {
    occupancies: Vec<Occupancy>,
    certain: usize,
}

impl Candidate<'_> {
    /// Drops alternatives that a certainly present pose blocks; those that only possible poses block come last.
    pub(crate) fn drop_blocked(&mut self, search: &mut Search<'_>, pair: PairId) -> Result<(), Stuck> {
        let instants = [Event::grasp(pair), Event::release(pair)].map(|event| self.present_at(pair, event));
        if instants.iter().all(|present| present.occupancies.is_empty()) {
            return Ok(());
        }
        let mut jobs = Vec::new();
        for alternative in &self.alternatives[pair.index()] {
            for (reach, present) in [&alternative.pick, &alternative.place].into_iter().zip(&instants) {
                jobs.push(self.budgets.job(Request::Blockers(BlockersJob {
                    robot: self.problem.pair(pair).robot,
                    holding: Holding { object: self.problem.pair(pair).object, grasp: alternative.grasp },
                    reach: reach.clone(),
                    standing: self.standings(present),
                })));
            }
        }
        let mut blocked = Vec::new();
        for outcome in search.ask(&jobs)? {
            match outcome.result {
                Ok(Answer::Blocked(which)) => blocked.push(which),
                _ => return Err(misfit(StageKind::Transition).into()),
            }
        }
        let causes = self.keep_free(pair, &instants, &blocked);
        if self.alternatives[pair.index()].is_empty() { Err(Stuck::Failed(causes)) } else { Ok(()) }
    }

    fn standings(&self, present: &Present) -> Vec<Standing> {
        present.occupancies.iter().map(|occupancy| self.standing(*occupancy)).collect()
    }

    /// Poses of other objects at the instant of an event.
    fn present_at(&self, pair: PairId, event: Event) -> Present {
        let own = self.problem.pair(pair).object;
        let instant = Interval { from: Some(event), to: Some(event) };
        let of_kind = |wanted: Presence| {
            self.skeleton.occupancies().filter(move |occupancy| {
                let interval = self.skeleton.interval_of(*occupancy);
                occupancy.object != own && self.skeleton.graph.presence(interval, instant) == wanted
            })
        };
        let mut occupancies: Vec<Occupancy> = of_kind(Presence::Certain).collect();
        let certain = occupancies.len();
        occupancies.extend(of_kind(Presence::Possible));
        Present { occupancies, certain }
    }

    fn keep_free(&mut self, pair: PairId, instants: &[Present; 2], blocked: &[Vec<bool>]) -> Vec<(Cause, u64)> {
        let mut kept: Vec<(usize, Alternative)> = Vec::new();
        let mut causes = contract::CauseTally::default();
        for (i, alternative) in self.alternatives[pair.index()].iter().enumerate() {
            let (mut certain, mut possible) = (0, 0);
            for (present, which) in instants.iter().zip(&blocked[2 * i..2 * i + 2]) {
                for (k, occupancy) in present.occupancies.iter().enumerate().filter(|(k, _)| which[*k]) {
                    let counter = if k < present.certain { &mut certain } else { &mut possible };
                    *counter += 1;
                    causes.count(self.blocked_by(pair, *occupancy));
                }
            }
            if certain == 0 {
                kept.push((possible, alternative.clone()));
            }
        }
        kept.sort_by_key(|(possible, alternative)| (*possible, alternative.index));
        self.alternatives[pair.index()] = kept.into_iter().map(|(_, alternative)| alternative).collect();
        causes.ranked()
    }

    fn blocked_by(&self, pair: PairId, occupancy: Occupancy) -> Cause {
        let pair = self.problem.pair(pair);
        Cause::NoPath {
            pair: Some(pair.name.clone()),
            robot: self.problem.robot(pair.robot).name.clone(),
            blocking: vec![BodyRef::Object(self.object_name(occupancy.object))],
        }
    }
}
