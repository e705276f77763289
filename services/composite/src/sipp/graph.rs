//! A mode's roadmap, checked and indexed.

use collision::Motion;
use contract::{Interrupted, JobContext, ModeRoadmap, Product, ProductRef, VertexId};
use model::{AllowedContacts, Configuration, Problem, Robot};
use skeleton::ModeId;

use crate::points::{is_folded, same_configuration, same_stand};
use crate::{Conflicts, Travel};

/// Least time that a motion is given (s): between two vertices that are one configuration up to whole turns.
const LEAST_DURATION_S: f64 = 1e-6;

/// One end of an edge, seen from the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hop {
    pub edge: usize,
    pub to: VertexId,
    /// Whether the edge is travelled from its `a` to its `b`.
    pub forward: bool,
}

/// A mode's roadmap with neighbours.
pub(crate) struct ModeGraph<'a> {
    pub robot: &'a Robot,
    pub roadmap: ModeRoadmap,
    neighbours: Vec<Vec<Hop>>,
}

impl<'a> ModeGraph<'a> {
    /// Reads and checks the roadmap of a mode.
    ///
    /// # Errors
    /// [`Interrupted::Lacking`]; [`Interrupted::Unfit`] if it is not of this mode or out of range.
    pub fn load(
        problem: &'a Problem,
        mode: ModeId,
        product: &ProductRef,
        context: &JobContext<'_>,
    ) -> Result<Self, Interrupted> {
        match context.product(product)? {
            Product::Mode(roadmap) if roadmap.mode == mode => {
                Self::new(problem.robot(mode.robot), roadmap).map_err(Interrupted::Unfit)
            }
            _ => Err(Interrupted::Unfit(format!("not the roadmap of mode {} of robot {}", mode.step, mode.robot.0))),
        }
    }

    /// Checks a roadmap.
    ///
    /// # Errors
    /// A sentence.
    pub fn new(robot: &'a Robot, roadmap: ModeRoadmap) -> Result<Self, String> {
        let inside = |vertex: VertexId| vertex.index() < roadmap.vertices.len();
        let is_configuration =
            |q: &Configuration| q.len() == robot.coordinates.len() && q.iter().all(|x| x.is_finite());
        if !roadmap.vertices.iter().all(is_configuration) {
            return Err("a vertex of a roadmap is no configuration of its robot".into());
        }
        let ends = roadmap.edges.iter().flat_map(|edge| [edge.a, edge.b]);
        let mut all = ends.chain(roadmap.parking.iter().copied()).chain([roadmap.start, roadmap.goal]);
        if !all.all(inside) {
            return Err("a roadmap names a vertex that is none".into());
        }
        let mut neighbours = vec![Vec::new(); roadmap.vertices.len()];
        for (index, edge) in roadmap.edges.iter().enumerate() {
            let (a, b) = (&roadmap.vertices[edge.a.index()], &roadmap.vertices[edge.b.index()]);
            let least = robot.duration(a, &robot.short_way(a, b));
            if !(edge.duration_s.is_finite() && edge.duration_s >= least * (1.0 - 1e-9)) {
                return Err("an edge of a roadmap is faster than its robot".into());
            }
            neighbours[edge.a.index()].push(Hop { edge: index, to: edge.b, forward: true });
            neighbours[edge.b.index()].push(Hop { edge: index, to: edge.a, forward: false });
        }
        Ok(Self { robot, roadmap, neighbours })
    }

    pub fn len(&self) -> usize {
        self.roadmap.vertices.len()
    }

    pub fn vertex(&self, vertex: VertexId) -> &Configuration {
        &self.roadmap.vertices[vertex.index()]
    }

    pub fn hops(&self, from: VertexId) -> &[Hop] {
        &self.neighbours[from.index()]
    }

    pub fn duration_s(&self, edge: usize) -> f64 {
        self.roadmap.edges[edge].duration_s.max(LEAST_DURATION_S)
    }

    pub fn is_folded(&self, vertex: VertexId) -> bool {
        is_folded(self.robot, self.roadmap.holding.is_some(), self.vertex(vertex))
    }

    pub fn same_stand(&self, a: VertexId, b: VertexId) -> bool {
        same_stand(self.robot, self.vertex(a), self.vertex(b))
    }

    /// The first vertex with this configuration, up to whole turns.
    pub fn vertex_at(&self, q: &[f64]) -> Option<VertexId> {
        self.roadmap.vertices.iter().position(|vertex| same_configuration(self.robot, vertex, q)).map(VertexId::at)
    }

    /// What a robot that stands at a vertex may touch: no more than on every edge that ends there.
    pub fn allowed_at(&self, vertex: VertexId) -> AllowedContacts {
        let mut all = self.hops(vertex).iter().map(|hop| self.roadmap.edges[hop.edge].allowed);
        let first = all.next().unwrap_or_default();
        all.fold(first, |so_far, other| AllowedContacts {
            touch: so_far.touch.filter(|touch| other.touch == Some(*touch)),
            support: so_far.support.filter(|support| other.support == Some(*support)),
        })
    }

    /// An edge as motion from its `a` to its `b`.
    pub fn motion(&self, edge: usize) -> Motion {
        let edge = &self.roadmap.edges[edge];
        let from = self.vertex(edge.a).clone();
        let to = self.robot.short_way(&from, self.vertex(edge.b));
        self.motion_between(from, to, edge.allowed)
    }

    /// Standing at a vertex.
    pub fn stand(&self, vertex: VertexId, conflicts: &Conflicts) -> Travel {
        let q = self.vertex(vertex).clone();
        conflicts.travel(&self.motion_between(q.clone(), q, self.allowed_at(vertex)))
    }

    fn motion_between(&self, from: Configuration, to: Configuration, allowed: AllowedContacts) -> Motion {
        Motion { robot: self.roadmap.mode.robot, holding: self.roadmap.holding, from, to, allowed }
    }

    /// Least time from every vertex to `target` (s), nobody in the way; infinite where there is no way.
    pub fn times_to(&self, target: VertexId) -> Vec<f64> {
        let mut times = vec![f64::INFINITY; self.len()];
        let mut open = std::collections::BTreeSet::from([(0_u64, target)]);
        times[target.index()] = 0.0;
        // Bits of non-negative numbers order as the numbers do.
        while let Some((bits, vertex)) = open.pop_first() {
            for hop in self.hops(vertex) {
                let time = f64::from_bits(bits) + self.duration_s(hop.edge);
                let known = &mut times[hop.to.index()];
                if time < *known {
                    open.remove(&(known.to_bits(), hop.to));
                    *known = time;
                    open.insert((time.to_bits(), hop.to));
                }
            }
        }
        times
    }
}
