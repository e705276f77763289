//! The base roadmap: the base drives with the arm folded.

use collision::{Geometry, Motion};
use contract::{
    CauseTally, EdgeKind, Interrupted, JobContext, PieceJob, RandomStream, RoadmapPiece, StageKind, halton,
};
use model::{AllowedContacts, Configuration, Robot};

use crate::bridge::build_bridges;
use crate::connect::{nearest, straight_edge};

/// Neighbours that a new vertex is connected to.
pub(crate) const NEIGHBOURS: usize = 8;
/// Samples drawn for each vertex wanted.
const DRAWS_PER_VERTEX: u64 = 8;

/// Arm coordinates in which a robot drives.
pub(crate) fn folded(robot: &Robot, holding: bool) -> &[f64] {
    if holding { &robot.carry } else { &robot.home }
}

/// Vertex 0 is the start stand; then a Halton sequence over the base's limits with a keyed shift, free ones only; then
/// bridges between parts that are not connected.
pub(crate) fn base_piece(
    geometry: &Geometry,
    seed: u64,
    job: &PieceJob,
    context: &mut JobContext<'_>,
) -> Result<Result<RoadmapPiece, CauseTally>, Interrupted> {
    let problem = geometry.problem();
    let robot = problem.robot(job.robot);
    if robot.base.is_none() {
        return Err(Interrupted::Unfit(format!("{} has no base", robot.name)));
    }
    let mut piece = RoadmapPiece { robot: job.robot, holding: job.holding, vertices: Vec::new(), edges: Vec::new() };
    let start: Configuration = [&robot.start[..3], folded(robot, job.holding.is_some())].concat();
    // Driving home with a load may be impossible while home empty-handed is fine: then there is no such vertex to keep.
    let random = RandomStream::new(seed, StageKind::Roadmap, &[&robot.name], "base");
    let shift: [f64; 3] = random.unit(0);
    let wanted = (problem.levels.vertices as usize) << job.level.min(16);
    let samples = (0..(wanted as u64) * DRAWS_PER_VERTEX).map(|index| sample(robot, &shift, index, &start));
    let mut causes = CauseTally::default();
    for q in std::iter::once(start.clone()).chain(samples) {
        if piece.vertices.len() > wanted || !context.spend(1)? {
            break;
        }
        match geometry.state_contact(job.robot, job.holding, &q, AllowedContacts::default()) {
            None => {
                let near = nearest(robot, &piece.vertices, &q, NEIGHBOURS);
                add_vertex(geometry, robot, &mut piece, q, near.iter().map(|neighbour| neighbour.vertex));
            }
            Some(contact) => causes.count(contact.cause(problem)),
        }
    }
    build_bridges(geometry, robot, &mut piece, context)?;
    Ok(if piece.vertices.is_empty() { Err(causes) } else { Ok(piece) })
}

fn sample(robot: &Robot, shift: &[f64; 3], index: u64, start: &Configuration) -> Configuration {
    let unit = |i: usize, base: u64| (halton(index, base) + shift[i]).fract();
    let between = |i: usize, u: f64| {
        let (low, high) = (robot.coordinates[i].lower, robot.coordinates[i].upper);
        low + u * (high - low)
    };
    let mut q = start.clone();
    q[0] = between(0, unit(0, 2));
    q[1] = between(1, unit(1, 3));
    q[2] = std::f64::consts::TAU * unit(2, 5) - std::f64::consts::PI;
    q
}

/// Adds a vertex with straight drives to those of some others to which they are free.
pub(crate) fn add_vertex(
    geometry: &Geometry,
    robot: &Robot,
    piece: &mut RoadmapPiece,
    q: Configuration,
    others: impl IntoIterator<Item = usize>,
) {
    let new = piece.vertices.len();
    piece.vertices.push(q);
    for other in others {
        if is_free_drive(geometry, robot, piece, &piece.vertices[new], &piece.vertices[other]) {
            let allowed = AllowedContacts::default();
            piece.edges.push(straight_edge(robot, &piece.vertices, new, other, EdgeKind::Base, allowed));
        }
    }
}

/// Whether the straight drive of a piece's robot and load is free.
pub(crate) fn is_free_drive(
    geometry: &Geometry,
    robot: &Robot,
    piece: &RoadmapPiece,
    from: &Configuration,
    to: &Configuration,
) -> bool {
    let (to, allowed) = (robot.short_way(from, to), AllowedContacts::default());
    let motion = Motion { robot: piece.robot, holding: piece.holding, from: from.clone(), to, allowed };
    geometry.motion_contact(&motion).is_none()
}
