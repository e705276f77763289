//! From paths to moves.

use contract::{EdgeKind, Move};
use model::{AllowedContacts, Configuration};

use crate::sipp::{ModeGraph, Step};

/// Moves under construction: where the robot is, and when.
#[derive(Clone)]
pub(crate) struct Mover {
    pub moves: Vec<Move>,
    pub at: Configuration,
    pub time_s: f64,
}

impl Mover {
    pub fn new(at: Configuration, time_s: f64) -> Self {
        Self { moves: Vec::new(), at, time_s }
    }

    /// Stands until a time (s); nothing if that is now.
    pub fn stand(&mut self, until_s: f64, kind: EdgeKind, allowed: AllowedContacts) {
        if until_s > self.time_s {
            let (from, to) = (self.at.clone(), self.at.clone());
            self.moves.push(Move { from, to, begins_s: self.time_s, ends_s: until_s, kind, allowed });
            self.time_s = until_s;
        }
    }

    /// Follows a path, waiting where it says. Unbounded coordinates go on from where they are.
    pub fn follow(&mut self, graph: &ModeGraph<'_>, path: &[Step]) {
        for step in path {
            let edge = &graph.roadmap.edges[step.hop.edge];
            let from = if step.hop.forward { edge.a } else { edge.b };
            self.stand(step.departs_s, edge.kind, graph.allowed_at(from));
            let motion = graph.motion(step.hop.edge);
            let (begin, end) = if step.hop.forward { (&motion.from, &motion.to) } else { (&motion.to, &motion.from) };
            let vertex = graph.vertex(step.hop.to);
            let to: Configuration = (0..self.at.len())
                .map(|i| {
                    let bounded = graph.robot.coordinates[i].upper.is_finite();
                    if bounded { vertex[i] } else { self.at[i] + (end[i] - begin[i]) }
                })
                .collect();
            let (kind, allowed) = (edge.kind, edge.allowed);
            let from = std::mem::replace(&mut self.at, to.clone());
            self.moves.push(Move { from, to, begins_s: step.departs_s, ends_s: step.arrives_s, kind, allowed });
            self.time_s = step.arrives_s;
        }
    }

    /// Notes what the robot may touch where it stands for ever, if that is anything.
    pub fn rest(&mut self, kind: EdgeKind, allowed: AllowedContacts) {
        if allowed != AllowedContacts::default() {
            let (from, to, time_s) = (self.at.clone(), self.at.clone(), self.time_s);
            self.moves.push(Move { from, to, begins_s: time_s, ends_s: time_s, kind, allowed });
        }
    }
}
