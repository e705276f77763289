use super::*;
use crate::random::Random;
use crate::solid::{Separation, Solid};

fn placed(body: &Body, frame: &Frame) -> Wedge {
    Wedge::of(body).placed(frame)
}

#[test]
fn the_depth_of_boxes_is_the_least_way_out() {
    let cube = Body { owner_from_shape: model::Pose::identity(), shape: Shape::Box { size: [1.0; 3] } };
    let wedge = Wedge::of(&cube);
    for (x, depth) in [(0.9, 0.1), (0.0, 1.0), (-0.25, 0.75), (1.2, -0.2)] {
        let other = wedge.placed(&Frame::shifted(DVec3::new(x, 0.0, 0.0)));
        assert!((wedge.depth(&other) - depth).abs() < 2e-5, "{x}: {}", wedge.depth(&other));
    }
    // Edge to edge: two cubes on their edges, crossed.
    let eighth = std::f64::consts::FRAC_PI_4;
    let lying = wedge.placed(&Frame::turned(DVec3::X, eighth));
    let above = Frame::shifted(DVec3::new(0.0, 0.0, 1.3)) * Frame::turned(DVec3::Y, eighth);
    let expected = 2.0_f64.sqrt() - 1.3;
    assert!((lying.depth(&wedge.placed(&above)) - expected).abs() < 2e-5);
}

/// Along no sampled direction is there less overlap than the depth says, and of boxes the directions come near to it.
#[test]
fn no_direction_has_less_overlap_than_the_depth() {
    let mut tight = 0;
    for seed in 0..400 {
        let mut random = Random(seed);
        let bodies = [random.body(0.6), random.body(0.6)];
        let frames = [Frame::of(&random.pose(0.1)), Frame::of(&random.pose(0.1))];
        let (a, b) = (placed(&bodies[0], &frames[0]), placed(&bodies[1], &frames[1]));
        let depth = a.depth(&b);
        let solids = bodies.each_ref().map(Solid::new);
        let at = [0, 1].map(|i| frames[i] * solids[i].owner_from_shape);
        let overlap = |n: DVec3| -solids[0].gap_along(&at[0], &solids[1], &at[1], n);
        let least = (0..3000).map(|_| overlap(random.direction())).fold(f64::INFINITY, f64::min);
        assert!(depth <= least.max(0.0) + 1e-9, "seed {seed}: {depth} but {least}");
        let are_boxes = bodies.iter().all(|body| matches!(body.shape, Shape::Box { .. }));
        tight += usize::from(are_boxes && depth > 0.0 && depth > least - 0.02);
    }
    assert!(tight > 5, "{tight}");
}

/// However a body is displaced by less than the depth, it still meets the other.
#[test]
fn bodies_still_meet_when_displaced_by_less_than_the_depth() {
    let mut tried = 0;
    for seed in 0..2000 {
        let mut random = Random(seed);
        let bodies = [random.body(0.5), random.body(0.5)];
        let frames = [Frame::of(&random.pose(0.2)), Frame::of(&random.pose(0.2))];
        let (a, b) = (placed(&bodies[0], &frames[0]), placed(&bodies[1], &frames[1]));
        let depth = a.depth(&b);
        if depth <= 1e-3 {
            continue;
        }
        let solids = bodies.each_ref().map(Solid::new);
        for _ in 0..10 {
            let turn = random.between(0.0, 0.5) * depth / (2.0 * (solids[0].centre.length() + solids[0].radius));
            let moved =
                Frame::shifted(random.direction() * depth * 0.49) * frames[0] * Frame::turned(random.direction(), turn);
            let at = [moved * solids[0].owner_from_shape, frames[1] * solids[1].owner_from_shape];
            let apart = solids[0].separation(&at[0], &solids[1], &at[1], DVec3::Z);
            let meet = !matches!(apart, Separation::Apart(_, distance) if distance > 0.0);
            assert!(meet, "seed {seed}: depth {depth}");
            tried += 1;
        }
    }
    assert!(tried > 1000, "{tried}");
}
