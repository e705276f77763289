//! Certificates about what a robot can reach.

use glamx::{DVec2, DVec3};
use model::{Grasp, Problem, Robot};
use plan::{BaseMap, Distance, DistanceLimit};

use crate::infeasible::arm::distance_range;
use crate::infeasible::named::PairAt;
use crate::infeasible::places::{Places, base_from_world};
use crate::infeasible::targets::{Poses, Targets};
use crate::mechanism::Mechanism;

/// Allowance (m) for rounding when numbers are compared with claims.
const ROUNDING: f64 = 1e-9;

/// A robot's shoulder, and places of the hand's origin that it would have to reach.
struct Arm {
    shoulder: DVec3,
    /// Least and greatest distance between shoulder and hand (m).
    range: (f64, f64),
    /// Whether the base turns, so that the shoulder may be anywhere on a circle about the base's place.
    drives: bool,
    targets: Vec<Targets>,
}

impl Arm {
    fn of<'g>(
        problem: &Problem,
        at: &PairAt,
        grasps: impl Iterator<Item = &'g Grasp>,
        shoulder: [f64; 3],
    ) -> Result<Self, String> {
        let robot = problem.robot(at.pair.robot);
        let mechanism = Mechanism::new(robot).ok_or_else(|| format!("the joints of {} are no tree", robot.name))?;
        let (axes, hand) = mechanism.chain(robot, robot.end_effector.parent_link);
        let shoulder = DVec3::from(shoulder);
        if !shoulder.is_finite() {
            return Err("the shoulder is nowhere".to_owned());
        }
        let (poses, base_from_world) = (Poses::of(problem, at)?, base_from_world(robot)?);
        Ok(Self {
            shoulder,
            range: distance_range(&axes, shoulder, hand),
            drives: robot.base.is_some(),
            targets: grasps.map(|grasp| Targets::of(&poses, grasp, &base_from_world)).collect(),
        })
    }

    /// Where the shoulder is when the base is at `place`: a point, and how far off it may be.
    fn shoulder_at(&self, place: DVec2, spread: f64) -> (DVec2, f64) {
        let aside = self.shoulder.truncate();
        if self.drives { (place, spread + aside.length()) } else { (place + aside, spread) }
    }

    fn nearest(&self, place: DVec2, spread: f64) -> f64 {
        let (from, spread) = self.shoulder_at(place, spread);
        let distances = self.targets.iter().map(|targets| targets.nearest(from, spread, self.shoulder.z));
        distances.fold(f64::INFINITY, f64::min)
    }

    fn farthest(&self, place: DVec2, spread: f64) -> f64 {
        let (from, spread) = self.shoulder_at(place, spread);
        let distances = self.targets.iter().map(|targets| targets.farthest(from, spread, self.shoulder.z));
        distances.fold(0.0, f64::max)
    }
}

/// The list of grasps of a pair.
pub(crate) fn grasps<'a>(problem: &'a Problem, at: &PairAt) -> &'a [Grasp] {
    let grasps = &problem.movable[at.pair.object.index()].grasps;
    grasps.get(at.pair.robot.index()).map_or(&[], Vec::as_slice)
}

/// From every place of the map, every pose of the object and every one of `grasps`, the hand is out of reach.
pub(crate) fn check_distance<'g>(
    problem: &Problem,
    at: &PairAt,
    grasps: impl Iterator<Item = &'g Grasp>,
    distance: &Distance,
    map: Option<&BaseMap>,
) -> Result<(), String> {
    let arm = Arm::of(problem, at, grasps, distance.shoulder_m)?;
    let robot = problem.robot(at.pair.robot);
    let places = Places::of(problem, robot, map)?;
    match distance.limit {
        DistanceLimit::Far { greatest_m, nearest_m } => {
            check_greatest(robot, &arm, greatest_m)?;
            let nearest = places.free().map(|place| arm.nearest(place, places.spread)).fold(f64::INFINITY, f64::min);
            let holds = nearest_m > greatest_m && nearest >= nearest_m - ROUNDING;
            holds.then_some(()).ok_or_else(|| format!("the hand may have to be as near as {nearest} m"))
        }
        DistanceLimit::Near { least_m, farthest_m } => {
            let keeps_off = arm.range.0 >= least_m - ROUNDING;
            if !keeps_off {
                return Err(format!("the hand of {} comes as near as {} m", robot.name, arm.range.0));
            }
            let farthest = places.free().map(|place| arm.farthest(place, places.spread)).fold(0.0, f64::max);
            let holds = farthest_m < least_m && farthest <= farthest_m + ROUNDING;
            holds.then_some(()).ok_or_else(|| format!("the hand may have to be as far as {farthest} m"))
        }
    }
}

fn check_greatest(robot: &Robot, arm: &Arm, greatest: f64) -> Result<(), String> {
    let holds = arm.range.1 <= greatest + ROUNDING;
    holds.then_some(()).ok_or_else(|| format!("the hand of {} may get as far as {} m", robot.name, arm.range.1))
}

/// From no place that the base can drive to from its start is the hand within reach.
pub(crate) fn check_disconnected(
    problem: &Problem,
    at: &PairAt,
    from: [f64; 2],
    shoulder: [f64; 3],
    greatest: f64,
    map: &BaseMap,
) -> Result<(), String> {
    let robot = problem.robot(at.pair.robot);
    let start = match (&robot.base, &robot.start[..]) {
        (Some(_), [x, y, ..]) if (x - from[0]).hypot(y - from[1]) <= ROUNDING => DVec2::new(*x, *y),
        _ => return Err(format!("the base of {} does not start at {from:?}", robot.name)),
    };
    let arm = Arm::of(problem, at, grasps(problem, at).iter(), shoulder)?;
    check_greatest(robot, &arm, greatest)?;
    let places = Places::of(problem, robot, Some(map))?;
    let reaches = |place: &DVec2| arm.nearest(*place, places.spread) <= greatest;
    match places.connected(start)?.iter().find(|place| reaches(place)) {
        Some(place) => Err(format!("the base may drive to {:.3}, {:.3}, from where it may reach", place.x, place.y)),
        None => Ok(()),
    }
}
