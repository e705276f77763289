//! The seven points of each pair, computed from the plan.
//!
//! * `grasp`, `release`: its attach and detach events.
//! * `done`: end of the pair's last retract segment that begins at or after the release; there the arm must be home.
//! * `start`: `done` of the robot's pair before it; 0 for the first.
//! * `carry`: end of the pair's last retract segment between grasp and release; there the arm must be in carry.
//! * `at_pick`, `at_place`: the first knot from which on the base does not move until the grasp (the release), but not
//!   before `start` (not before `carry`, or the grasp where the arm is never brought to carry).

use model::{PairId, Point};
use plan::{EventKind, RobotTrajectory, SegmentKind};

use crate::script::{Script, Step};
use crate::violation::{Rule, Violation};

/// How far an arm may be from the named configuration it is said to be in (m, rad).
const NAMED: f64 = 1e-6;
/// How far a base may move and still count as standing (m, rad).
const STANDING: f64 = 1e-9;

/// Times (s) of the points of every pair; `None` where the plan does not have the point.
pub(crate) struct Points {
    times: Vec<[Option<f64>; 7]>,
}

impl Points {
    /// Computes all points; a pair that is never done, or done with its arm not home, is a violation of V5.
    pub(crate) fn compute(script: &Script, wrong: &mut Vec<Violation>) -> Self {
        let mut points = Self { times: vec![[None; 7]; script.problem.pairs.len()] };
        for robot in script.problem.robot_ids() {
            let mut start = Some(0.0);
            for pair in script.problem.pairs_of_robot(robot) {
                points.times[pair.index()] = times_of(script, pair, start, wrong);
                start = points.time(pair, Point::Done);
            }
        }
        points
    }

    pub(crate) fn time(&self, pair: PairId, point: Point) -> Option<f64> {
        self.times[pair.index()][point as usize]
    }

    /// Latest `done` (s).
    pub(crate) fn last_done(&self) -> f64 {
        self.times.iter().filter_map(|times| times[Point::Done as usize]).fold(0.0, f64::max)
    }
}

fn times_of(script: &Script, pair: PairId, start: Option<f64>, wrong: &mut Vec<Violation>) -> [Option<f64>; 7] {
    let find = |kind: EventKind| script.steps.iter().find(|step| step.pair == pair && step.kind == kind);
    let (attach, detach) = (find(EventKind::Attach), find(EventKind::Detach));
    let robot = script.problem.pair(pair).robot.index();
    let (model, trajectory) = (&script.problem.robots[robot], &script.plan.robots[robot]);
    let name = script.pair_name(pair);
    let carry = attach.and_then(|a| last_retract(trajectory, name, a.knot, detach.map_or(usize::MAX, |d| d.knot)));
    let done = detach.and_then(|d| last_retract(trajectory, name, d.knot, usize::MAX));
    let mut check = |step: Option<&Step>, knot: Option<usize>, named: &[f64], what: &str| {
        let (Some(step), Some(knot)) = (step, knot) else { return };
        let arm = &trajectory.knots[knot].q[model.base_len()..];
        if arm.iter().zip(named).any(|(a, b)| (a - b).abs() > NAMED) {
            let message = format!("the retract of {name} ends at knot {knot} with the arm not in `{what}`");
            wrong.push(script.about(step, Rule::V5, message));
        }
    };
    check(attach, carry, &model.carry, "carry");
    check(detach, done, &model.home, "home");
    if let (Some(step), None) = (detach, done) {
        wrong.push(script.about(step, Rule::V5, format!("{name} has no retract segment after its release")));
    }
    let t = |knot: Option<usize>| knot.map(|k| trajectory.knots[k].t);
    let grasp = attach.map(|step| step.t);
    let arrival = |step: &Step, earliest: Option<f64>| {
        let arrived = trajectory.knots[base_arrival(trajectory, model.base_len(), step.knot)].t;
        earliest.map_or(arrived, |earliest| earliest.max(arrived))
    };
    let at_pick = attach.map(|step| arrival(step, start));
    let at_place = detach.map(|step| arrival(step, t(carry).or(grasp)));
    [start, at_pick, grasp, t(carry), at_place, detach.map(|step| step.t), t(done)]
}

/// Knot at the end of a pair's last retract segment between two knots.
fn last_retract(trajectory: &RobotTrajectory, pair: &str, from: usize, to: usize) -> Option<usize> {
    let is_wanted = |segment: &&plan::Segment| {
        segment.kind == SegmentKind::Retract
            && segment.pair.as_deref() == Some(pair)
            && segment.from >= from
            && segment.to <= to
    };
    trajectory.segments.iter().rfind(is_wanted).map(|segment| segment.to)
}

/// The first knot from which on the base stands until `knot`.
fn base_arrival(trajectory: &RobotTrajectory, base_len: usize, knot: usize) -> usize {
    let stand = &trajectory.knots[knot].q[..base_len];
    let stands = |q: &[f64]| q[..base_len].iter().zip(stand).all(|(a, b)| (a - b).abs() <= STANDING);
    (0..knot).rev().take_while(|k| stands(&trajectory.knots[*k].q)).last().unwrap_or(knot)
}

/// Latest end of any pair's last retract after its release (s), by names alone.
pub(crate) fn last_done(plan: &plan::Plan) -> f64 {
    let mut latest: f64 = 0.0;
    for event in plan.events.iter().filter(|event| event.kind == EventKind::Detach) {
        let Some(trajectory) = plan.robots.iter().find(|robot| robot.name == event.robot) else { continue };
        if let Some(knot) = last_retract(trajectory, &event.pair, event.knot, usize::MAX) {
            latest = latest.max(trajectory.knots.get(knot).map_or(0.0, |knot| knot.t));
        }
    }
    latest
}
