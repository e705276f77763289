//! Proofs that a robot can do its part of a pair in no way: for every grasp of the list, every pose that the object may have
//! there, and every stand.
//!
//! They are handed on as certificates, which somebody else verifies by other means; so every number keeps a distance from
//! the limit that it must not pass. Tolerances are those with which a plan is checked, not the planner's own.

mod cover;
mod disc;
mod floor;
mod hand;
mod poses;
mod target;

use kinematics::Reach;
use model::{Grasp, Pair, PairId};
use plan::{BaseMap, Certificate, Distance, DistanceLimit, GraspReason, PairEnd, RefutedGrasp};

use crate::Geometry;
use floor::Floor;
use poses::Poses;
use target::Target;

/// Distance (m) that must be left between what the arm can and what it would have to.
const GAP: f64 = 0.003;

/// A robot's arm and the places from which it may be used.
struct Arm<'a> {
    reach: Reach,
    /// None: the base is fixed.
    floor: Option<Floor<'a>>,
}

impl Geometry {
    /// Proves that nothing like a transition configuration exists at an end of a pair: for every grasp and every pose of
    /// the object the hand is out of reach from every stand; or that each grasp is impossible at one of the ends, out of
    /// reach or with the hand in a fixed object wherever the object stands.
    #[must_use]
    pub fn prove_no_transition(&self, pair: PairId) -> Option<Certificate> {
        let of = self.problem().pairs.get(pair.index())?;
        let arm = self.arm(of)?;
        let ends = [PairEnd::Pick, PairEnd::Place];
        let out_of_reach = ends.into_iter().find_map(|end| {
            let distance = arm.out_of_reach(&self.targets(of, end, self.grasps(of))?)?;
            Some((end, distance))
        });
        let robot = self.problem().robot(of.robot).name.clone();
        if let Some((end, distance)) = out_of_reach {
            let (region, map) = (self.region_name(of, end), arm.map());
            return Some(Certificate::Reach { robot, pair: of.name.clone(), end, region, distance, map });
        }
        let refuted = self.grasps(of).iter().zip(0..).map(|(grasp, index)| {
            let reason = |end| Some((end, self.refute(of, end, grasp, &arm)?));
            let (end, reason) = ends.into_iter().find_map(reason)?;
            Some(RefutedGrasp { grasp: index, end, reason })
        });
        Some(Certificate::NoCommonGrasp { robot, pair: of.name.clone(), grasps: refuted.collect::<Option<_>>()? })
    }

    /// Proves that from its start a robot's base cannot get to where the arm could reach one end of a pair.
    #[must_use]
    pub fn prove_no_drive(&self, pair: PairId, end: PairEnd) -> Option<Certificate> {
        let of = self.problem().pairs.get(pair.index())?;
        let (arm, robot) = (self.arm(of)?, self.problem().robot(of.robot));
        let floor = arm.floor.as_ref()?;
        let from_m = [robot.start[0], robot.start[1]];
        let targets = self.targets(of, end, self.grasps(of))?;
        floor.connected(from_m, |place| arm.may_reach(&targets, place))?;
        Some(Certificate::BaseDisconnected {
            robot: robot.name.clone(),
            pair: of.name.clone(),
            end,
            region: self.region_name(of, end),
            from_m,
            shoulder_m: arm.shoulder(),
            greatest_m: arm.reach.greatest + GAP / 2.0,
            map: floor.map.clone(),
        })
    }

    fn refute(&self, pair: &Pair, end: PairEnd, grasp: &Grasp, arm: &Arm<'_>) -> Option<GraspReason> {
        if let Some(by) = self.blocked_grasp(pair, &Poses::of(self, pair, end)?, grasp) {
            let names = by.into_iter().map(|fixed| self.problem().fixed[fixed.index()].name.clone());
            return Some(GraspReason::Blocked { by: names.collect() });
        }
        let distance = arm.out_of_reach(&self.targets(pair, end, std::slice::from_ref(grasp))?)?;
        Some(GraspReason::OutOfReach { distance, map: arm.map() })
    }

