//! Neighbours and edges.

use contract::{Edge, EdgeKind, VertexId};
use model::{AllowedContacts, Configuration, Robot};

/// A vertex near a configuration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Neighbour {
    /// Index of the vertex.
    pub(crate) vertex: usize,
    /// Least time of the straight motion (s).
    pub(crate) duration_s: f64,
}

/// The `count` vertices that are quickest to reach by a straight motion, quickest first; ties by index.
pub(crate) fn nearest(robot: &Robot, vertices: &[Configuration], q: &[f64], count: usize) -> Vec<Neighbour> {
    let mut all: Vec<Neighbour> = vertices
        .iter()
        .enumerate()
        .map(|(vertex, v)| Neighbour { vertex, duration_s: robot.duration(q, &robot.short_way(q, v)) })
        .collect();
    all.sort_by(|a, b| a.duration_s.total_cmp(&b.duration_s).then(a.vertex.cmp(&b.vertex)));
    all.truncate(count);
    all
}

/// An edge between two vertices, without annotations.
pub(crate) fn straight_edge(
    robot: &Robot,
    vertices: &[Configuration],
    a: usize,
    b: usize,
    kind: EdgeKind,
    allowed: AllowedContacts,
) -> Edge {
    let duration_s = robot.duration(&vertices[a], &robot.short_way(&vertices[a], &vertices[b]));
    Edge { a: VertexId::at(a), b: VertexId::at(b), kind, allowed, duration_s, blockers: Vec::new() }
}
