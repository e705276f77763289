//! When a plan passes the points of its pairs.

use model::Point;
use plan::{EventKind, Plan, RobotTrajectory, SegmentKind};

/// Time of a pair's point (s), by the plan's own segments and events; `None` where it has no such point.
#[must_use]
pub fn point_time(plan: &Plan, pair: &str, point: Point) -> Option<f64> {
    let event = |kind: EventKind| plan.events.iter().find(|event| event.pair == pair && event.kind == kind);
    let (attach, detach) = (event(EventKind::Attach)?, event(EventKind::Detach)?);
    let robot = plan.robots.iter().find(|robot| robot.name == attach.robot)?;
    let start = robot.segments.iter().find(|segment| segment.pair.as_deref() == Some(pair)).map(|segment| segment.from);
    let start = previous_done(robot, pair).or(start);
    let carry = last_retract(robot, pair, attach.knot, detach.knot);
    let knot = match point {
        Point::Grasp => Some(attach.knot),
        Point::Release => Some(detach.knot),
        Point::Start => start,
        Point::Carry => carry,
        Point::Done => last_retract(robot, pair, detach.knot, usize::MAX),
        Point::AtPick => last_drive(robot, attach.knot).max(start),
        Point::AtPlace => last_drive(robot, detach.knot).max(carry).max(Some(attach.knot)),
    };
    robot.knots.get(knot?).map(|knot| knot.t)
}

/// The end of the retract of the pair before `pair`, which may be said to belong to either.
fn previous_done(robot: &RobotTrajectory, pair: &str) -> Option<usize> {
    let first = robot.segments.iter().position(|segment| segment.pair.as_deref() == Some(pair))?;
    let before = robot.segments[..first].iter().rev().find_map(|segment| segment.pair.as_deref())?;
    last_retract(robot, before, 0, usize::MAX)
}

fn last_retract(robot: &RobotTrajectory, pair: &str, from: usize, to: usize) -> Option<usize> {
    let mut segments = robot.segments.iter().filter(|segment| segment.pair.as_deref() == Some(pair));
    segments
        .rfind(|segment| segment.kind == SegmentKind::Retract && segment.from >= from && segment.to <= to)
        .map(|segment| segment.to)
}

/// The end of the last drive that is over by a knot.
fn last_drive(robot: &RobotTrajectory, knot: usize) -> Option<usize> {
    let drives = robot.segments.iter().filter(|segment| segment.kind == SegmentKind::Base && segment.to <= knot);
    drives.map(|segment| segment.to).max()
}