    /// The arm of a pair's robot; `None` where the base does not stand level, or has no finite limits.
    fn arm(&self, pair: &Pair) -> Option<Arm<'_>> {
        let robot = self.problem().robot(pair.robot);
        let floor = if robot.base.is_some() { Some(Floor::of(self, robot)?) } else { None };
        floor::is_level(&robot.world_from_base).then(|| Arm { reach: Reach::of(robot), floor })
    }

    fn grasps(&self, pair: &Pair) -> &[Grasp] {
        self.problem().movable[pair.object.index()].grasps.get(pair.robot.index()).map_or(&[], Vec::as_slice)
    }

    fn targets(&self, pair: &Pair, end: PairEnd, grasps: &[Grasp]) -> Option<Vec<Target>> {
        let base_from_world = self.problem().robot(pair.robot).world_from_base.inverse();
        let poses = Poses::of(self, pair, end)?;
        Some(grasps.iter().map(|grasp| Target::of(&poses, grasp, &base_from_world)).collect())
    }

    fn region_name(&self, pair: &Pair, end: PairEnd) -> String {
        let region = if end == PairEnd::Pick { pair.from } else { pair.to };
        self.problem().regions[region.index()].name.clone()
    }
}

impl Arm<'_> {
    fn map(&self) -> Option<BaseMap> {
        self.floor.as_ref().map(|floor| floor.map.clone())
    }

    fn shoulder(&self) -> [f64; 3] {
        self.reach.root_from_shoulder.coords.into()
    }

    /// Distances that prove all targets out of reach from all places.
    fn out_of_reach(&self, targets: &[Target]) -> Option<Distance> {
        let (least, greatest) = (self.reach.least, self.reach.greatest);
        let limit = if self.all_places(|place| !self.may_reach(targets, place)) {
            let nearest = self.extreme(|place| self.nearest(targets, place), f64::min)?;
            DistanceLimit::Far { greatest_m: greatest + GAP / 3.0, nearest_m: nearest - GAP / 3.0 }
        } else if self.all_places(|place| self.is_too_near(targets, place)) {
            let farthest = self.extreme(|place| self.farthest(targets, place), f64::max)?;
            DistanceLimit::Near { least_m: least - GAP / 3.0, farthest_m: farthest + GAP / 3.0 }
        } else {
            return None;
        };
        Some(Distance { shoulder_m: self.shoulder(), limit })
    }

    /// Whether something holds for all places where the base may stand; a fixed base stands at its origin.
    fn all_places(&self, holds: impl Fn([f64; 2]) -> bool) -> bool {
        match &self.floor {
            Some(floor) => floor.cells().all(|cell| holds(floor.middle(cell)) || floor.is_blocked(cell)),
            None => holds([0.0; 2]),
        }
    }

    /// The least or greatest value over those places; `None` where there is no place.
    fn extreme(&self, value: impl Fn([f64; 2]) -> f64, of: fn(f64, f64) -> f64) -> Option<f64> {
        match &self.floor {
            Some(floor) => {
                floor.cells().filter(|cell| !floor.is_blocked(*cell)).map(|cell| value(floor.middle(cell))).reduce(of)
            }
            None => Some(value([0.0; 2])),
        }
    }

    /// Least distance (m) of the shoulder from a target, at least.
    fn nearest(&self, targets: &[Target], place: [f64; 2]) -> f64 {
        let (from, spread) = self.shoulder_at(place);
        targets.iter().map(|target| target.nearest(from, spread)).fold(f64::INFINITY, f64::min)
    }

    /// Greatest distance (m) of the shoulder from a target, at most.
    fn farthest(&self, targets: &[Target], place: [f64; 2]) -> f64 {
        let (from, spread) = self.shoulder_at(place);
        targets.iter().map(|target| target.farthest(from, spread)).fold(0.0, f64::max)
    }

    fn may_reach(&self, targets: &[Target], place: [f64; 2]) -> bool {
        self.nearest(targets, place) <= self.reach.greatest + GAP
    }

    fn is_too_near(&self, targets: &[Target], place: [f64; 2]) -> bool {
        self.farthest(targets, place) < self.reach.least - GAP
    }

    /// The shoulder in the base's frame, and how far it may be from there: a base that drives turns as well.
    fn shoulder_at(&self, [x, y]: [f64; 2]) -> ([f64; 3], f64) {
        let shoulder = &self.reach.root_from_shoulder;
        match &self.floor {
            Some(floor) => ([x, y, shoulder.z], floor.spread + shoulder.x.hypot(shoulder.y)),
            None => ([shoulder.x, shoulder.y, shoulder.z], 0.0),
        }
    }
}
