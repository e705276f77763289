//! Where in a mode's moves the points of pairs lie, as the checker of plans defines them.
//!
//! `done` of a pair, which is also `start` of the robot's next, is where the arm is first folded after the release; `carry`
//! the same after the grasp; `at_pick` and `at_place` are where the base has come to stand until the mode's event, but not
//! before the arm was folded. (Folded: `home` empty-handed, `carry` holding.)

use contract::Move;
use model::Robot;

/// How far (m, rad) two coordinates may be apart and still count as equal.
const EQUAL: f64 = 1e-9;

/// Whether two values of a coordinate are equal; unbounded ones up to whole turns.
fn coordinate_equals(robot: &Robot, i: usize, a: f64, b: f64) -> bool {
    let turn = std::f64::consts::TAU;
    let endless = robot.coordinates[i].lower == f64::NEG_INFINITY && !robot.coordinates[i].upper.is_finite();
    let apart = if endless { (a - b) - turn * ((a - b) / turn).round() } else { a - b };
    apart.abs() <= EQUAL
}

/// Whether two configurations are the same up to whole turns of unbounded coordinates.
pub(crate) fn same_configuration(robot: &Robot, a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && (0..a.len()).all(|i| coordinate_equals(robot, i, a[i], b[i]))
}

/// Whether the base stands at the same place; always for a fixed base.
pub(crate) fn same_stand(robot: &Robot, a: &[f64], b: &[f64]) -> bool {
    (0..robot.base_len()).all(|i| coordinate_equals(robot, i, a[i], b[i]))
}

/// Whether the arm is as the robot drives.
pub(crate) fn is_folded(robot: &Robot, holding: bool, q: &[f64]) -> bool {
    let arm = if holding { &robot.carry } else { &robot.home };
    let base = robot.base_len();
    arm.iter().enumerate().all(|(i, folded)| coordinate_equals(robot, base + i, q[base + i], *folded))
}

/// How many leading moves of a mode that begins with an event bring the arm home; a leading stand (the hand's pause)
/// belongs to them. `None` if the arm is never folded.
pub(crate) fn retract_len(robot: &Robot, holding: bool, moves: &[Move]) -> Option<usize> {
    let first = moves.first()?;
    let pause = usize::from(first.from == first.to);
    if pause == 0 && is_folded(robot, holding, &first.from) {
        return Some(0);
    }
    (pause.max(1)..=moves.len()).find(|k| is_folded(robot, holding, &moves[k - 1].to))
}

/// How many leading moves bring the base to where it stands until the end; 0 if it never moves.
pub(crate) fn arrival_len(robot: &Robot, moves: &[Move]) -> usize {
    moves.iter().rposition(|step| !same_stand(robot, &step.from, &step.to)).map_or(0, |last| last + 1)
}

/// Time at the end of the first `len` moves (s); `begins_s` if there are none.
pub(crate) fn end_of(moves: &[Move], len: usize, begins_s: f64) -> f64 {
    len.checked_sub(1).and_then(|last| moves.get(last)).map_or(begins_s, |step| step.ends_s)
}
