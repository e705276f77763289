//! What stands in the way of the alternatives at their two events.

use std::collections::BTreeSet;

use contract::{Answer, BlockersJob, Job, JobId, Request, StageKind};
use model::{Holding, PairId, Standing};
use plan::{BodyRef, Cause};
use skeleton::Occupancy;

use crate::around::Around;
use crate::asking::misfit;
use crate::candidate::Candidate;
use crate::conflict::Stuck;
use crate::search::Search;

/// Poses in the way of one alternative, with the jobs that told.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocked {
    /// At the grasp and at the release.
    pub(crate) by: [BTreeSet<Occupancy>; 2],
    pub(crate) told_by: [Option<JobId>; 2],
}

/// Alternatives of a pair of which it is asked at once what blocks them.
const AT_ONCE: usize = 4;

impl Candidate<'_> {
    /// Asks what blocks the chosen alternatives of some pairs, and the next ones. Whether anything was not known.
    pub(crate) fn ask_blockers(&mut self, search: &mut Search<'_>, pairs: &[PairId]) -> Result<bool, Stuck> {
        let mut jobs: Vec<Job> = Vec::new();
        let mut asked: Vec<(PairId, usize)> = Vec::new();
        for pair in pairs.iter().copied() {
            let (known, chosen) = (&self.blocked[pair.index()], self.chosen[pair.index()]);
            if known[chosen].is_some() {
                continue;
            }
            for number in (chosen..known.len()).filter(|number| known[*number].is_none()).take(AT_ONCE) {
                let ends = self.ends_to_ask(pair).into_iter();
                jobs.extend(ends.map(|(end, poses)| self.blockers_job(pair, number, end, &poses)));
                asked.push((pair, number));
            }
        }
        let mut answers = jobs.iter().zip(search.ask(&jobs)?);
        let is_news = !asked.is_empty();
        for (pair, number) in asked {
            let mut blocked = Blocked::default();
            for (end, poses) in self.ends_to_ask(pair) {
                let Some((job, outcome)) = answers.next() else { return Err(misfit(StageKind::Transition).into()) };
                let Ok(Answer::Blocked(which)) = outcome.result else {
                    return Err(misfit(StageKind::Transition).into());
                };
                let hits = poses.into_iter().zip(which).filter(|(_, blocks)| *blocks).map(|(pose, _)| pose);
                blocked.by[end] = hits.collect();
                blocked.told_by[end] = (!blocked.by[end].is_empty()).then(|| search.id(job));
            }
            self.blocked[pair.index()][number] = Some(blocked);
        }
        Ok(is_news)
    }

    /// The ends of a pair where something can be, and what.
    fn ends_to_ask(&self, pair: PairId) -> Vec<(usize, Vec<Occupancy>)> {
        let ends = self.at_events[pair.index()].iter().cloned().enumerate();
        ends.filter(|(_, poses)| !poses.is_empty()).collect()
    }

    /// Poses that can be there at the events of a pair at all: orderings that are only tried exclude none.
    pub(crate) fn note_events(&mut self, pair: PairId) {
        self.at_events[pair.index()] = self.around_events(pair).map(|around| everything(&around));
    }

    fn blockers_job(&self, pair: PairId, number: usize, end: usize, poses: &[Occupancy]) -> Job {
        let alternative = &self.offered[pair.index()][number];
        let reach = [&alternative.pick, &alternative.place][end];
        let standing: Vec<Standing> = poses.iter().map(|occupancy| self.standing(*occupancy)).collect();
        self.budgets.job(Request::Blockers(BlockersJob {
            robot: self.problem.pair(pair).robot,
            holding: Holding { object: self.problem.pair(pair).object, grasp: alternative.grasp },
            reach: reach.clone(),
            standing,
        }))
    }

    /// That a pose is in the way of a pair at one of its events.
    pub(crate) fn blocked_by(&self, pair: PairId, occupancy: Occupancy) -> Cause {
        let pair = self.problem.pair(pair);
        Cause::NoPath {
            pair: Some(pair.name.clone()),
            robot: self.problem.robot(pair.robot).name.clone(),
            blocking: vec![BodyRef::Object(self.problem.movable[occupancy.object.index()].name.clone())],
        }
    }
}

fn everything(around: &Around) -> Vec<Occupancy> {
    around.certain.union(&around.possible).copied().collect()
}
