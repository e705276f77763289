//! Reaches of one end of a pair under one grasp.

use std::sync::Arc;

use contract::{
    Answer, CauseTally, GraspBlockersJob, Interrupted, JobContext, Outcome, RandomStream, Reach, StageKind,
};
use model::{GraspId, Holding, Pair, Pose, RegionId, Robot};
use plan::PairEnd;

use crate::TransitionStage;
use crate::reach::{ReachFinder, Unfit};
use crate::stand::StandSampler;

/// Values of the redundancy parameter tried at each stand.
const REDUNDANCY_SAMPLES: u32 = 8;
/// Stands drawn for each stand that may be kept: most of a ring lies in furniture.
const DRAWS_PER_STAND: u64 = 8;
/// Names of the ends in the keys of random values.
pub(crate) const PICK: &str = "pick";
pub(crate) const PLACE: &str = "place";

/// One end of a pair under poses that a job gives.
pub(crate) struct End<'a> {
    pub(crate) pair: &'a Pair,
    pub(crate) region: RegionId,
    pub(crate) world_from_object: Pose,
    pub(crate) name: &'static str,
}

/// Reaches of one end under one grasp, quickest arm motion first.
#[derive(Default)]
pub(crate) struct Reached {
    pub(crate) reaches: Vec<Reach>,
    pub(crate) causes: CauseTally,
    work: u64,
}

impl TransitionStage {
    /// Reaches of one end under one grasp. What is remembered costs the same work, for work is part of the answer.
    pub(crate) fn reaches(
        &self,
        end: &End<'_>,
        grasp: GraspId,
        level: u32,
        context: &mut JobContext<'_>,
    ) -> Result<Arc<Reached>, Interrupted> {
        let key = contract::encode_canonical(&(&end.pair.name, end.name, grasp, end.world_from_object, level));
        let known = self.reached.lock().ok().and_then(|memo| memo.get(&key).cloned());
        if let Some(known) = known.filter(|known| known.work < context.left()) {
            context.spend(known.work)?;
            return Ok(known);
        }
        let reached = Arc::new(self.find_reaches(end, grasp, level, context)?);
        // What the budget may have cut short is not all there is.
        if context.left() > 0 {
            crate::remember(&self.reached, key, &reached);
        }
        Ok(reached)
    }

    fn find_reaches(
        &self,
        end: &End<'_>,
        grasp: GraspId,
        level: u32,
        context: &mut JobContext<'_>,
    ) -> Result<Reached, Interrupted> {
        let (mut reaches, mut causes, before) = (Vec::new(), CauseTally::default(), context.spent());
        let problem = self.geometry.problem();
        let robot = problem.robot(end.pair.robot);
        let finder = self.finder(end, grasp);
        context.spend(1)?;
        if let Some(contact) = finder.hand_contact() {
            causes.count(contact.cause(problem));
            return Ok(Reached { reaches, causes, work: 1 });
        }
        // A fixed base has one stand: variety then comes from the arm's redundancy.
        let most = if robot.base.is_some() { 1 } else { problem.levels.stands as usize };
        for stand in self.stands(&finder, end, level) {
            reaches.extend(reaches_from(&finder, &stand, (level, most), context, &mut causes)?);
        }
        reaches.sort_by(|a, b| arm_time(robot, a).total_cmp(&arm_time(robot, b)));
        Ok(Reached { reaches, causes, work: context.spent() - before })
    }

