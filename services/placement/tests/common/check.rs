//! Whether a candidate is what it should be, from its poses and orders alone. Boxes only.

use contract::PlacementCandidate;
use model::{ObjectId, Point, Pose, Problem, Removal, Shape};
use skeleton::{ArcOrigin, Event, EventGraph};

/// A pose with the events that begin and end it.
struct Stay {
    object: ObjectId,
    world_from_object: Pose,
    comes: Option<Event>,
    leaves: Option<Event>,
}

/// Panics unless every pair has a pose in its region, no two objects that may stand at the same time collide, every order
/// closes no cycle and is needed.
pub fn assert_sound(problem: &Problem, candidate: &PlacementCandidate) {
    assert_eq!(candidate.placements.len(), problem.pairs.len());
    for (index, placed) in candidate.placements.iter().enumerate() {
        assert_eq!(placed.pair.index(), index);
        assert_inside(problem, index, &placed.world_from_object);
    }
    let stays = stays(problem, candidate);
    let without = |left_out: Option<usize>| {
        let mut graph = EventGraph::of_problem(problem).unwrap();
        for (i, order) in candidate.orders.iter().enumerate().filter(|(i, _)| Some(*i) != left_out) {
            assert_eq!((order.before.point, order.after.point), (leaving(problem), Point::Release), "order {i}");
            graph.add(order.before, order.after, ArcOrigin::Discovered).unwrap();
        }
        graph
    };
    assert_eq!(clashes(problem, &without(None), &stays), 0, "objects collide");
    for left_out in 0..candidate.orders.len() {
        assert!(clashes(problem, &without(Some(left_out)), &stays) > 0, "order {left_out} is not needed");
    }
}

fn leaving(problem: &Problem) -> Point {
    if problem.settings.removal == Removal::Grasp { Point::Grasp } else { Point::Release }
}

fn stays(problem: &Problem, candidate: &PlacementCandidate) -> Vec<Stay> {
    let mut stays = Vec::new();
    for (index, movable) in problem.movable.iter().enumerate() {
        let object = ObjectId::at(index);
        let hops = problem.hops_of_object(object);
        for i in 0..=hops.len() {
            let pose = |i: usize| candidate.placements[hops[i].index()].world_from_object;
            stays.push(Stay {
                object,
                world_from_object: if i == 0 { movable.world_from_start } else { pose(i - 1) },
                comes: i.checked_sub(1).map(|i| Event::release(hops[i])),
                leaves: hops.get(i).map(|pair| Event::new(*pair, leaving(problem))),
            });
        }
    }
    stays
}

fn clashes(problem: &Problem, graph: &EventGraph, stays: &[Stay]) -> usize {
    let over = |a: &Stay, b: &Stay| matches!((a.leaves, b.comes), (Some(g), Some(p)) if graph.precedes(g, p));
    let mut clashes = 0;
    for (i, a) in stays.iter().enumerate() {
        for b in stays[..i].iter().filter(|b| b.object != a.object && (a.comes.is_some() || b.comes.is_some())) {
            let together = !over(a, b) && !over(b, a);
            clashes += usize::from(
                together && overlap(problem, (a.object, &a.world_from_object), (b.object, &b.world_from_object)),
            );
        }
    }
    clashes
}

fn box_size(problem: &Problem, object: ObjectId) -> [f64; 3] {
    match problem.movable[object.index()].body.shape {
        Shape::Box { size } => size,
        ref other => panic!("no box: {other:?}"),
    }
}

/// Corners of an upright box's footprint in the world, in order round it (m).
fn corners([x, y, _]: [f64; 3], world_from_object: &Pose) -> [[f64; 2]; 4] {
    [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[u, v]| {
        let p = world_from_object * nalgebra::Point3::new(u * x / 2.0, v * y / 2.0, 0.0);
        [p.x, p.y]
    })
}

/// Whether two upright boxes overlap: no edge of either separates their footprints, nor does their height.
pub fn overlap(problem: &Problem, a: (ObjectId, &Pose), b: (ObjectId, &Pose)) -> bool {
    let sizes = [a, b].map(|(object, _)| box_size(problem, object));
    if (a.1.translation.z - b.1.translation.z).abs() >= (sizes[0][2] + sizes[1][2]) / 2.0 {
        return false;
    }
    let prints = [corners(sizes[0], a.1), corners(sizes[1], b.1)];
    let separates = |print: usize, edge: usize| {
        let (p, q) = (prints[print][edge], prints[print][(edge + 1) % 4]);
        let outward = [q[1] - p[1], p[0] - q[0]];
        let beyond = |c: &[f64; 2]| (c[0] - p[0]) * outward[0] + (c[1] - p[1]) * outward[1] >= 0.0;
        prints[1 - print].iter().all(beyond)
    };
    !(0..2).any(|print| (0..4).any(|edge| separates(print, edge)))
}

/// Panics unless the box stands upright on its region, its footprint inside of the rectangle less the margin.
fn assert_inside(problem: &Problem, pair: usize, world_from_object: &Pose) {
    let pair = &problem.pairs[pair];
    let region = &problem.regions[pair.to.index()];
    let size = box_size(problem, pair.object);
    let region_from_object = region.world_from_region.inverse() * world_from_object;
    assert!((region_from_object.translation.z - size[2] / 2.0).abs() < 1e-9, "{} floats or sinks", pair.name);
    let up = world_from_object.rotation * nalgebra::Vector3::z();
    assert!(up.z > 1.0 - 1e-12, "{} tilts", pair.name);
    for corner in corners(size, &region_from_object) {
        for axis in 0..2 {
            let limit = region.size[axis] / 2.0 - problem.settings.region_margin;
            assert!(corner[axis].abs() <= limit + 1e-9, "{} sticks out of {}", pair.name, region.name);
        }
    }
}
