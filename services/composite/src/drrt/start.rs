//! Where and when the search begins: after a committed prefix.

use contract::{Commitment, EdgeKind, Interrupted, ModeRoadmap, Move, VertexId};
use model::{Robot, RobotId};

use super::composite_roadmap::CompositeRoadmap;
use crate::CommittedMotion;

/// How far a configuration may be from the vertex it stands for (m, rad).
const SAME: f64 = 1e-9;

/// The composite state after a prefix.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// When all robots stand at vertices (s).
    pub begins_s: f64,
    /// Each robot.
    pub robots: Vec<RobotStart>,
}

/// One robot after a prefix.
#[derive(Clone, Debug)]
pub(super) struct RobotStart {
    pub phase: u32,
    pub vertex: VertexId,
    /// What it has done since its last event, without gaps until the search begins.
    pub moves: Vec<Move>,
    /// When that event was (0 s: none yet), and how long the robot has to rest after it (s).
    pub since_s: f64,
    pub rest_s: f64,
    /// Whether the prefix has all its modes, the closing return too.
    pub is_done: bool,
    /// Where it stands, angles as they have turned.
    pub at: Vec<f64>,
}

impl Start {
    /// Every robot goes on with the tail of its last commitment until all of them stand at a vertex after the last event.
    ///
    /// # Errors
    /// [`Interrupted::Unfit`]: a tail that is not on the roadmap of the robot's next mode.
    pub fn after(done: &CommittedMotion, roadmap: &CompositeRoadmap<'_>) -> Result<Self, Interrupted> {
        let mut begins_s = rested_s(done, roadmap);
        let tails = || ids(roadmap).flat_map(|robot| done.tail(robot));
        while let Some(travel) = tails().find(|m| m.from != m.to && m.begins_s < begins_s && begins_s < m.ends_s) {
            begins_s = travel.ends_s;
        }
        Self::at(begins_s, done, roadmap)
    }

    /// Every robot is where its tail ends.
    ///
    /// # Errors
    /// As for [`Start::after`].
    pub fn at_rest(done: &CommittedMotion, roadmap: &CompositeRoadmap<'_>) -> Result<Self, Interrupted> {
        let ends_s = ids(roadmap).filter_map(|robot| done.tail(robot).last()).map(|last| last.ends_s);
        Self::at(ends_s.fold(rested_s(done, roadmap), f64::max), done, roadmap)
    }

    fn at(begins_s: f64, done: &CommittedMotion, roadmap: &CompositeRoadmap<'_>) -> Result<Self, Interrupted> {
        let robots = ids(roadmap).map(|robot| robot_start(roadmap, robot, done, begins_s)).collect::<Result<_, _>>()?;
        Ok(Self { begins_s, robots })
    }
}

fn ids(roadmap: &CompositeRoadmap<'_>) -> impl Iterator<Item = RobotId> {
    (0..roadmap.robots.len()).map(RobotId::at)
}

/// When the last hand has rested after its event (s).
fn rested_s(done: &CommittedMotion, roadmap: &CompositeRoadmap<'_>) -> f64 {
    let last = ids(roadmap).filter_map(|robot| done.last(robot));
    last.map(|last| last.event_s + rest_after(roadmap, last)).fold(0.0, f64::max)
}

/// How long a robot has to rest after a commitment (s).
fn rest_after(roadmap: &CompositeRoadmap<'_>, last: &Commitment) -> f64 {
    let phases = &roadmap.robots[last.mode.robot.index()].phases;
    let ending = phases.iter().rfind(|phase| phase.mode == last.mode.step as usize);
    ending.map_or(0.0, |phase| phase.rest_s)
}

fn robot_start(
    roadmap: &CompositeRoadmap<'_>,
    robot: RobotId,
    done: &CommittedMotion,
    begins_s: f64,
) -> Result<RobotStart, Interrupted> {
    let last = done.last(robot);
    let glued = &roadmap.robots[robot.index()];
    let model = &roadmap.problem.robots[robot.index()];
    let mode = last.map_or(0, |last| last.mode.step as usize + 1);
    if mode > glued.modes.len() {
        return Err(Interrupted::Unfit(format!("the prefix has a mode that {} does not have", model.name)));
    }
    let first = glued.phases.iter().position(|phase| phase.mode == mode);
    // All modes done: the robot stands where its last one ended.
    let mut phase = first.unwrap_or(glued.phases.len() - 1);
    let graph = &glued.modes[glued.phases[phase].mode];
    let mut moves: Vec<Move> = Vec::new();
    for travel in done.tail(robot) {
        if travel.begins_s < begins_s {
            moves.push(Move { ends_s: travel.ends_s.min(begins_s), ..travel.clone() });
        }
    }
    let since = last.map_or(0.0, |last| last.event_s);
    let at = match (moves.last(), last.and_then(|last| last.moves.last())) {
        (Some(m), _) | (None, Some(m)) => m.to.clone(),
        (None, None) => model.start.clone(),
    };
    let expected = if first.is_some() { graph.roadmap.start } else { graph.roadmap.goal };
    let vertex = vertex_at(&graph.roadmap, expected, model, &at).ok_or_else(|| {
        Interrupted::Unfit(format!("{} stands at no vertex of its next mode after the prefix", model.name))
    })?;
    while glued.phases[phase].is_left_behind(vertex, glued.phases.get(phase + 1)) {
        phase += 1;
    }
    let stands_since = moves.last().map_or(since, |m| m.ends_s);
    if stands_since < begins_s && first.is_some() {
        let stand = graph.timed_stand(vertex).travel;
        let kind = moves.last().map_or(EdgeKind::Base, |m| m.kind);
        moves.push(Move { from: at.clone(), to: at.clone(), begins_s: stands_since, ends_s: begins_s, kind, ..stand });
    }
    let rest_s = last.map_or(0.0, |last| rest_after(roadmap, last));
    Ok(RobotStart { phase: phase as u32, vertex, at, moves, since_s: since, rest_s, is_done: first.is_none() })
}

/// The vertex with this configuration, whole turns aside; `expected` if it is one of several.
fn vertex_at(roadmap: &ModeRoadmap, expected: VertexId, robot: &Robot, q: &[f64]) -> Option<VertexId> {
    let is_same = |vertex: &VertexId| {
        let there = robot.short_way(q, &roadmap.vertices[vertex.index()]);
        there.iter().zip(q).all(|(a, b)| (a - b).abs() <= SAME)
    };
    std::iter::once(expected).chain((0..roadmap.vertices.len()).map(VertexId::at)).find(is_same)
}
