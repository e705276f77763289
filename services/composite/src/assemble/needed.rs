//! Which of the discovered orderings a plan needs.
//!
//! The search adds orderings one by one, as roadmaps force them; what it decides later may make an earlier one superfluous.
//! Arcs keep every delayed execution safe, whether an ordering is listed or not.

use contract::{Assignment, DiscoveredOrder, Interrupted};
use model::Point;
use plan::Cause;
use skeleton::Event;

use super::pose_of;
use crate::timeline::motion_of;
use crate::{Scene, Timeline};

/// The assignment with only those orders that neither follow from the others nor keep an object out of the way of a robot
/// that does not come near it.
pub(crate) fn needed(scene: &Scene, assignment: &Assignment, timeline: &Timeline) -> Result<Assignment, Interrupted> {
    let mut needed = assignment.clone();
    needed.orders = Vec::new();
    for order in &assignment.orders {
        if comes_near(scene, assignment, timeline, order)? {
            needed.orders.push(order.clone());
        }
    }
    for index in (0..needed.orders.len()).rev() {
        if follows(scene, &needed, index)? {
            needed.orders.remove(index);
        }
    }
    Ok(needed)
}

/// Whether an order follows from the given ones and the others.
fn follows(scene: &Scene, assignment: &Assignment, index: usize) -> Result<bool, Interrupted> {
    let mut others = assignment.clone();
    let order = others.orders.remove(index);
    Ok(scene.graph(&others)?.precedes(order.before, order.after))
}

/// Whether the robot that an order keeps an object out of the way of comes near where that object stands. Two poses that
/// exclude one another do so whatever moves.
fn comes_near(
    scene: &Scene,
    assignment: &Assignment,
    timeline: &Timeline,
    order: &DiscoveredOrder,
) -> Result<bool, Interrupted> {
    let Cause::NoPath { pair, robot, .. } = &order.cause else { return Ok(true) };
    let owner = |event: Event| scene.problem().pair(event.pair).robot;
    let is_obstructed = |event: Event| scene.problem().robot(owner(event)).name == *robot;
    let (own, pose) = match (order.before, order.after) {
        (own, release) if release.point == Point::Release && is_obstructed(own) => (own, release),
        (grasp, own) if grasp.point == Point::Grasp && is_obstructed(own) => (own, grasp),
        _ => return Ok(true),
    };
    let standing = pose_of(scene, assignment, pose)?;
    let commitment = timeline.robot(owner(own)).commitments.get(step_of(scene, own, pair.is_none()));
    Ok(commitment.is_none_or(|commitment| {
        let motion = |step| motion_of(owner(own), commitment.holding, step);
        commitment.moves.iter().any(|step| scene.conflicts.geometry().motion_hits(&motion(step), &standing).is_some())
    }))
}

/// The mode whose way an order with this point keeps free: `carry` is the end of a transit's way, `done` of a transfer's.
fn step_of(scene: &Scene, own: Event, returns: bool) -> usize {
    let mut pairs = scene.problem().pairs_of_robot(scene.problem().pair(own.pair).robot);
    let position = pairs.position(|pair| pair == own.pair).unwrap_or(0);
    match own.point {
        _ if returns => 2 * position + 2,
        Point::Start | Point::AtPick | Point::Grasp | Point::Carry => 2 * position,
        Point::AtPlace | Point::Release | Point::Done => 2 * position + 1,
    }
}
