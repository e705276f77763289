//! Gluing pieces to the reversible roadmap of a mode.

use std::ops::Range;

use collision::Motion;
use contract::{
    Digest, Edge, EdgeKind, Interrupted, JobContext, ModeJob, ModeRoadmap, Product, ProductRef, RoadmapPiece, VertexId,
};
use model::{AllowedContacts, Configuration, Robot};

use crate::RoadmapStage;
use crate::base::{NEIGHBOURS, folded};
use crate::connect::{nearest, straight_edge};
use crate::graph::{cost_to_go, least_blockers};
use crate::no_way::NoWay;

/// Neighbours that a stand is connected to.
const STAND_NEIGHBOURS: usize = 2 * NEIGHBOURS;

pub(crate) struct Glued {
    pub(crate) roadmap: ModeRoadmap,
    pub(crate) shortest_s: f64,
    pub(crate) in_the_way: Vec<u32>,
}

/// Vertices and edges so far.
pub(crate) struct Glue<'a> {
    pub(crate) stage: &'a RoadmapStage,
    pub(crate) robot: &'a Robot,
    pub(crate) job: &'a ModeJob,
    pub(crate) vertices: Vec<Configuration>,
    pub(crate) edges: Vec<Edge>,
    /// Edges by what they come from, each part with the digest of its motions.
    parts: Vec<(Digest, Range<usize>)>,
}

/// The glued roadmap, or why the goal cannot be reached.
pub(crate) fn glue(
    stage: &RoadmapStage,
    job: &ModeJob,
    context: &mut JobContext<'_>,
) -> Result<Result<Glued, NoWay>, Interrupted> {
    let robot = stage.geometry.problem().robot(job.mode.robot);
    let mut glue = Glue { stage, robot, job, vertices: Vec::new(), edges: Vec::new(), parts: Vec::new() };
    if let Some(base) = &job.base {
        let piece = glue.piece(base, context)?;
        glue.append(base.digest, piece);
    }
    let (start, start_stand) = glue.end(&job.start, job.start_arm.as_ref(), context)?;
    let (goal, goal_stand) = glue.end(&job.goal, job.goal_arm.as_ref(), context)?;
    let of_pieces = glue.edges.len();
    if robot.base.is_some() {
        glue.connect_stand(start_stand, context)?;
        glue.connect_stand(goal_stand, context)?;
    }
    let connections = of_pieces..glue.edges.len();
    let digest = Digest::of("mrtamp connections", &[&contract::encode_canonical(&glue.ends_of(&connections))]);
    glue.parts.push((digest, connections));
    glue.annotate(context)?;
    Ok(glue.finish([start, goal], [start_stand, goal_stand]))
}

