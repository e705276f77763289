//! The search's questions answered by the stage's conflict relation.

use collision::Motion;
use contract::Assignment;
use model::Standing;
use skeleton::Occupancy;

use super::validity::{CompositeValidity, TimedEdge};
use crate::{Conflicts, TimedMotion};

/// The conflict relation, and where objects stand.
pub(crate) struct Geometric<'a> {
    pub conflicts: &'a Conflicts,
    pub assignment: &'a Assignment,
}

impl CompositeValidity for Geometric<'_> {
    fn edges_conflict(&self, a: &TimedEdge, b: &TimedEdge) -> bool {
        let ends_s = a.travel.ends_s.max(b.travel.ends_s).max(1.0);
        let (a, b) = (until(a, ends_s), until(b, ends_s));
        a.iter().any(|a| b.iter().any(|b| self.conflicts.moves_conflict(a, b)))
    }

    fn stand_hits(&self, stand: &TimedEdge, occupancy: Occupancy) -> bool {
        let Occupancy { object, hop } = occupancy;
        let pose = self.assignment.poses.get(object.index()).and_then(|hops| hops.get(hop as usize));
        // A pose that is not assigned is nowhere free.
        pose.is_none_or(|pose| {
            self.conflicts.motion_hits(&motion(stand), &Standing { object, world_from_object: *pose })
        })
    }
}

fn motion(edge: &TimedEdge) -> Motion {
    Motion {
        robot: edge.edge.mode.robot,
        holding: edge.holding,
        from: edge.travel.from.clone(),
        to: edge.travel.to.clone(),
        allowed: edge.travel.allowed,
    }
}

/// Travel, if any, then standing at its end until `ends_s`.
fn until(edge: &TimedEdge, ends_s: f64) -> Vec<TimedMotion> {
    let motion = motion(edge);
    let stands = Motion { from: motion.to.clone(), ..motion.clone() };
    let arrives_s = edge.travel.ends_s;
    let mut motions = vec![TimedMotion { motion: stands, begins_s: arrives_s, ends_s }];
    if arrives_s > 0.0 {
        motions.push(TimedMotion { motion, begins_s: 0.0, ends_s: arrives_s });
    }
    motions
}
