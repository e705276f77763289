//! How deep two placed solids overlap, by their supports alone.

use nalgebra::Vector3;

use crate::gjk::{self, Closest};
use crate::separation::Posed;

/// Directions tried all around (a Fibonacci lattice).
const DIRECTIONS: u32 = 256;
/// Most directions from which the least overlap is sought downhill, and the cosine above which two are one.
const STARTS: usize = 12;
const APART: f64 = 0.98;
/// Directions polled around the best one in each round of refinement.
const POLLED: u32 = 12;
/// Fruitless rounds before the step is halved.
const PATIENCE: u32 = 4;
/// Step at which refinement ends (rad), and most rounds of it.
const FINEST: f64 = 1e-8;
const MOST_ROUNDS: u32 = 2_000;
/// Cores farther apart than this (m) are asked for their distance; nearer ones count as meeting.
const MEETING: f64 = 1e-9;
/// Golden angle (rad): rotates lattice points and polls so that none repeat.
const GOLDEN: f64 = 2.399_963_229_728_653;

/// The least distance (m) by which one solid must be moved for the two to just touch; below zero where they are apart: then
/// the distance between them.
///
/// For overlapping solids it is the least, over directions, of the overlap along one, which the supports give exactly:
/// never too small, exact where an axis of theirs is the best, as for most boxes, else about 0.01 mm too great.
pub(crate) fn depth(a: Posed<'_>, b: Posed<'_>) -> f64 {
    let between = b.1.center - a.1.center;
    let guess = between.try_normalize(1e-12).unwrap_or_else(Vector3::z);
    match gjk::closest(a, b, f64::MAX, &guess) {
        Closest::Apart { at_most, .. } if at_most > MEETING && at_most.is_finite() => {
            a.0.rounding + b.0.rounding - at_most
        }
        _ => least_overlap(a, b, guess),
    }
}

/// Whether an axis of one of the solids shows that they overlap by at most `tolerance` (m): cheap, for bodies side by side.
pub(crate) fn only_touch(a: Posed<'_>, b: Posed<'_>, tolerance: f64) -> bool {
    axes(a.1).iter().chain(&axes(b.1)).any(|axis| overlap(a, b, axis).min(overlap(a, b, &-axis)) <= tolerance)
}

/// A placed solid's axes in the world.
fn axes(placed: &crate::solid::Placed) -> [Vector3<f64>; 3] {
    [0, 1, 2].map(|i| Vector3::from(placed.rotation.column(i)))
}

/// How far the solids overlap along a unit direction from the first to the second (m).
fn overlap(a: Posed<'_>, b: Posed<'_>, direction: &Vector3<f64>) -> f64 {
    a.0.extent(a.1, direction) + b.0.extent(b.1, &-direction)
}

fn least_overlap(a: Posed<'_>, b: Posed<'_>, guess: Vector3<f64>) -> f64 {
    let mut candidates = vec![guess];
    let (of_a, of_b) = (axes(a.1), axes(b.1));
    candidates.extend(of_a.iter().chain(&of_b));
    // Where two edges cross, the way apart is across both.
    candidates.extend(of_a.iter().flat_map(|u| of_b.iter().filter_map(|v| u.cross(v).try_normalize(1e-6))));
    candidates.extend((0..DIRECTIONS).map(lattice));
    let both = candidates.iter().flat_map(|direction| [*direction, -direction]);
    let mut rated: Vec<_> = both.map(|direction| (overlap(a, b, &direction), direction)).collect();
    rated.sort_by(|x, y| x.0.total_cmp(&y.0));
    let near = |x: &Vector3<f64>, y: &Vector3<f64>| x.dot(y) > APART;
    let mut starts: Vec<(f64, Vector3<f64>)> = Vec::new();
    for candidate in rated {
        if starts.len() < STARTS && !starts.iter().any(|start| near(&start.1, &candidate.1)) {
            starts.push(candidate);
        }
    }
    starts.into_iter().map(|start| refined(a, b, start)).fold(f64::INFINITY, f64::min)
}

