//! The plan with its names resolved: rule V1, and the form of the events (V5).

use model::{LinkId, ObjectId, PairId, Pose, Problem, RobotId};
use plan::{Event, EventKind, PLAN_FORMAT, Plan, RobotTrajectory};

use crate::frame::Frame;
use crate::mechanism::Mechanism;
use crate::track::Track;
use crate::violation::{Rule, Violation};

/// No coordinate, pose or time of a sane plan exceeds this (m, rad, s).
const LARGEST: f64 = 1e6;
/// How far a quaternion's squared norm may be from 1.
const UNIT: f64 = 1e-9;

/// Problem and plan, made ready.
pub(crate) struct Script<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) plan: &'a Plan,
    pub(crate) tracks: Vec<Track<'a>>,
    pub(crate) mechanisms: Vec<Mechanism>,
    /// Events in the plan's order.
    pub(crate) steps: Vec<Step>,
}

/// An event with its names resolved.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub(crate) t: f64,
    pub(crate) kind: EventKind,
    pub(crate) robot: RobotId,
    pub(crate) knot: usize,
    pub(crate) pair: PairId,
    pub(crate) object: ObjectId,
    pub(crate) link: LinkId,
    pub(crate) link_from_object: Frame,
    pub(crate) world_from_object: Frame,
    pub(crate) opening: f64,
}

impl<'a> Script<'a> {
    /// Resolves everything, or says what is malformed.
    pub(crate) fn read(problem: &'a Problem, plan: &'a Plan) -> Result<Self, Vec<Violation>> {
        let mut wrong = Vec::new();
        check_header(problem, plan, &mut wrong);
        if !wrong.is_empty() {
            return Err(wrong);
        }
        let mut mechanisms = Vec::new();
        for (robot, trajectory) in problem.robots.iter().zip(&plan.robots) {
            check_knots(robot, trajectory, &mut wrong);
            check_segments(problem, trajectory, &mut wrong);
            match Mechanism::new(robot) {
                Some(mechanism) => mechanisms.push(mechanism),
                None => wrong.push(Violation::new(Rule::V1, "the robot's joints are no tree").robot(&robot.name)),
            }
        }
        if !wrong.is_empty() {
            return Err(wrong);
        }
        let tracks = plan.robots.iter().map(|trajectory| Track { knots: &trajectory.knots }).collect();
        let mut steps = Vec::new();
        for event in &plan.events {
            match resolve(problem, plan, event) {
                Ok(step) => steps.push(step),
                Err(why) => {
                    wrong.push(Violation::new(Rule::V5, why).robot(&event.robot).object(&event.object).at(event.t))
                }
            }
        }
        if let Some(pair) = steps.windows(2).find(|pair| pair[1].t < pair[0].t) {
            wrong.push(Violation::new(Rule::V5, "the events are not listed in order of time").at(pair[1].t));
        }
        if wrong.is_empty() { Ok(Self { problem, plan, tracks, mechanisms, steps }) } else { Err(wrong) }
    }

    /// End of the last trajectory (s).
    pub(crate) fn horizon(&self) -> f64 {
        self.tracks.iter().map(Track::end).fold(0.0, f64::max)
    }

    pub(crate) fn robot_name(&self, robot: RobotId) -> &'a str {
        &self.problem.robots[robot.index()].name
    }

    pub(crate) fn object_name(&self, object: ObjectId) -> &'a str {
        &self.problem.movable[object.index()].name
    }

    pub(crate) fn pair_name(&self, pair: PairId) -> &'a str {
        &self.problem.pair(pair).name
    }

    pub(crate) fn pair_id(&self, name: &str) -> Option<PairId> {
        self.problem.pairs.iter().position(|pair| pair.name == name).map(PairId::at)
    }

    /// A violation of `rule` about one step.
    pub(crate) fn about(&self, step: &Step, rule: Rule, message: String) -> Violation {
        Violation::new(rule, message)
            .robot(self.robot_name(step.robot))
            .object(self.object_name(step.object))
            .at(step.t)
    }
}

fn check_header(problem: &Problem, plan: &Plan, wrong: &mut Vec<Violation>) {
    let mut say = |message: String| wrong.push(Violation::new(Rule::V1, message));
    if plan.format != PLAN_FORMAT {
        say(format!("format is `{}`, expected `{PLAN_FORMAT}`", plan.format));
    }
    if plan.problem != problem.name {
        say(format!("the plan is for problem `{}`, not `{}`", plan.problem, problem.name));
    }
    let names = |list: Vec<&String>| list.into_iter().cloned().collect::<Vec<_>>().join(", ");
    let (planned, given) = (plan.robots.iter().map(|r| &r.name), problem.robots.iter().map(|r| &r.name));
    if !planned.clone().eq(given.clone()) {
        say(format!("robots are [{}], expected [{}]", names(planned.collect()), names(given.collect())));
    }
    let makespan = plan.makespan;
    if ![makespan.task_s, makespan.total_s, plan.lower_bound.seconds].iter().all(|value| value.is_finite()) {
        say("makespan or lower bound is not finite".to_owned());
    }
}

