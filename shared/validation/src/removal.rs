//! Rule V10 where the problem frees places only when a removal is completed: nothing is placed where an object stood that
//! is still being carried away.

use model::Removal;

use crate::irredundant::gap;
use crate::script::Script;
use crate::timeline::{Standing, Timeline};
use crate::violation::{Rule, Violation};

/// Checks every pose against those that objects were taken from before.
pub(crate) fn check(script: &Script, timeline: &Timeline, wrong: &mut Vec<Violation>) {
    if script.problem.settings.removal == Removal::Grasp {
        return;
    }
    for left in &timeline.standings {
        let Some(hold) = left.taken_by.map(|hold| &timeline.holds[hold]) else { continue };
        let early = |taken: &&Standing| {
            taken.object != left.object
                && taken.from >= left.to
                && taken.from <= hold.to
                && gap(script, left, taken) <= 0.0
        };
        for taken in timeline.standings.iter().filter(early) {
            let [leaves, comes] = [left, taken].map(|standing| script.object_name(standing.object));
            let message =
                format!("{comes} is placed where {leaves} stood, which is released elsewhere only at {} s", hold.to);
            let robot = script.robot_name(hold.robot);
            wrong.push(Violation::new(Rule::V10, message).robot(robot).object(leaves).object(comes).at(taken.from));
        }
    }
}