/// Point `i` of a lattice of unit vectors.
fn lattice(i: u32) -> Vector3<f64> {
    let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(DIRECTIONS);
    let (across, angle) = ((1.0 - z * z).sqrt(), f64::from(i) * GOLDEN);
    Vector3::new(across * angle.cos(), across * angle.sin(), z)
}

/// Walks downhill from a direction. Near its least the overlap has kinks, so the polls turn from round to round.
fn refined(a: Posed<'_>, b: Posed<'_>, (mut least, mut best): (f64, Vector3<f64>)) -> f64 {
    let (mut step, mut fruitless, mut turn) = (2.0 / f64::from(DIRECTIONS).sqrt(), 0, 0.0);
    for _ in 0..MOST_ROUNDS {
        if step <= FINEST {
            break;
        }
        let across = best.cross(&if best.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() }).normalize();
        let up = best.cross(&across);
        let start = turn;
        let polls = (0..POLLED).map(|i| {
            let angle: f64 = start + f64::from(i) * std::f64::consts::TAU / f64::from(POLLED);
            (best + (across * angle.cos() + up * angle.sin()) * step).normalize()
        });
        let rated = polls.map(|direction| (overlap(a, b, &direction), direction));
        turn += GOLDEN;
        match rated.min_by(|x, y| x.0.total_cmp(&y.0)) {
            Some(better) if better.0 < least => {
                (least, best) = better;
                fruitless = 0;
            }
            _ => fruitless += 1,
        }
        if fruitless == PATIENCE {
            (step, fruitless) = (step / 2.0, 0);
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4, SQRT_2};

    use model::{Pose, Shape};
    use nalgebra::{Point3, Translation3, UnitQuaternion};

    use super::*;
    use crate::solid::{Placed, Solid};

    fn depth_of(a: (&Shape, Pose), b: (&Shape, Pose)) -> f64 {
        let placed = |(shape, pose): (&Shape, Pose)| {
            let (solid, origin) = Solid::new(shape).unwrap();
            (solid, Placed::at(&crate::hull::shifted(&pose, &origin)))
        };
        let (a, b) = (placed(a), placed(b));
        depth((&a.0, &a.1), (&b.0, &b.1))
    }

    fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose::from_parts(Translation3::new(x, y, z), UnitQuaternion::identity())
    }

    fn turned(x: f64, y: f64, z: f64, axis: Vector3<f64>, angle: f64) -> Pose {
        Pose::from_parts(Translation3::new(x, y, z), UnitQuaternion::new(axis * angle))
    }

    const CUBE: Shape = Shape::Box { size: [1.0; 3] };

    #[test]
    fn overlaps_of_known_depth_are_found() {
        let ball = |radius: f64| Shape::Sphere { radius };
        let (rod, pole) = (Shape::Capsule { radius: 0.1, length: 2.0 }, Shape::Cylinder { radius: 0.2, length: 1.0 });
        let slab = Shape::Box { size: [4.0, 4.0, 0.1] };
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let cases = [
            ("boxes side by side", &CUBE, at(0.0, 0.0, 0.0), &CUBE, at(0.9, 0.3, -0.2), 0.1),
            ("a box within a box", &slab, at(0.0, 0.0, 0.0), &CUBE, at(0.2, 0.0, 0.3), 0.25),
            ("a box's edge in a face", &CUBE, at(0.0, 0.0, 0.0), &CUBE, turned(1.2, 0.0, 0.0, z, FRAC_PI_4), {
                0.5 + FRAC_1_SQRT_2 - 1.2
            }),
            (
                "crossing edges",
                &CUBE,
                turned(0.0, 0.0, 0.0, x, FRAC_PI_4),
                &CUBE,
                turned(0.0, 0.0, SQRT_2 - 0.02, y, FRAC_PI_4),
                0.02,
            ),
            ("a cylinder sunk into a slab", &slab, at(0.0, 0.0, 0.0), &pole, at(0.3, 0.1, 0.54), 0.01),
            ("cylinders side by side", &pole, at(0.0, 0.0, 0.0), &pole, at(0.21, 0.28, 0.1), 0.05),
            ("a lying cylinder in a slab", &slab, at(0.0, 0.0, 0.0), &pole, turned(0.0, 0.0, 0.2, x, FRAC_PI_2), 0.05),
            ("crossing rods", &rod, at(0.0, 0.0, 0.0), &rod, turned(0.15, 0.0, 0.3, x, FRAC_PI_2), 0.05),
            ("rods through one point", &rod, at(0.0, 0.0, 0.0), &rod, turned(0.0, 0.0, 0.0, y, FRAC_PI_2), 0.2),
            ("balls", &ball(0.5), at(0.0, 0.0, 0.0), &ball(0.3), at(0.36, 0.0, 0.48), 0.2),
            ("balls of one centre", &ball(0.5), at(0.0, 0.0, 0.0), &ball(0.3), at(0.0, 0.0, 0.0), 0.8),
            ("a ball within a box", &CUBE, at(0.0, 0.0, 0.0), &ball(0.1), at(0.3, 0.1, 0.0), 0.3),
            ("boxes apart", &CUBE, at(0.0, 0.0, 0.0), &CUBE, at(1.3, 1.4, 0.0), -0.5),
            ("balls apart", &ball(0.1), at(0.0, 0.0, 0.0), &ball(0.1), at(0.0, 0.0, 1.0), -0.8),
        ];
        for (name, a, a_at, b, b_at, expected) in cases {
            for found in [depth_of((a, a_at), (b, b_at)), depth_of((b, b_at), (a, a_at))] {
                assert!((found - expected).abs() < 1e-5, "{name}: {found}, not {expected}");
            }
        }
    }

    /// Corners of a box as a mesh that knows nothing of the box's axes.
    fn as_mesh(size: [f64; 3], pose: &Pose) -> Shape {
        let corner = |i: usize| {
            let side = |axis: usize| if i >> axis & 1 == 1 { size[axis] / 2.0 } else { -size[axis] / 2.0 };
            pose * Point3::new(side(0), side(1), side(2))
        };
        Shape::Hull { points: (0..8).map(corner).collect() }
    }

    #[test]
    fn meshes_overlap_as_deep_as_the_boxes_that_they_are() {
        let mut state = 7_u64;
        let mut random = |low: f64, high: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * ((state >> 11) as f64 / (1_u64 << 53) as f64)
        };
        let mut overlapping = 0;
        for case in 0..200 {
            let mut three = |low: f64, high: f64| [random(low, high), random(low, high), random(low, high)];
            let (size_a, size_b) = (three(0.1, 1.0), three(0.1, 1.0));
            let ([x, y, z], axis_a, axis_b) = (three(-0.6, 0.6), three(-2.0, 2.0), three(-2.0, 2.0));
            let pose_a = turned(0.0, 0.0, 0.0, Vector3::from(axis_a), 1.0);
            let pose_b = turned(x, y, z, Vector3::from(axis_b), 1.0);
            let boxes = depth_of((&Shape::Box { size: size_a }, pose_a), (&Shape::Box { size: size_b }, pose_b));
            let meshes = (as_mesh(size_a, &pose_a), as_mesh(size_b, &pose_b));
            let found = depth_of((&meshes.0, Pose::identity()), (&meshes.1, Pose::identity()));
            assert!((found - boxes).abs() < 1e-4, "case {case}: {found} of meshes, {boxes} of boxes");
            overlapping += u32::from(boxes > 0.0);
        }
        assert!((50..200).contains(&overlapping), "{overlapping}");
    }
}
