//! All alternatives of a pair at one level, in canonical order.

use std::sync::Arc;

use contract::{
    Alternative, Answer, CauseTally, Choice, GraspBlockersJob, Interrupted, JobContext, Outcome, RandomStream, Reach,
    StageKind, TransitionJob,
};
use model::{GraspId, Holding, Pair, Pose, RegionId, Robot, RobotId};
use plan::{Cause, PairEnd};
use skeleton::Occupancy;

use crate::TransitionStage;
use crate::reach::{ReachFinder, Unfit};
use crate::stand::StandSampler;

/// Values of the redundancy parameter tried at each stand.
const REDUNDANCY_SAMPLES: u32 = 8;
/// Stands drawn for each stand that may be kept: most of a ring lies in furniture.
const DRAWS_PER_STAND: u64 = 8;
/// Combinations of reaches kept of one grasp.
const COMBINATIONS: usize = 64;

/// Names of the ends in the keys of random values.
const PICK: &str = "pick";
const PLACE: &str = "place";

/// One end of a pair under poses that a job gives.
struct End<'a> {
    pair: &'a Pair,
    region: RegionId,
    world_from_object: Pose,
    name: &'static str,
}

/// Reaches of one end under one grasp, quickest arm motion first.
#[derive(Default)]
pub(crate) struct Reached {
    reaches: Vec<Reach>,
    causes: CauseTally,
    work: u64,
}

/// All alternatives of one pair at one level, or why there are none.
pub(crate) struct Found {
    /// Reaches of the two ends by grasp.
    ends: [Vec<Arc<Reached>>; 2],
    /// The grasp of each alternative and its reaches at the two ends, in canonical order.
    pub(crate) combinations: Vec<(GraspId, [usize; 2])>,
    pub(crate) causes: CauseTally,
    /// The poses that it rests on that there are none; not known where the budget ran out.
    pub(crate) rests_on: Option<Vec<Choice>>,
    pub(crate) work: u64,
}

impl Found {
    /// Alternatives from number `first` on.
    pub(crate) fn alternatives(&self, first: u32, count: u32) -> Vec<Alternative> {
        let wanted = (0_u32..).zip(&self.combinations).skip(first as usize).take(count as usize);
        let reach = |end: usize, grasp: GraspId, i: usize| self.ends[end][grasp.index()].reaches[i].clone();
        wanted
            .map(|(index, (grasp, [i, j]))| Alternative {
                index,
                grasp: *grasp,
                pick: reach(0, *grasp, *i),
                place: reach(1, *grasp, *j),
            })
            .collect()
    }
}

impl TransitionStage {
    /// Every alternative of the level: grasps in turn, each with its quickest combinations of reaches first.
    pub(crate) fn find(&self, job: &TransitionJob, context: &mut JobContext<'_>) -> Result<Found, Interrupted> {
        let problem = self.geometry.problem();
        let pair = problem.pair(job.pair);
        let before = context.spent();
        let pick = End { pair, region: pair.from, world_from_object: job.world_from_pick, name: PICK };
        let place = End { pair, region: pair.to, world_from_object: job.world_from_place, name: PLACE };
        let grasps = || self.grasps(pair, job.level);
        let nothing = Arc::new(Reached::default());
        let picks: Vec<Arc<Reached>> =
            grasps().map(|grasp| self.reaches(&pick, grasp, job.level, context)).collect::<Result<_, _>>()?;
        let mut places = vec![nothing; picks.len()];
        let is_grasped = |grasp: &GraspId| !picks[grasp.index()].reaches.is_empty();
        for grasp in grasps().filter(is_grasped) {
            places[grasp.index()] = self.reaches(&place, grasp, job.level, context)?;
        }
        let robot = problem.robot(pair.robot);
        let by_grasp = grasps()
            .map(|grasp| combinations(robot, grasp, &picks[grasp.index()].reaches, &places[grasp.index()].reaches));
        let combinations = in_turn(by_grasp.collect());
        let is_picked = picks.iter().any(|reached| !reached.reaches.is_empty());
        if combinations.is_empty() && is_picked {
            // Whether the place is out of reach whatever the grasp.
            for grasp in grasps().filter(|grasp| !is_grasped(grasp)) {
                places[grasp.index()] = self.reaches(&place, grasp, job.level, context)?;
            }
        }
        let ends = [picks, places];
        let (mut causes, mut rests_on) = (CauseTally::default(), None);
        if combinations.is_empty() {
            ends.iter().flatten().for_each(|reached| causes.count_all(&reached.causes.clone().ranked()));
            let serves = [0, 1].map(|end: usize| ends[end].iter().any(|reached| !reached.reaches.is_empty()));
            causes.count(summary(problem, pair, serves));
            rests_on = (context.left() > 0).then(|| poses_at_fault(pair, serves));
        }
        Ok(Found { ends, combinations, causes, rests_on, work: context.spent() - before })
    }

