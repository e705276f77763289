//! Whether a schedule is free of conflicts, as the arcs presuppose.

use plan::{BodyRef, Cause};

use crate::conflict::{TIME_ROUNDING_S, apart};
use crate::timeline::RobotTimeline;
use crate::{Scene, TimedMove, Timeline};

/// The first conflict found in a timeline.
pub(crate) fn first_conflict(scene: &Scene, timeline: &Timeline) -> Option<Cause> {
    let robots = &timeline.robots;
    let body = |robot: &RobotTimeline| {
        let robot = scene.problem().robot(robot.robot);
        let link = robot.links.first().map(|link| link.name.clone()).unwrap_or_default();
        BodyRef::Link { robot: robot.name.clone(), link }
    };
    for (i, a) in robots.iter().enumerate() {
        if let Some(b) = robots[i + 1..].iter().find(|b| robots_conflict(scene, a, b)) {
            return Some(Cause::Collision { first: body(a), second: body(b) });
        }
        for (occupancy, standing) in &timeline.standings {
            let hits =
                a.moves_after(standing.from_s).iter().take_while(|step| step.begins_s < standing.until_s).any(|step| {
                    overlap(step, (standing.from_s, standing.until_s))
                        .any(|cell| scene.conflicts.cell_hits(&step.travel, cell, &standing.standing))
                });
            if hits {
                let object = scene.problem().movable[occupancy.object.index()].name.clone();
                return Some(Cause::Collision { first: body(a), second: BodyRef::Object(object) });
            }
        }
    }
    None
}

fn robots_conflict(scene: &Scene, a: &RobotTimeline, b: &RobotTimeline) -> bool {
    let mut first = 0;
    a.moves.iter().any(|step| {
        while b.moves[first].ends_s <= step.begins_s {
            first += 1;
        }
        let others = b.moves[first..].iter().take_while(|other| other.begins_s < step.ends_s);
        others
            .filter(|other| !apart(&step.travel.bounds, &other.travel.bounds))
            .any(|other| moves_conflict(scene, step, other))
    })
}

fn moves_conflict(scene: &Scene, a: &TimedMove, b: &TimedMove) -> bool {
    overlap(a, (b.begins_s, b.ends_s))
        .any(|i| overlap(b, a.cell_times(i)).any(|j| scene.conflicts.cells_conflict(&a.travel, i, &b.travel, j)))
}

/// Cells of a move that share more than an instant with a time.
fn overlap(step: &TimedMove, (from_s, until_s): (f64, f64)) -> impl Iterator<Item = u32> + '_ {
    (0..step.travel.cells).filter(move |cell| {
        let (begins_s, ends_s) = step.cell_times(*cell);
        ends_s.min(until_s) - begins_s.max(from_s) > TIME_ROUNDING_S
    })
}