impl Glue<'_> {
    fn piece(&self, wanted: &ProductRef, context: &JobContext<'_>) -> Result<RoadmapPiece, Interrupted> {
        let dimensions = self.robot.coordinates.len();
        match context.product(wanted)? {
            Product::Piece(piece)
                if piece.robot == self.job.mode.robot
                    && piece.holding == self.job.holding
                    && piece.vertices.iter().all(|q| q.len() == dimensions)
                    && piece.edges.iter().all(|e| e.a.index().max(e.b.index()) < piece.vertices.len()) =>
            {
                Ok(piece)
            }
            _ => Err(Interrupted::Unfit(format!("product {:?} is no piece of this robot and load", wanted.digest))),
        }
    }

    /// Index of a vertex with exactly this configuration, added if it is new.
    fn vertex(&mut self, q: &[f64]) -> usize {
        let known = self.vertices.iter().position(|v| v.as_slice() == q);
        known.unwrap_or_else(|| {
            self.vertices.push(q.to_vec());
            self.vertices.len() - 1
        })
    }

    fn append(&mut self, digest: Digest, piece: RoadmapPiece) {
        self.parts.push((digest, self.edges.len()..self.edges.len() + piece.edges.len()));
        let places: Vec<usize> = piece.vertices.iter().map(|q| self.vertex(q)).collect();
        for mut edge in piece.edges {
            edge.a = VertexId::at(places[edge.a.index()]);
            edge.b = VertexId::at(places[edge.b.index()]);
            self.edges.push(edge);
        }
    }

    /// One end of the mode: its vertex, and the vertex with the folded arm at its stand.
    fn end(
        &mut self,
        q: &Configuration,
        arm: Option<&ProductRef>,
        context: &JobContext<'_>,
    ) -> Result<(usize, usize), Interrupted> {
        if q.len() != self.robot.coordinates.len() {
            return Err(Interrupted::Unfit("configurations of another robot".to_owned()));
        }
        let Some(arm) = arm else {
            let vertex = self.vertex(q);
            return Ok((vertex, vertex));
        };
        let piece = self.piece(arm, context)?;
        let stand: Configuration =
            [&q[..self.robot.base_len()], folded(self.robot, self.job.holding.is_some())].concat();
        if !piece.vertices.contains(q) || !piece.vertices.contains(&stand) {
            return Err(Interrupted::Unfit("the arm piece does not end where the mode does".to_owned()));
        }
        self.append(arm.digest, piece);
        Ok((self.vertex(q), self.vertex(&stand)))
    }

    /// Connects a stand to the base roadmap and to the other stand.
    fn connect_stand(&mut self, stand: usize, context: &mut JobContext<'_>) -> Result<(), Interrupted> {
        let from = self.vertices[stand].clone();
        let arm = self.robot.base_len();
        let drives: Vec<usize> =
            (0..self.vertices.len()).filter(|v| *v != stand && self.vertices[*v][arm..] == from[arm..]).collect();
        let candidates: Vec<Configuration> = drives.iter().map(|v| self.vertices[*v].clone()).collect();
        for neighbour in nearest(self.robot, &candidates, &from, STAND_NEIGHBOURS) {
            context.spend(1)?;
            let vertex = drives[neighbour.vertex];
            let joined = |e: &Edge| [(stand, vertex), (vertex, stand)].contains(&(e.a.index(), e.b.index()));
            if self.edges.iter().any(joined) {
                continue;
            }
            let allowed = AllowedContacts::default();
            let motion = self.motion(stand, vertex, allowed);
            if self.stage.is_free(&motion) {
                self.edges.push(straight_edge(self.robot, &self.vertices, stand, vertex, EdgeKind::Base, allowed));
            }
        }
        Ok(())
    }

    fn motion(&self, a: usize, b: usize, allowed: AllowedContacts) -> Motion {
        let from = self.vertices[a].clone();
        let to = self.robot.short_way(&from, &self.vertices[b]);
        Motion { robot: self.job.mode.robot, holding: self.job.holding, from, to, allowed }
    }

    /// What a list of motions without a piece depends on.
    #[allow(clippy::type_complexity, reason = "it is only encoded")]
    fn ends_of(&self, edges: &Range<usize>) -> (model::RobotId, Option<model::Holding>, Vec<[&Configuration; 2]>) {
        let ends = self.edges[edges.clone()].iter().map(|e| [e.a, e.b].map(|v| &self.vertices[v.index()]));
        (self.job.mode.robot, self.job.holding, ends.collect())
    }

    /// Marks every edge with the standing objects that block it: possible ones by their index, certain ones after them.
    fn annotate(&mut self, context: &mut JobContext<'_>) -> Result<(), Interrupted> {
        for (digest, edges) in self.parts.clone() {
            // What the memo knows already costs the same work, for work is part of the answer.
            edges.clone().try_for_each(|_| context.spend(1).map(|_| ()))?;
            let motions = || edges.clone().map(|i| self.motion_of(&self.edges[i])).collect();
            let all = self.job.possible.iter().chain(&self.job.certain);
            let blocked: Vec<_> = all
                .map(|obstruction| {
                    let stage = self.stage;
                    stage.blocked.by(&stage.geometry, digest, &motions, &obstruction.standing)
                })
                .collect();
            for (index, blocked) in (0_u32..).zip(&blocked) {
                blocked.iter().for_each(|i| self.edges[edges.start + i].blockers.push(index));
            }
        }
        Ok(())
    }

    fn motion_of(&self, edge: &Edge) -> Motion {
        self.motion(edge.a.index(), edge.b.index(), edge.allowed)
    }

    fn finish(self, [start, goal]: [usize; 2], stands: [usize; 2]) -> Result<Glued, NoWay> {
        let start_stand = stands[0];
        let certain_from = self.job.possible.len() as u32;
        let free: Vec<Edge> =
            self.edges.iter().filter(|edge| edge.blockers.iter().all(|b| *b < certain_from)).cloned().collect();
        let cost_to_go_s = cost_to_go(self.vertices.len(), &free, goal);
        let shortest_s = cost_to_go_s[start];
        if !shortest_s.is_finite() {
            return Err(self.no_way([start, goal], stands, &free));
        }
        // The way off the object that was just placed or grasped is free when the mode begins; the way to the goal counts.
        let in_the_way = least_blockers(self.vertices.len(), &free, start_stand, goal).unwrap_or_default();
        let roadmap = ModeRoadmap {
            mode: self.job.mode,
            holding: self.job.holding,
            edges: free,
            start: VertexId::at(start),
            goal: VertexId::at(goal),
            parking: self.parking(start_stand),
            possible: self.job.possible.iter().map(|obstruction| obstruction.occupancy).collect(),
            cost_to_go_s,
            vertices: self.vertices,
        };
        Ok(Glued { roadmap, shortest_s, in_the_way: in_the_way.into_iter().collect() })
    }

    /// The start stand, then where the robot stands now with its arm folded.
    fn parking(&self, start_stand: usize) -> Vec<VertexId> {
        let home: Configuration =
            [&self.robot.start[..self.robot.base_len()], folded(self.robot, self.job.holding.is_some())].concat();
        let mut parking: Vec<usize> = self.vertices.iter().position(|v| *v == home).into_iter().collect();
        if !parking.contains(&start_stand) {
            parking.push(start_stand);
        }
        parking.into_iter().map(VertexId::at).collect()
    }
}

impl RoadmapStage {
    /// Whether a motion keeps clear of the robot itself and of fixed objects; remembered.
    fn is_free(&self, motion: &Motion) -> bool {
        let key = contract::encode_canonical(&(motion.robot, motion.holding, &motion.from, &motion.to, motion.allowed));
        if let Some(free) = self.free.lock().ok().and_then(|memo| memo.get(&key).copied()) {
            return free;
        }
        let free = self.geometry.motion_contact(motion).is_none();
        if let Ok(mut memo) = self.free.lock() {
            memo.insert(key, free);
        }
        free
    }
}