fn check_knots(robot: &model::Robot, trajectory: &RobotTrajectory, wrong: &mut Vec<Violation>) {
    let mut say = |message: String| wrong.push(Violation::new(Rule::V1, message).robot(&robot.name));
    if !trajectory.joints.iter().eq(robot.coordinates.iter().map(|c| &c.name)) {
        say(format!("joints are [{}], not the robot's coordinates", trajectory.joints.join(", ")));
    }
    if trajectory.knots.is_empty() {
        say("has no knots".to_owned());
    }
    for (i, knot) in trajectory.knots.iter().enumerate() {
        let sane = |value: &f64| value.abs() <= LARGEST;
        if knot.q.len() != robot.coordinates.len() {
            say(format!("knot {i} has {} values for {} coordinates", knot.q.len(), robot.coordinates.len()));
        }
        if !knot.q.iter().all(sane) || !(0.0..=LARGEST).contains(&knot.t) {
            say(format!("knot {i} has a time or value that is not finite, negative in time, or beyond {LARGEST:e}"));
        }
        if i > 0 && trajectory.knots[i - 1].t >= knot.t {
            say(format!("knot {i} at {} s is not later than the knot before it", knot.t));
        }
    }
}

fn check_segments(problem: &Problem, trajectory: &RobotTrajectory, wrong: &mut Vec<Violation>) {
    let mut say = |message: String| wrong.push(Violation::new(Rule::V1, message).robot(&trajectory.name));
    let last = trajectory.knots.len().saturating_sub(1);
    let mut reached = 0;
    for (i, segment) in trajectory.segments.iter().enumerate() {
        if segment.from != reached || segment.to < segment.from || segment.to > last {
            say(format!("segment {i} covers knots {}..={}, expected to begin at {reached}", segment.from, segment.to));
            return;
        }
        reached = segment.to;
        let Some(name) = &segment.pair else { continue };
        let known = problem.pairs.iter().find(|pair| pair.name == *name);
        if known.is_none_or(|pair| problem.robot(pair.robot).name != trajectory.name) {
            say(format!("segment {i} belongs to `{name}`, which is no pair of this robot"));
        }
    }
    if reached != last {
        say(format!("segments end at knot {reached}, the trajectory at knot {last}"));
    }
}

/// Finds what an event names.
fn resolve(problem: &Problem, plan: &Plan, event: &Event) -> Result<Step, String> {
    let robot = problem.robots.iter().position(|r| r.name == event.robot).ok_or("unknown robot")?;
    let pair = problem.pairs.iter().position(|p| p.name == event.pair).ok_or("unknown pair")?;
    let object = problem.movable.iter().position(|m| m.name == event.object).ok_or("unknown object")?;
    let action = &problem.pairs[pair];
    if action.robot.index() != robot || action.object.index() != object {
        return Err(format!("pair {} is another robot's or moves another object", event.pair));
    }
    let knot = plan.robots[robot].knots.get(event.knot).ok_or(format!("there is no knot {}", event.knot))?;
    if knot.t != event.t {
        return Err(format!("is said to be at {} s, but knot {} is at {} s", event.t, event.knot, knot.t));
    }
    let hand = &problem.robots[robot].end_effector;
    if problem.robots[robot].links[hand.parent_link.index()].name != event.link {
        return Err(format!("holds with `{}`, which is not the hand's link", event.link));
    }
    if !(0.0..=hand.max_opening + 1e-9).contains(&event.opening) {
        return Err(format!("an opening of {} m is beyond the hand's {}", event.opening, hand.max_opening));
    }
    Ok(Step {
        t: event.t,
        kind: event.kind,
        robot: RobotId::at(robot),
        knot: event.knot,
        pair: PairId::at(pair),
        object: ObjectId::at(object),
        link: hand.parent_link,
        link_from_object: frame(event.link_from_object)?,
        world_from_object: frame(event.world_from_object)?,
        opening: event.opening,
    })
}

fn frame(record: plan::PoseRecord) -> Result<Frame, String> {
    let norm: f64 = record.quat_xyzw.iter().map(|x| x * x).sum();
    if (norm - 1.0).abs() > UNIT || !record.xyz.iter().all(|x| x.abs() <= LARGEST) || !norm.is_finite() {
        return Err("a pose is not a finite translation with a unit quaternion".to_owned());
    }
    Ok(Frame::of(&Pose::from(record)))
}
