use glamx::DVec3;
use model::{Body, Shape};
use nalgebra::{Isometry3, Point3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::SharedShape;

use super::{Separation, Solid};
use crate::frame::Frame;
use crate::random::Random;

/// Parry's own shape, for its own dispatch.
fn reference(shape: &Shape) -> SharedShape {
    let corner = |p: &Point3<f64>| Vector::new(p.x, p.y, p.z);
    match shape {
        Shape::Box { size: [x, y, z] } => SharedShape::cuboid(x / 2.0, y / 2.0, z / 2.0),
        Shape::Sphere { radius } => SharedShape::ball(*radius),
        // Parry's cylinders and capsules stand along y.
        Shape::Cylinder { radius, length } => SharedShape::compound(vec![(
            Pose::rotation(Vector::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0)),
            SharedShape::cylinder(length / 2.0, *radius),
        )]),
        Shape::Capsule { radius, length } => {
            SharedShape::capsule(Vector::new(0.0, 0.0, -length / 2.0), Vector::new(0.0, 0.0, length / 2.0), *radius)
        }
        Shape::Hull { points } => {
            SharedShape::convex_hull(&points.iter().map(corner).collect::<Vec<_>>()).expect("points span a volume")
        }
    }
}

fn bare(shape: Shape) -> Solid {
    Solid::new(&Body { owner_from_shape: Isometry3::identity(), shape })
}

/// Two random bodies, placed near one another.
fn pair(random: &mut Random) -> [(Body, Isometry3<f64>); 2] {
    [(); 2].map(|()| {
        let body = random.body(0.5);
        let pose = random.pose(0.4) * body.owner_from_shape;
        (body, pose)
    })
}

#[test]
fn certified_gaps_are_the_distances_that_parry_measures() {
    for seed in 0..4000 {
        let [(body, pose), (other, other_pose)] = pair(&mut Random(seed));
        let (shape, other_shape) = (reference(&body.shape), reference(&other.shape));
        let measured = query::distance(&Pose::from(pose), &*shape, &Pose::from(other_pose), &*other_shape);
        let measured = measured.expect("both kinds are supported").distance;
        let (frame, other_frame) = (Frame::of(&pose), Frame::of(&other_pose));
        let gap = Solid::new(&body).certified_gap(&frame, &Solid::new(&other), &other_frame);
        assert!(gap <= measured + 1e-9, "seed {seed}: certified {gap}, measured {measured}");
        // Parry's own routines stop this far above the distance where surfaces are curved.
        assert!(measured == 0.0 || gap >= measured - 3e-5, "seed {seed}: certified {gap}, measured {measured}");
    }
}

#[test]
fn certified_gaps_fall_short_of_the_distance_by_less_than_any_clearance() {
    for seed in 0..4000 {
        let [(body, pose), (other, other_pose)] = pair(&mut Random(seed));
        let (solid, against) = (Solid::new(&body), Solid::new(&other));
        let (frame, other_frame) = (Frame::of(&pose), Frame::of(&other_pose));
        // The distance between two points of the bodies, hence never below the true one.
        let Separation::Apart(_, above) = solid.separation(&frame, &against, &other_frame, DVec3::X) else { continue };
        let below = solid.certified_gap(&frame, &against, &other_frame);
        let curved = [&body, &other].iter().any(|b| matches!(b.shape, Shape::Cylinder { .. }));
        let slack = if curved { 2e-5 } else { 1e-7 };
        assert!(
            above <= 0.0 || below <= above + 1e-12 && below >= above - slack,
            "seed {seed}: between {below} and {above}"
        );
    }
}

#[test]
fn gaps_of_simple_arrangements_are_exact() {
    let shifted = |x: f64, y: f64, z: f64| Frame::shifted(DVec3::new(x, y, z));
    let cube = bare(Shape::Box { size: [1.0, 1.0, 1.0] });
    let ball = bare(Shape::Sphere { radius: 0.25 });
    let can = bare(Shape::Cylinder { radius: 0.25, length: 1.0 });
    let pill = bare(Shape::Capsule { radius: 0.25, length: 0.5 });
    let expect = |a: &Solid, b: &Solid, at: Frame, gap: f64| {
        let found = a.certified_gap(&Frame::IDENTITY, b, &at);
        assert!((found - gap).abs() < 1e-7, "{found}, expected {gap}");
    };
    expect(&cube, &ball, shifted(1.0, 0.0, 0.0), 0.25);
    expect(&cube, &ball, shifted(0.8, 0.9, 0.0), 0.25);
    expect(&cube, &can, shifted(0.8, 0.9, 0.3), 0.25);
    expect(&cube, &can, shifted(0.0, 0.0, 1.5), 0.5);
    expect(&can, &pill, shifted(1.0, 0.0, 0.0), 0.5);
    expect(&can, &pill, shifted(0.0, 0.0, 2.0), 1.0);
    expect(&pill, &ball, shifted(0.3, 0.0, 0.65), 0.0);
    expect(&can, &can, shifted(0.8, 0.6, 0.0), 0.5);
    expect(&cube, &cube, shifted(0.5, 0.0, 0.0), -0.5);
}

#[test]
fn the_bounding_sphere_contains_the_body() {
    for seed in 0..500 {
        let mut random = Random(seed);
        let body = random.body(0.5);
        let (solid, direction) = (Solid::new(&body), random.direction());
        let height = solid.height_along(&solid.owner_from_shape, direction);
        assert!(height <= direction.dot(solid.centre) + solid.radius + 1e-12, "seed {seed}");
    }
}

#[test]
fn the_depth_of_boxes_is_that_of_their_least_overlap() {
    let cube = bare(Shape::Box { size: [1.0, 1.0, 1.0] });
    let at = Frame::shifted(DVec3::new(0.9, 0.5, 0.2));
    assert!((cube.depth(&Frame::IDENTITY, &cube, &at) - 0.1).abs() < 1e-12);
}
