//! Rules V13 and V14: everything done, and the makespans as reported.

use model::{EndPolicy, PairId, Robot, RobotId};

use crate::points::Points;
use crate::script::Script;
use crate::timeline::Timeline;
use crate::violation::{Rule, Violation};

/// How far a robot may end from where its policy says (m, rad).
const END: f64 = 1e-6;
/// How far a reported makespan may be from the trajectories' (s).
const MAKESPAN: f64 = 1e-9;

pub(crate) fn check_goal(script: &Script, timeline: &Timeline, wrong: &mut Vec<Violation>) {
    for (i, pair) in script.problem.pairs.iter().enumerate() {
        let what = match timeline.hold_of(PairId::at(i)) {
            None => "is never executed",
            Some(hold) if hold.detach.is_none() => "never releases its object",
            Some(_) => continue,
        };
        let message = format!("{} {what}", pair.name);
        let (robot, object) = (script.robot_name(pair.robot), script.object_name(pair.object));
        wrong.push(Violation::new(Rule::V13, message).robot(robot).object(object));
    }
    for robot in script.problem.robot_ids() {
        wrong.extend(misses_end(script, timeline, robot));
    }
}

fn misses_end(script: &Script, timeline: &Timeline, id: RobotId) -> Option<Violation> {
    let (robot, track) = (script.problem.robot(id), &script.tracks[id.index()]);
    let policy = script.problem.end_policies.get(id.index()).copied().unwrap_or_default();
    let last = timeline.holds.iter().rfind(|hold| hold.robot == id).and_then(|hold| hold.detach);
    let goal = match (policy, last) {
        (EndPolicy::Stay, Some(detach)) => {
            let stand = &track.knots[script.steps[detach].knot].q[..robot.base_len()];
            [stand, &robot.home].concat()
        }
        _ => robot.start.clone(),
    };
    let end = track.knots.last()?;
    let off = |i: usize| coordinate_difference(robot, i, end.q[i], goal[i]);
    let worst = (0..goal.len()).max_by(|a, b| off(*a).total_cmp(&off(*b))).filter(|i| off(*i) > END)?;
    let name = &robot.coordinates[worst].name;
    let message = format!("ends with {name} = {}, but `{policy:?}` asks for {}", end.q[worst], goal[worst]);
    Some(Violation::new(Rule::V13, message).robot(&robot.name).at(end.t))
}

/// Unbounded angles count up to whole turns.
fn coordinate_difference(robot: &Robot, i: usize, a: f64, b: f64) -> f64 {
    let coordinate = &robot.coordinates[i];
    let endless = coordinate.lower == f64::NEG_INFINITY && coordinate.upper == f64::INFINITY;
    let turn = std::f64::consts::TAU;
    // Base x and y are never angles, whatever their limits.
    let angle = if robot.base.is_some() && i < 3 { i == 2 } else { endless };
    if angle { ((a - b) - turn * ((a - b) / turn).round()).abs() } else { (a - b).abs() }
}

pub(crate) fn check_makespan(script: &Script, points: &Points, wrong: &mut Vec<Violation>) {
    let (makespan, bound) = (script.plan.makespan, &script.plan.lower_bound);
    let (total, task) = (script.horizon(), points.last_done());
    for (name, reported, found) in [("total_s", makespan.total_s, total), ("task_s", makespan.task_s, task)] {
        if (reported - found).abs() > MAKESPAN {
            wrong.push(Violation::new(Rule::V14, format!("{name} is {reported}, the trajectories say {found}")));
        }
    }
    if bound.seconds > task + MAKESPAN {
        let message = format!("the lower bound of {} s exceeds the makespan of {task} s", bound.seconds);
        wrong.push(Violation::new(Rule::V14, message));
    }
}
