//! From rounds to commitments.

use contract::{Commitment, EdgeKind};

use super::rounds::Round;
use super::team::Team;
use crate::commit::Mover;

/// The commitments of all rounds, one round after the other, and when the last is over (s). A round begins exactly when the
/// last pause of the one before it is over, however sums of times are rounded.
pub(super) fn commitments(team: &Team<'_>, rounds: &[Round]) -> (Vec<Commitment>, f64) {
    let robots = &team.scene.problem().robots;
    let mut last: Vec<Option<Commitment>> = vec![None; robots.len()];
    let (mut commitments, mut begins_s) = (Vec::new(), 0.0);
    let pause_s = team.scene.problem().settings.grip_time;
    for round in rounds {
        let mut ends_s: f64 = begins_s;
        for unit in &round.units {
            let robot = unit.mode.robot.index();
            let Some(mode) = team.modes[robot].get(unit.mode.step as usize) else { continue };
            let mut mover = Mover::new(robots[robot].start.clone(), 0.0);
            if let Some(before) = &last[robot] {
                let at = before.moves.last().map_or_else(|| robots[robot].start.clone(), |step| step.to.clone());
                mover = Mover::new(at, before.event_s);
                mover.stand(before.event_s + pause_s, EdgeKind::Arm, mode.graph.allowed_at(mode.graph.roadmap.start));
            }
            let mut commitment = mode.commitment(unit, begins_s, mover);
            let next = team.modes[robot].get(unit.mode.step as usize + 1);
            commitment.tail_holding = next.map_or(commitment.holding, |next| next.graph.roadmap.holding);
            ends_s = ends_s.max(commitment.event_s + mode.pause_s);
            last[robot] = Some(commitment.clone());
            commitments.push(commitment);
        }
        begins_s = ends_s;
    }
    (commitments, begins_s)
}