    /// Reaches of one end under one grasp. What is remembered costs the same work, for work is part of the answer.
    fn reaches(
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
    fn grasps(&self, pair: &Pair, level: u32) -> impl Iterator<Item = GraspId> + use<> {
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
fn arm_time(robot: &Robot, reach: &Reach) -> f64 {
    let folded = [reach.stand.as_slice(), &robot.carry].concat();
    let far = reach.lift.last().unwrap_or(&reach.at_object);
    robot.duration(&folded, &robot.short_way(&folded, far))
}

/// Combinations of one grasp, least sum of arm times and straight drive first.
fn combinations(robot: &Robot, grasp: GraspId, picks: &[Reach], places: &[Reach]) -> Vec<(GraspId, [usize; 2])> {
    let mut all: Vec<(f64, [usize; 2])> = Vec::new();
    let [at_pick, at_place] =
        [picks, places].map(|reaches| reaches.iter().map(|reach| arm_time(robot, reach)).collect::<Vec<f64>>());
    for (i, pick) in picks.iter().enumerate() {
        for (j, place) in places.iter().enumerate() {
            let drive = drive_time(robot, &pick.stand, &place.stand);
            all.push((at_pick[i] + at_place[j] + drive, [i, j]));
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    all.into_iter().take(COMBINATIONS).map(|(_, reaches)| (grasp, reaches)).collect()
}

fn drive_time(robot: &Robot, from: &[f64], to: &[f64]) -> f64 {
    let [from, to] = [from, to].map(|stand| [stand, &robot.home].concat());
    robot.duration(&from, &robot.short_way(&from, &to))
}

/// Round by round: the best of every grasp, then the second best of every grasp, and so on.
fn in_turn<T>(mut by_grasp: Vec<Vec<T>>) -> Vec<T> {
    by_grasp.iter_mut().for_each(|list| list.reverse());
    let mut in_turn = Vec::new();
    while by_grasp.iter().any(|list| !list.is_empty()) {
        in_turn.extend(by_grasp.iter_mut().filter_map(Vec::pop));
    }
    in_turn
}

/// The failure in one sentence: which end is out of reach, or that no grasp serves both.
fn summary(problem: &model::Problem, pair: &Pair, serves: [bool; 2]) -> Cause {
    let unreachable = |region: RegionId, robot: RobotId| Cause::Unreachable {
        robot: problem.robot(robot).name.clone(),
        pair: pair.name.clone(),
        object: problem.movable[pair.object.index()].name.clone(),
        region: problem.regions[region.index()].name.clone(),
    };
    match serves {
        [false, _] => unreachable(pair.from, pair.robot),
        [true, false] => unreachable(pair.to, pair.robot),
        [true, true] => Cause::NoCommonGrasp { pair: pair.name.clone() },
    }
}

/// The poses of which one must change: one end if only that is out of reach, else both, for a grasp serves both.
fn poses_at_fault(pair: &Pair, serves: [bool; 2]) -> Vec<Choice> {
    let [from, to] = [pair.hop - 1, pair.hop].map(|hop| Choice::Pose(Occupancy { object: pair.object, hop }));
    match serves {
        [false, _] => vec![from],
        [true, false] => vec![to],
        [true, true] => vec![from, to],
    }
}
