//! Rules V2 (robots), V3 and V4: start configuration, joint limits, speeds.

use model::Robot;
use plan::Knot;

use crate::script::Script;
use crate::violation::{Rule, Violation};

/// Tolerance on coordinates (m, rad).
const COORDINATE: f64 = 1e-9;
/// Relative tolerance on durations.
const DURATION: f64 = 1e-9;

pub(crate) fn check(script: &Script, wrong: &mut Vec<Violation>) {
    for (robot, track) in script.problem.robots.iter().zip(&script.tracks) {
        let start = track.knots[0].q.iter().zip(&robot.start);
        if let Some((i, (found, given))) = start.enumerate().find(|(_, (q, s))| (**q - **s).abs() > COORDINATE) {
            let name = &robot.coordinates[i].name;
            let message = format!("starts with {name} = {found}, but the problem says {given}");
            wrong.push(Violation::new(Rule::V2, message).robot(&robot.name).at(track.knots[0].t));
        }
        wrong.extend(track.knots.iter().find_map(|knot| beyond_limit(robot, knot)));
        wrong.extend(track.knots.windows(2).find_map(|pair| too_fast(robot, &pair[0], &pair[1])));
    }
}

/// Between knots every value lies between those of the knots, so that knots suffice.
fn beyond_limit(robot: &Robot, knot: &Knot) -> Option<Violation> {
    let (coordinate, value) = robot
        .coordinates
        .iter()
        .zip(&knot.q)
        .find(|(c, q)| **q < c.lower - COORDINATE || **q > c.upper + COORDINATE)?;
    let message = format!("{} = {value} is outside [{}, {}]", coordinate.name, coordinate.lower, coordinate.upper);
    Some(Violation::new(Rule::V3, message).robot(&robot.name).at(knot.t))
}

fn too_fast(robot: &Robot, from: &Knot, to: &Knot) -> Option<Violation> {
    let available = (to.t - from.t) * (1.0 + DURATION);
    let moved = |i: usize| (to.q[i] - from.q[i]).abs();
    let mut needed: Vec<(&str, f64)> = Vec::new();
    if let Some(base) = &robot.base {
        needed.push(("the base", moved(0).hypot(moved(1)) / base.speed));
        needed.push(("the base's yaw", moved(2) / base.yaw_rate));
    }
    for i in robot.base_len()..robot.coordinates.len() {
        needed.push((&robot.coordinates[i].name, moved(i) / robot.coordinates[i].velocity));
    }
    // `0 / 0` means: no speed allowed and none asked for.
    let (what, least) = needed.into_iter().find(|(_, least)| *least > available)?;
    let message = format!("{what} needs {least} s for a motion of {} s", to.t - from.t);
    Some(Violation::new(Rule::V4, message).robot(&robot.name).at(from.t))
}
