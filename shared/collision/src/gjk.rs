//! Closest points of two placed solids' cores, by parry's GJK. Only ever a proposer of axes and witnesses: what it
//! says is verified by whoever asks.

use nalgebra::Vector3;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d_f64::shape::SupportMap;

use crate::solid::{Placed, Solid};

/// Coordinates beyond this (m) are not handed to GJK, which asserts that its bounds are finite.
const FARTHEST: f64 = 1e9;

/// Witness points nearer than this (m) give no axis.
const SHORTEST: f64 = 1e-7;

/// What GJK found for two cores.
#[derive(Debug)]
pub(crate) enum Closest {
    /// They intersect, or their poses are no numbers.
    Meeting,
    /// They are at most this far apart (m); the unit axis from the first to the second is where they are farthest apart.
    Apart { at_most: f64, axis: Vector3<f64> },
}

/// A solid's core, turned and moved.
struct Located<'a> {
    solid: &'a Solid,
    placed: &'a Placed,
    center: Vector3<f64>,
}

impl SupportMap for Located<'_> {
    fn local_support_point(&self, direction: Vector) -> Vector {
        let local = self.placed.rotation.tr_mul(&to_nalgebra(direction));
        to_parry(self.placed.rotation * self.solid.core_support(&local) + self.center)
    }
}

fn to_parry(v: Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn to_nalgebra(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

/// Closest points of two cores, looked for up to `margin` (m). `guess` is a likely axis from the first to the second.
pub(crate) fn closest(a: (&Solid, &Placed), b: (&Solid, &Placed), margin: f64, guess: &Vector3<f64>) -> Closest {
    let between = b.1.center - a.1.center;
    let sane = |v: &Vector3<f64>| v.iter().all(|c| c.abs() < FARTHEST);
    if !sane(&between) || !sane(guess) || !a.1.rotation.iter().chain(b.1.rotation.iter()).all(|c| c.is_finite()) {
        return Closest::Meeting;
    }
    // About the first solid's origin, so that nothing is lost far from the world's.
    let first = Located { solid: a.0, placed: a.1, center: Vector3::zeros() };
    let second = Located { solid: b.0, placed: b.1, center: between };
    let here = Pose::IDENTITY;
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(&here, &first, &second, to_parry(*guess)));
    match closest_points(&here, &first, &second, margin, true, &mut simplex) {
        GJKResult::Intersection => Closest::Meeting,
        GJKResult::ClosestPoints(p, q, axis) => {
            let across = to_nalgebra(q) - to_nalgebra(p);
            let at_most = across.norm();
            // Between points that nearly coincide the way across says nothing.
            let axis = if at_most > SHORTEST { across / at_most } else { to_nalgebra(axis) };
            Closest::Apart { at_most, axis }
        }
        GJKResult::NoIntersection(axis) | GJKResult::Proximity(axis) => {
            Closest::Apart { at_most: f64::INFINITY, axis: to_nalgebra(axis) }
        }
    }
}
