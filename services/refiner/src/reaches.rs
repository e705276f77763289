//! What stands in the way of the alternatives at their two events.

use std::collections::BTreeSet;

use contract::{Alternative, Answer, BlockersJob, Job, JobId, Request, StageKind};
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

impl Candidate<'_> {
    /// Asks what blocks the alternatives of pairs of which it is not known yet: of all poses that can be there at all.
    pub(crate) fn ask_blockers(&mut self, search: &mut Search<'_>, pairs: &[PairId]) -> Result<(), Stuck> {
        let mut jobs: Vec<Job> = Vec::new();
        let mut asked: Vec<(PairId, usize, usize, Vec<Occupancy>)> = Vec::new();
        for pair in pairs.iter().copied() {
            let at_events = self.around_events(pair).map(|around| everything(&around));
            let known = self.blocked[pair.index()].len();
            for (number, alternative) in self.offered[pair.index()].iter().enumerate().skip(known) {
                for (end, poses) in at_events.iter().enumerate().filter(|(_, poses)| !poses.is_empty()) {
                    jobs.push(self.blockers_job(pair, alternative, end, poses));
                    asked.push((pair, number, end, poses.clone()));
                }
            }
        }
        let outcomes = search.ask(&jobs)?;
        for pair in pairs {
            let offered = self.offered[pair.index()].len();
            self.blocked[pair.index()].resize(offered, Blocked::default());
        }
        for (((pair, number, end, poses), job), outcome) in asked.into_iter().zip(&jobs).zip(outcomes) {
            let Ok(Answer::Blocked(which)) = outcome.result else { return Err(misfit(StageKind::Transition).into()) };
            let blocked = &mut self.blocked[pair.index()][number];
            let hits = poses.into_iter().zip(which).filter(|(_, blocks)| *blocks).map(|(pose, _)| pose);
            blocked.by[end] = hits.collect();
            blocked.told_by[end] = (!blocked.by[end].is_empty()).then(|| search.id(job));
        }
        Ok(())
    }

    fn blockers_job(&self, pair: PairId, alternative: &Alternative, end: usize, poses: &[Occupancy]) -> Job {
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
