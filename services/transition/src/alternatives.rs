//! All alternatives of a pair at one level, in canonical order.

use contract::{Alternative, CauseTally, Interrupted, JobContext, RandomStream, Reach, StageKind, TransitionJob};
use model::{GraspId, Holding, Pair, Pose, RegionId, Robot, RobotId};
use plan::Cause;

use crate::reach::{ReachFinder, Unfit};
use crate::stand::StandSampler;
use crate::{Found, TransitionStage};

/// Values of the redundancy parameter tried at each stand.
const REDUNDANCY_SAMPLES: u32 = 8;
/// Stands drawn for each stand that may be kept: most of a ring lies in furniture.
const DRAWS_PER_STAND: u64 = 8;
/// Combinations of reaches kept of one grasp.
const COMBINATIONS: usize = 64;

struct End<'a> {
    pair: &'a Pair,
    region: RegionId,
    world_from_object: Pose,
    name: &'static str,
}

impl TransitionStage {
    /// Every alternative of the level: grasps in turn, each with its quickest combinations of reaches first.
    pub(crate) fn find(&self, job: &TransitionJob, context: &mut JobContext<'_>) -> Result<Found, Interrupted> {
        let problem = self.geometry.problem();
        let pair = problem.pair(job.pair);
        let before = context.spent();
        let mut causes = CauseTally::default();
        let pick = End { pair, region: pair.from, world_from_object: job.world_from_pick, name: "pick" };
        let place = End { pair, region: pair.to, world_from_object: job.world_from_place, name: "place" };
        let grasps = problem.movable[pair.object.index()].grasps[pair.robot.index()].len();
        let wanted = (problem.levels.grasps as usize) << job.level.min(16);
        let (mut by_grasp, mut either) = (Vec::new(), [false; 2]);
        for grasp in (0..grasps.min(wanted)).map(GraspId::at) {
            let picks = self.reaches(&pick, grasp, job.level, context, &mut causes)?;
            let places = if picks.is_empty() {
                Vec::new()
            } else {
                self.reaches(&place, grasp, job.level, context, &mut causes)?
            };
            either = [either[0] || !picks.is_empty(), either[1] || !places.is_empty()];
            by_grasp.push(combinations(problem.robot(pair.robot), grasp, &picks, &places));
        }
        let alternatives = in_turn(by_grasp);
        if alternatives.is_empty() {
            causes.count(summary(problem, pair, either));
        }
        Ok(Found { alternatives, causes, work: context.spent() - before })
    }

    /// Reaches of one end under one grasp, quickest arm motion first.
    fn reaches(
        &self,
        end: &End<'_>,
        grasp: GraspId,
        level: u32,
        context: &mut JobContext<'_>,
        causes: &mut CauseTally,
    ) -> Result<Vec<Reach>, Interrupted> {
        let problem = self.geometry.problem();
        let robot_id = end.pair.robot;
        let robot = problem.robot(robot_id);
        let finder = ReachFinder {
            geometry: &self.geometry,
            solver: self.solver(robot_id),
            robot: robot_id,
            holding: Holding { object: end.pair.object, grasp },
            grasp: problem.movable[end.pair.object.index()].grasp(robot_id, grasp),
            world_from_object: end.world_from_object,
            support: problem.regions[end.region.index()].support,
        };
        // A fixed base has one stand: variety then comes from the arm's redundancy.
        let most = if robot.base.is_some() { 1 } else { problem.levels.stands as usize };
        let mut reaches = Vec::new();
        for stand in self.stands(&finder, end, level) {
            reaches.extend(reaches_from(&finder, &stand, (level, most), context, causes)?);
        }
        reaches.sort_by(|a, b| arm_time(robot, a).total_cmp(&arm_time(robot, b)));
        Ok(reaches)
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
fn combinations(robot: &Robot, grasp: GraspId, picks: &[Reach], places: &[Reach]) -> Vec<Alternative> {
    let mut all: Vec<(f64, usize, usize)> = Vec::new();
    for (i, pick) in picks.iter().enumerate() {
        for (j, place) in places.iter().enumerate() {
            let drive = drive_time(robot, &pick.stand, &place.stand);
            all.push((arm_time(robot, pick) + arm_time(robot, place) + drive, i, j));
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    all.truncate(COMBINATIONS);
    all.into_iter()
        .map(|(_, i, j)| Alternative { index: 0, grasp, pick: picks[i].clone(), place: places[j].clone() })
        .collect()
}

fn drive_time(robot: &Robot, from: &[f64], to: &[f64]) -> f64 {
    let [from, to] = [from, to].map(|stand| [stand, &robot.home].concat());
    robot.duration(&from, &robot.short_way(&from, &to))
}

/// Round by round: the best of every grasp, then the second best of every grasp, and so on.
fn in_turn(mut by_grasp: Vec<Vec<Alternative>>) -> Vec<Alternative> {
    by_grasp.iter_mut().for_each(|list| list.reverse());
    let mut alternatives = Vec::new();
    while by_grasp.iter().any(|list| !list.is_empty()) {
        for mut alternative in by_grasp.iter_mut().filter_map(Vec::pop) {
            alternative.index = u32::try_from(alternatives.len()).unwrap_or(u32::MAX);
            alternatives.push(alternative);
        }
    }
    alternatives
}

/// The failure in one sentence: which end is out of reach, or that no grasp serves both.
fn summary(problem: &model::Problem, pair: &Pair, either: [bool; 2]) -> Cause {
    let unreachable = |region: RegionId, robot: RobotId| Cause::Unreachable {
        robot: problem.robot(robot).name.clone(),
        pair: pair.name.clone(),
        object: problem.movable[pair.object.index()].name.clone(),
        region: problem.regions[region.index()].name.clone(),
    };
    match either {
        [false, _] => unreachable(pair.from, pair.robot),
        [true, false] => unreachable(pair.to, pair.robot),
        [true, true] => Cause::NoCommonGrasp { pair: pair.name.clone() },
    }
}
