//! All alternatives of a pair at one level, in canonical order.

use std::sync::Arc;

use contract::{Alternative, CauseTally, Choice, Interrupted, JobContext, Reach, TransitionJob};
use model::{GraspId, Pair, RegionId, Robot, RobotId};
use plan::Cause;
use skeleton::Occupancy;

use crate::TransitionStage;
use crate::ends::{End, PICK, PLACE, Reached, arm_time};

/// Combinations of reaches kept of one grasp.
const COMBINATIONS: usize = 64;

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
