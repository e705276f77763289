//! One mode's glued roadmap as adjacency lists, with a dense number for every motion on it.

use std::borrow::Cow;
use std::collections::BTreeMap;

use contract::{EdgeKind, Interrupted, ModeRoadmap, Move, VertexId};
use model::{AllowedContacts, Holding, Robot, RobotId};
use skeleton::{ModeId, Occupancy};

use super::validity::{RobotEdge, TimedEdge};

/// Least time that an edge is given (s), should its ends be one configuration up to whole turns.
const LEAST_DURATION_S: f64 = 1e-6;

/// A way from one vertex to a neighbour.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Arc {
    pub to: VertexId,
    /// Index into `ModeRoadmap::edges`.
    pub edge: u32,
    pub kind: EdgeKind,
    /// Least time (s).
    pub duration_s: f64,
    /// Occupancies (numbers of the composite roadmap) that block it, ascending.
    pub blockers: Vec<u32>,
    /// Number of this motion among all motions of all robots.
    pub motion: u32,
}

/// Numbers of motions by content: a robot's equal motions in different modes are one.
#[derive(Debug, Default)]
pub(super) struct MotionNumbers(BTreeMap<(RobotId, Option<Holding>, AllowedContacts, Vec<u64>), u32>);

impl MotionNumbers {
    fn number(&mut self, motion: &TimedEdge) -> u32 {
        let Move { from, to, ends_s, allowed, .. } = &motion.travel;
        let bits = from.iter().chain(to).chain([ends_s]).map(|x| x.to_bits()).collect();
        let next = self.0.len() as u32;
        *self.0.entry((motion.edge.mode.robot, motion.holding, *allowed, bits)).or_insert(next)
    }
}

/// A mode's roadmap, usable both ways.
#[derive(Clone, Debug)]
pub(super) struct ModeGraph<'a> {
    pub roadmap: Cow<'a, ModeRoadmap>,
    /// `arcs[vertex]`, in order of edges.
    pub arcs: Vec<Vec<Arc>>,
    /// What a robot that stands at a vertex may touch: no more than on any edge that ends there.
    standing: Vec<AllowedContacts>,
    /// Number of standing at each vertex among all motions of all robots.
    pub stands: Vec<u32>,
}

impl<'a> ModeGraph<'a> {
    /// Checks a roadmap and numbers its motions. `occupancies` is sorted.
    pub fn new(
        roadmap: Cow<'a, ModeRoadmap>,
        robot: &Robot,
        occupancies: &[Occupancy],
        numbers: &mut MotionNumbers,
    ) -> Result<Self, Interrupted> {
        check(&roadmap, robot)?;
        let number = |possible: &u32| {
            let occupancy = roadmap.possible.get(*possible as usize)?;
            occupancies.binary_search(occupancy).ok().and_then(|n| u32::try_from(n).ok())
        };
        let mut arcs: Vec<Vec<Arc>> = vec![Vec::new(); roadmap.vertices.len()];
        for (index, edge) in (0_u32..).zip(&roadmap.edges) {
            let blockers: Option<Vec<u32>> = edge.blockers.iter().map(number).collect();
            let mut blockers =
                blockers.ok_or_else(|| unfit(roadmap.mode, "an edge is blocked by no pose of the problem"))?;
            blockers.sort_unstable();
            for (from, to) in [(edge.a, edge.b), (edge.b, edge.a)] {
                let (kind, blockers) = (edge.kind, blockers.clone());
                let duration_s = edge.duration_s.max(LEAST_DURATION_S);
                arcs[from.index()].push(Arc { to, edge: index, kind, duration_s, blockers, motion: 0 });
            }
        }
        let standing = (0..roadmap.vertices.len()).map(|v| standing_contacts(&roadmap, &arcs[v])).collect();
        let mut graph = Self { roadmap, arcs, standing, stands: Vec::new() };
        for v in 0..graph.arcs.len() {
            graph.stands.push(numbers.number(&graph.timed_stand(VertexId::at(v))));
            for i in 0..graph.arcs[v].len() {
                graph.arcs[v][i].motion = numbers.number(&graph.timed_arc(robot, VertexId::at(v), &graph.arcs[v][i]));
            }
        }
        Ok(graph)
    }

