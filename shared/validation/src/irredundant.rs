//! Rule V15: no ordering is there without need.
//!
//! A discovered ordering must not follow from the others, and what it names as its cause must be so in this plan:
//!
//! * two poses that exclude one another (`overlap`) do: the objects that stand there would be nearer than the clearance;
//! * a pose that is in the way of a mode (`no_path`) is: the robot's executed motion in that mode, what it holds included,
//!   comes nearer to it than the clearance. That is weaker than to show that there is no other way, which would need all
//!   of the robot's motions.
//!
//! An ordering that is called given must follow from the problem.

use model::{ObjectId, PairId, Point, Problem, Removal};
use plan::{BodyRef, Cause, Origin, PlanOrdering};

use crate::actor::Actor;
use crate::points::Points;
use crate::precedence::{At, Precedence};
use crate::script::Script;
use crate::solid::Solid;
use crate::sweep::Placed;
use crate::timeline::{Standing, Timeline};
use crate::violation::{Rule, Violation};

/// Rounding forgiven where poses are copies of the planner's (m).
const POSES: f64 = 1e-5;
/// Motion between two instants at which a robot is looked at (m): so much farther than the clearance still counts as near.
const STEP: f64 = 4e-3;

/// Checks every ordering of the plan.
pub(crate) fn check(script: &Script, timeline: &Timeline, points: &Points, wrong: &mut Vec<Violation>) {
    let orderings = &script.plan.orderings;
    let at = |listed: &plan::PairPoint| script.pair_id(&listed.pair).map(|pair| (pair, listed.point));
    let ends: Vec<Option<(At, At)>> =
        orderings.iter().map(|ordering| at(&ordering.before).zip(at(&ordering.after))).collect();
    let given = Precedence::given(script.problem);
    for (i, ordering) in orderings.iter().enumerate() {
        let Some((before, after)) = ends[i] else { continue };
        let mut others = given.clone();
        if ordering.origin == Origin::Discovered {
            let rest = ends.iter().enumerate().filter(|(other, _)| *other != i);
            rest.filter_map(|(_, ends)| *ends).for_each(|(before, after)| others.add(before, after));
        }
        let follows = others.precedes(before, after);
        let found = match (ordering.origin, follows) {
            (Origin::Given, true) => continue,
            (Origin::Given, false) => Err("is called given, but does not follow from the problem".to_owned()),
            (Origin::Discovered, true) => Err("follows from the others".to_owned()),
            (Origin::Discovered, false) => witness(script, timeline, points, ordering, (before, after)),
        };
        let Err(why) = found else { continue };
        let words = |at: &plan::PairPoint| format!("{} of {}", at.point.name(), at.pair);
        let message = format!("{} before {} {why}", words(&ordering.before), words(&ordering.after));
        let robot = |(pair, _): At| script.robot_name(script.problem.pair(pair).robot);
        wrong.push(Violation::new(Rule::V15, message).robot(robot(before)).robot(robot(after)));
    }
}

/// Whether an ordering's cause is so.
fn witness(
    script: &Script,
    timeline: &Timeline,
    points: &Points,
    ordering: &PlanOrdering,
    (before, after): (At, At),
) -> Result<(), String> {
    match &ordering.cause {
        Some(Cause::Overlap { region, leaves, comes }) => {
            let problem = script.problem;
            let named = before.1 == leaving(problem)
                && after.1 == Point::Release
                && script.object_name(problem.pair(before.0).object) == leaves
                && script.object_name(problem.pair(after.0).object) == comes
                && problem.regions[problem.pair(after.0).to.index()].name == *region;
            let stays = ended_by(timeline, before.0).zip(begun_by(timeline, after.0)).filter(|_| named);
            let (first, second) = stays.ok_or("does not keep apart the stays that its cause names")?;
            let near = gap(script, first, second) <= script.problem.settings.clearance + POSES;
            near.then_some(()).ok_or_else(|| format!("keeps {leaves} and {comes} apart, which do not collide"))
        }
        Some(Cause::NoPath { pair, robot, blocking }) => {
            let pair = pair.as_deref().map(|name| script.pair_id(name).ok_or("has an unknown pair in its cause"));
            let obstructed = Obstructed::of(script, points, pair.transpose()?, robot, (before, after))
                .ok_or("does not end the obstruction that its cause names")?;
            let standing = obstructed.standing(timeline).filter(|standing| {
                let name = script.object_name(standing.object);
                blocking.iter().any(|body| matches!(body, BodyRef::Object(object) if object == name))
            });
            let standing = standing.ok_or("does not end the obstruction that its cause names")?;
            let near = obstructed.comes_near(script, timeline, standing);
            near.then_some(()).ok_or_else(|| {
                let object = script.object_name(standing.object);
                format!("keeps {object} out of the way of {robot}, which comes nowhere near it")
            })
        }
        Some(_) => Err("has a cause that cannot be checked".to_owned()),
        None => Err("has no cause".to_owned()),
    }
}