    fn finder(&self, end: &End<'_>, grasp: GraspId) -> ReachFinder<'_> {
        let (problem, robot) = (self.geometry.problem(), end.pair.robot);
        ReachFinder {
            geometry: &self.geometry,
            solver: self.solver(robot),
            robot,
            holding: Holding { object: end.pair.object, grasp },
            grasp: problem.movable[end.pair.object.index()].grasp(robot, grasp),
            world_from_object: end.world_from_object,
            support: problem.regions[end.region.index()].support,
        }
    }

    /// For each standing object, whether it is in the hand's way under every grasp that fixed objects leave.
    pub(crate) fn grasp_blockers(
        &self,
        job: &GraspBlockersJob,
        context: &mut JobContext<'_>,
    ) -> Result<Outcome, Interrupted> {
        let problem = self.geometry.problem();
        let pair = problem.pairs.get(job.pair.index());
        let pair = pair.ok_or_else(|| Interrupted::Unfit(format!("no pair {}", job.pair.0)))?;
        let (region, name) = match job.end {
            PairEnd::Pick => (pair.from, PICK),
            PairEnd::Place => (pair.to, PLACE),
        };
        let end = End { pair, region, world_from_object: job.world_from_object, name };
        let mut blocked = vec![true; job.standing.len()];
        for grasp in self.grasps(pair, job.level) {
            let finder = self.finder(&end, grasp);
            context.spend(1 + job.standing.len() as u64)?;
            if finder.hand_contact().is_none() {
                for (standing, blocked) in job.standing.iter().zip(&mut blocked) {
                    *blocked = *blocked && finder.hand_hits(standing);
                }
            }
        }
        Ok(Outcome::answer(Answer::Blocked(blocked), context.spent()))
    }

    /// The grasps of a pair's object that count at a level.
    pub(crate) fn grasps(&self, pair: &Pair, level: u32) -> impl Iterator<Item = GraspId> + use<> {
        let problem = self.geometry.problem();
        let all = problem.movable[pair.object.index()].grasps[pair.robot.index()].len();
        let wanted = (problem.levels.grasps as usize) << level.min(16);
        (0..all.min(wanted)).map(GraspId::at)
    }

    /// Stands at which the robot fits folded; a fixed base has one.
    fn stands(&self, finder: &ReachFinder<'_>, end: &End<'_>, level: u32) -> Vec<Vec<f64>> {
        let problem = self.geometry.problem();
        let robot = problem.robot(finder.robot);
        if robot.base.is_none() {
            return vec![Vec::new()];
        }
        let object = &problem.movable[end.pair.object.index()].name;
        let grasp = finder.holding.grasp.0.to_string();
        let names = [robot.name.as_str(), object, &end.pair.name, end.name, &grasp];
        let random = RandomStream::new(self.seed, StageKind::Transition, &names, "stand");
        let reach = finder.solver.reach(robot);
        let Some(sampler) =
            StandSampler::new(robot, &reach, &finder.world_from_link(), problem.settings.facing, &random)
        else {
            return Vec::new();
        };
        let wanted = u64::from(problem.levels.stands) << level.min(16);
        (0..wanted * DRAWS_PER_STAND)
            .filter_map(|index| sampler.stand(index))
            .filter(|stand| finder.folded_contact(stand).is_none())
            .take(wanted as usize)
            .collect()
    }
}

/// Quickest arm configuration of each redundancy value that serves at a stand, `most` values at the most.
fn reaches_from(
    finder: &ReachFinder<'_>,
    stand: &[f64],
    (level, most): (u32, usize),
    context: &mut JobContext<'_>,
    causes: &mut CauseTally,
) -> Result<Vec<Reach>, Interrupted> {
    let problem = finder.geometry.problem();
    let robot = problem.robot(finder.robot);
    let world_from_link = finder.world_from_link();
    let mut reaches = Vec::new();
    for i in 0..REDUNDANCY_SAMPLES << level.min(8) {
        if reaches.len() == most || !context.spend(1)? {
            break;
        }
        // Each level refines the turns of the one before.
        let redundancy = contract::halton(u64::from(i), 2);
        let mut best: Option<Reach> = None;
        for arm in finder.solver.solve(robot, stand, &world_from_link, redundancy) {
            match finder.complete(stand, arm) {
                Ok(reach) if best.as_ref().is_none_or(|b| arm_time(robot, &reach) < arm_time(robot, b)) => {
                    best = Some(reach);
                }
                Ok(_) | Err(Unfit::NotStraight) => {}
                Err(Unfit::Contact(contact)) => causes.count(contact.cause(problem)),
            }
        }
        reaches.extend(best);
    }
    Ok(reaches)
}

/// Least time of the arm from its folded configuration to the far end of the straight way (s).
pub(crate) fn arm_time(robot: &Robot, reach: &Reach) -> f64 {
    let folded = [reach.stand.as_slice(), &robot.carry].concat();
    let far = reach.lift.last().unwrap_or(&reach.at_object);
    robot.duration(&folded, &robot.short_way(&folded, far))
}