    /// Standing at a vertex, as motion.
    pub fn timed_stand(&self, vertex: VertexId) -> TimedEdge {
        let at = &self.roadmap.vertices[vertex.index()];
        let allowed = self.standing[vertex.index()];
        let kind = self.arcs[vertex.index()].first().map_or(EdgeKind::Base, |arc| arc.kind);
        TimedEdge {
            edge: RobotEdge { mode: self.roadmap.mode, edge: None, from: vertex, to: vertex },
            holding: self.roadmap.holding,
            travel: Move { from: at.clone(), to: at.clone(), begins_s: 0.0, ends_s: 0.0, kind, allowed },
        }
    }

    /// Travelling an arc from `from`, as motion.
    pub fn timed_arc(&self, robot: &Robot, from: VertexId, arc: &Arc) -> TimedEdge {
        let begin = &self.roadmap.vertices[from.index()];
        let end = robot.short_way(begin, &self.roadmap.vertices[arc.to.index()]);
        let allowed = self.roadmap.edges[arc.edge as usize].allowed;
        TimedEdge {
            edge: RobotEdge { mode: self.roadmap.mode, edge: Some(arc.edge), from, to: arc.to },
            holding: self.roadmap.holding,
            travel: Move {
                from: begin.clone(),
                to: end,
                begins_s: 0.0,
                ends_s: arc.duration_s,
                kind: arc.kind,
                allowed,
            },
        }
    }

    /// Least times (s) to `goal` along arcs whose cost is finite, over usable vertices.
    pub fn times_to(&self, goal: VertexId, usable: &[bool], cost: impl Fn(&Arc) -> f64) -> Vec<f64> {
        let mut times = vec![f64::INFINITY; self.arcs.len()];
        let mut queue = std::collections::BinaryHeap::new();
        times[goal.index()] = 0.0;
        queue.push(super::queue::Entry::new(0.0, goal.0));
        while let Some(entry) = queue.pop() {
            let (time, vertex) = (entry.key, entry.item as usize);
            if time > times[vertex] {
                continue;
            }
            // Every edge is an arc both ways, with equal durations and blockers.
            for arc in &self.arcs[vertex] {
                let longer = time + cost(arc);
                let to = arc.to.index();
                if usable[to] && longer < times[to] {
                    times[to] = longer;
                    queue.push(super::queue::Entry::new(longer, arc.to.0));
                }
            }
        }
        times
    }
}

fn unfit(mode: ModeId, what: &str) -> Interrupted {
    Interrupted::Unfit(format!("roadmap of mode {} of robot {}: {what}", mode.step, mode.robot.0))
}

/// Refuses a roadmap that would lead out of range.
fn check(roadmap: &ModeRoadmap, robot: &Robot) -> Result<(), Interrupted> {
    let vertices = roadmap.vertices.len();
    let inside = |vertex: VertexId| vertex.index() < vertices;
    let dimensions = robot.coordinates.len();
    if !inside(roadmap.start) || !inside(roadmap.goal) {
        return Err(unfit(roadmap.mode, "start or goal is no vertex"));
    }
    if roadmap.vertices.iter().any(|q| q.len() != dimensions || q.iter().any(|x| !x.is_finite())) {
        return Err(unfit(roadmap.mode, "a vertex is no configuration of the robot"));
    }
    if roadmap.edges.iter().any(|edge| !inside(edge.a) || !inside(edge.b)) {
        return Err(unfit(roadmap.mode, "an edge ends at no vertex"));
    }
    let too_fast = |edge: &contract::Edge| {
        let (a, b) = (&roadmap.vertices[edge.a.index()], &roadmap.vertices[edge.b.index()]);
        let least_s = robot.duration(a, &robot.short_way(a, b));
        !(edge.duration_s.is_finite() && edge.duration_s >= least_s * (1.0 - 1e-9))
    };
    if roadmap.edges.iter().any(too_fast) {
        return Err(unfit(roadmap.mode, "an edge is faster than the robot"));
    }
    Ok(())
}

/// Standing at a vertex is proven by every edge that ends there, so it needs none of the contacts that one of them lacks.
fn standing_contacts(roadmap: &ModeRoadmap, arcs: &[Arc]) -> AllowedContacts {
    let mut every = arcs.iter().map(|arc| roadmap.edges[arc.edge as usize].allowed);
    let first = every.next().unwrap_or_default();
    every.fold(first, |so_far, allowed| AllowedContacts {
        touch: so_far.touch.filter(|_| so_far.touch == allowed.touch),
        support: so_far.support.filter(|_| so_far.support == allowed.support),
    })
}
