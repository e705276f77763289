use super::*;
use crate::random::Random;
use crate::solid::Solid;
use glamx::DVec3;

#[test]
fn sections_of_upright_bodies_are_their_footprints() {
    let body = |shape| Body { owner_from_shape: model::Pose::translation(0.1, 0.2, 0.3), shape };
    let of = |shape| Inside::of(&body(shape), &Frame::IDENTITY);
    let brick = of(Shape::Box { size: [0.4, 0.2, 1.0] });
    assert_eq!(brick.heights(), (-0.2, 0.8));
    for z in [-0.2, 0.0, 0.8] {
        let section = brick.section(z);
        assert!((section.area() - 0.08).abs() < 1e-12 && section.0.len() == 4, "{z}");
        assert!((section.radius_about(DVec2::new(0.1, 0.25)) - 0.05).abs() < 1e-12);
        assert_eq!(section.distance(DVec2::new(0.25, 0.2)), 0.0);
        assert!((section.distance(DVec2::new(0.6, 0.7)) - 0.5).abs() < 1e-12);
    }
    assert_eq!(brick.section(0.81).area(), 0.0);
    assert_eq!(brick.section(0.81).distance(DVec2::ZERO), f64::INFINITY);
    let disc = of(Shape::Cylinder { radius: 0.5, length: 0.2 }).section(0.3);
    assert!(disc.area() < TAU / 8.0 && disc.area() > TAU / 8.0 - 4e-4, "{}", disc.area());
    assert!(disc.radius_about(DVec2::new(0.1, 0.2)) > 0.4998);
}

#[test]
fn a_cut_polygon_loses_what_is_beyond_the_line() {
    let square = Polygon(vec![DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0), DVec2::new(1.0, 1.0), DVec2::new(0.0, 1.0)]);
    assert!((square.cut(DVec2::X, 0.25).area() - 0.25).abs() < 1e-12);
    assert!((square.cut(DVec2::ONE, 1.0).area() - 0.5).abs() < 1e-12);
    assert_eq!(square.cut(DVec2::X, -1.0).area(), 0.0);
    assert!((square.cut(DVec2::X, 1.0).area() - 1.0).abs() < 1e-12);
}

/// No point of a section is outside of the body: along no direction does it reach farther.
#[test]
fn sections_stay_inside_of_random_bodies() {
    for seed in 0..200 {
        let mut random = Random(seed);
        let (body, pose) = (random.body(0.5), random.pose(1.0));
        let (solid, frame) = (Solid::new(&body), Frame::of(&pose));
        let placed = frame * solid.owner_from_shape;
        let inside = Inside::of(&body, &frame);
        let (low, high) = inside.heights();
        assert!(high <= solid.height_along(&placed, DVec3::Z) + 1e-9, "seed {seed}");
        for part in [0.0, 0.3, 0.5, 0.9, 1.0] {
            let z = low + part * (high - low);
            let section = inside.section(z);
            for _ in 0..30 {
                let direction = random.direction();
                for corner in &section.0 {
                    let reach = direction.dot(corner.extend(z));
                    assert!(reach <= solid.height_along(&placed, direction) + 1e-9, "seed {seed}");
                }
            }
        }
    }
}

#[test]
fn the_hull_of_random_points_contains_them_and_turns_left() {
    for seed in 0..300 {
        let mut random = Random(seed);
        let points: Vec<DVec2> = (0..3 + random.below(40)).map(|_| DVec2::new(random.unit(), random.unit())).collect();
        let hull = Polygon::around(points.clone());
        let corners = &hull.0;
        for i in 0..corners.len() {
            let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % corners.len()]);
            assert!((b - a).perp_dot(c - b) > 0.0, "seed {seed}");
        }
        assert!(points.iter().all(|p| hull.distance(*p) < 1e-12), "seed {seed}");
    }
}
