//! The hand's straight way on from where its short one ends: out of a cabinet, from between walls.

use collision::Geometry;
use contract::{Interrupted, JobContext, PieceJob};
use kinematics::{ArmSolver, link_pose};
use model::Configuration;
use nalgebra::Translation3;

use crate::arm::contact;

/// Greatest length of the way (m).
const LENGTH: f64 = 0.6;
/// Length of its steps (m).
const STEP: f64 = 0.04;
/// Greatest change of a joint (rad or m) from step to step.
const GREATEST_STEP: f64 = 0.5;

/// Configurations from the last of `near` on, in the direction of its last motion, as far as the hand comes and the motions
/// are free. The last of `near` comes first; it is the only one if `near` shows no direction.
pub(crate) fn retreat(
    geometry: &Geometry,
    solver: &ArmSolver,
    job: &PieceJob,
    near: &[Configuration],
    context: &mut JobContext<'_>,
) -> Result<Vec<Configuration>, Interrupted> {
    let robot = geometry.problem().robot(job.robot);
    let hand = |q: &Configuration| link_pose(robot, q, robot.end_effector.parent_link);
    let mut way = vec![near[near.len() - 1].clone()];
    let Some(before) = near.len().checked_sub(2).map(|before| hand(&near[before])) else { return Ok(way) };
    let end = hand(&way[0]);
    let Some(direction) = (end.translation.vector - before.translation.vector).try_normalize(1e-6) else {
        return Ok(way);
    };
    let stand = way[0][..robot.base_len()].to_vec();
    while (way.len() as f64) * STEP <= LENGTH && context.spend(1)? {
        let last = &way[way.len() - 1];
        let target = Translation3::from(direction * (way.len() as f64 * STEP)) * end;
        let Some(arm) = solver.follow(robot, &stand, &target, &last[stand.len()..], GREATEST_STEP) else { break };
        let next = [stand.as_slice(), &arm].concat();
        if contact(geometry, job, last, &next, model::AllowedContacts::default()).is_some() {
            break;
        }
        way.push(next);
    }
    Ok(way)
}