/// The point at which an object that is taken away leaves its place to others.
pub(crate) fn leaving(problem: &Problem) -> Point {
    match problem.settings.removal {
        Removal::Grasp => Point::Grasp,
        Removal::Completed => Point::Release,
    }
}

fn ended_by(timeline: &Timeline, pair: PairId) -> Option<&Standing> {
    timeline.standings.iter().find(|s| s.taken_by.is_some_and(|hold| timeline.holds[hold].pair == pair))
}

fn begun_by(timeline: &Timeline, pair: PairId) -> Option<&Standing> {
    timeline.standings.iter().find(|s| s.put_by.is_some_and(|hold| timeline.holds[hold].pair == pair))
}

fn solid(script: &Script, object: ObjectId) -> Solid {
    Solid::new(&script.problem.movable[object.index()].body)
}

/// Least distance of two standing objects (m); not positive if they would touch.
pub(crate) fn gap(script: &Script, first: &Standing, second: &Standing) -> f64 {
    let [a, b] = [first, second].map(|standing| solid(script, standing.object));
    let (at, other_at) = (first.world_from_object * a.owner_from_shape, second.world_from_object * b.owner_from_shape);
    a.certified_gap(&at, &b, &other_at)
}

/// A robot's motion that a pose was in the way of, and which event keeps that pose out of it.
struct Obstructed {
    robot: usize,
    /// From when to when (s).
    from: f64,
    to: f64,
    /// The pose comes with this pair's release, or goes with its grasp.
    comes: Option<PairId>,
    goes: Option<PairId>,
}

impl Obstructed {
    /// What an ordering with this cause keeps free: the mode of `pair` (of none: the closing return) that it names a point
    /// of, from the event before it until the arm is folded again after it.
    fn of(script: &Script, points: &Points, pair: Option<PairId>, robot: &str, ends: (At, At)) -> Option<Self> {
        let robot = script.problem.robots.iter().position(|known| known.name == robot)?;
        let of_robot = |at: At| script.problem.pair(at.0).robot.index() == robot;
        let (own, comes, goes) = match ends {
            (own, (other, Point::Release)) if of_robot(own) => (own, Some(other), None),
            ((other, Point::Grasp), own) if of_robot(own) => (own, None, Some(other)),
            _ => return None,
        };
        let time = |pair: PairId, point: Point| points.time(pair, point);
        let pairs: Vec<PairId> = script.problem.pairs_of_robot(model::RobotId::at(robot)).collect();
        let (from, to) = match (pair, own.1) {
            (None, _) if pairs.last() == Some(&own.0) => (time(own.0, Point::Release)?, script.horizon()),
            (Some(pair), Point::Start | Point::AtPick | Point::Grasp | Point::Carry) if pair == own.0 => {
                let before = pairs.iter().position(|known| *known == pair)?.checked_sub(1);
                let from = before.and_then(|i| time(pairs[i], Point::Release)).unwrap_or(0.0);
                (from, time(pair, Point::Carry).or(time(pair, Point::Grasp))?)
            }
            (Some(pair), Point::AtPlace | Point::Release | Point::Done) if pair == own.0 => {
                (time(pair, Point::Grasp)?, time(pair, Point::Done)?)
            }
            _ => return None,
        };
        Some(Self { robot, from, to, comes, goes })
    }

    fn standing<'t>(&self, timeline: &'t Timeline) -> Option<&'t Standing> {
        self.comes.and_then(|pair| begun_by(timeline, pair)).or(self.goes.and_then(|pair| ended_by(timeline, pair)))
    }

    /// Whether the robot, or what it holds, comes nearer to the pose than the clearance, give or take [`STEP`].
    fn comes_near(&self, script: &Script, timeline: &Timeline, standing: &Standing) -> bool {
        let mut actor = Actor::new(script, timeline, self.robot);
        let object = solid(script, standing.object);
        let still = Placed::still(&object, standing.world_from_object);
        let near = script.problem.settings.clearance + STEP;
        let mut stops: Vec<f64> = actor.track.times().filter(|t| *t > self.from && *t < self.to).collect();
        stops.insert(0, self.from);
        stops.push(self.to);
        for leg in stops.windows(2) {
            actor.enter((leg[0], leg[1]));
            let ball = actor.ball();
            let reach = ball.radius + ball.speed * (leg[1] - leg[0]) / 2.0 + object.radius + near;
            if ball.centre.distance(still.centre) > reach {
                continue;
            }
            let steps = (2.0 * ball.speed * (leg[1] - leg[0]) / STEP).ceil().max(1.0);
            for i in 0..=steps as usize {
                actor.place(leg[0] + (leg[1] - leg[0]) * i as f64 / steps);
                let meets = |i: usize| {
                    let (solid, placed) = actor.body(i);
                    placed.centre.distance(still.centre) <= solid.radius + object.radius + near
                        && solid.certified_gap(&placed.frame, &object, &still.frame) <= near
                };
                if (0..actor.bodies()).any(meets) {
                    return true;
                }
            }
        }
        false
    }
}
