//! What a body covers when seen from above, bounded from below: for proofs.

use std::f64::consts::{PI, TAU};

use model::{Body, Pose, Shape};
use nalgebra::{Point3, Vector3};

use crate::footprint::Rectangle;

/// Parts of a half turn over which widths are bounded.
const HALF_TURN_CELLS: u32 = 4096;
/// Cosine of a tilt that counts as none.
const UPRIGHT: f64 = 1.0 - 1e-9;
/// How far a body must stick out to count (m): proofs are checked with other mathematics.
const EXCESS: f64 = 1e-5;

/// A body about its owner's origin, in the owner's frame; the owner's z axis points up.
#[derive(Clone, Debug)]
pub(crate) struct Outline<'a> {
    body: &'a Body,
    points: Vec<Point3<f64>>,
}

impl<'a> Outline<'a> {
    pub fn new(body: &'a Body) -> Self {
        let points = match &body.shape {
            // Its support points are the corners of a box around it.
            Shape::Cylinder { length, .. } => {
                [-0.5, 0.5].map(|end| body.owner_from_shape * Point3::new(0.0, 0.0, end * length)).to_vec()
            }
            shape => shape.support_points().iter().map(|p| body.owner_from_shape * p).collect(),
        };
        Self { body, points }
    }

    fn axis(&self) -> Vector3<f64> {
        self.body.owner_from_shape * Vector3::z()
    }

    /// Extent along a horizontal unit direction (m); exact.
    fn width(&self, direction: &Vector3<f64>) -> f64 {
        let along = self.points.iter().map(|p| p.coords.dot(direction));
        let (low, high) = along.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
        let radius = match &self.body.shape {
            Shape::Cylinder { radius, .. } => radius * (1.0 - self.axis().dot(direction).powi(2)).max(0.0).sqrt(),
            shape => shape.rounding(),
        };
        high - low + 2.0 * radius
    }

    /// Bound on the horizontal distance of any two of its points (m).
    fn diameter(&self) -> f64 {
        let round = match &self.body.shape {
            Shape::Cylinder { radius, .. } => *radius,
            shape => shape.rounding(),
        };
        let middle = self.points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / self.points.len() as f64;
        2.0 * (self.points.iter().fold(0.0, |far: f64, p| far.max((p.coords - middle).xy().norm())) + round)
    }

    /// Whether it sticks out of the rectangle at every yaw. `true` is a proof: widths change by at most the diameter per
    /// radian.
    pub fn never_fits(&self, rectangle: &Rectangle) -> bool {
        let cell = PI / f64::from(HALF_TURN_CELLS);
        let slack = self.diameter() * cell / 2.0 + EXCESS;
        (0..HALF_TURN_CELLS).all(|i| {
            let (sin, cos) = ((f64::from(i) + 0.5) * cell).sin_cos();
            self.width(&Vector3::new(cos, sin, 0.0)) - slack > rectangle.size[0]
                || self.width(&Vector3::new(-sin, cos, 0.0)) - slack > rectangle.size[1]
        })
    }

    /// Area (m²) that it covers at every height from its bottom to its top, if it is such a prism.
    pub fn prism_area(&self) -> Option<f64> {
        match &self.body.shape {
            Shape::Cylinder { radius, .. } => (self.axis().z.abs() >= UPRIGHT).then_some(TAU / 2.0 * radius * radius),
            Shape::Box { size } => {
                let turn = self.body.owner_from_shape.rotation;
                let is_vertical = |axis: usize| (turn * Vector3::ith(axis, 1.0)).z.abs() >= UPRIGHT;
                let vertical = (0..3).find(|axis| is_vertical(*axis))?;
                Some((0..3).filter(|axis| *axis != vertical).map(|axis| size[axis]).product())
            }
            Shape::Sphere { .. } | Shape::Capsule { .. } | Shape::Hull { .. } => None,
        }
    }
}

/// Whether a pose is upright.
pub(crate) fn is_upright(world_from_object: &Pose) -> bool {
    (world_from_object.rotation * Vector3::z()).z >= UPRIGHT
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(shape: Shape) -> Body {
        Body { owner_from_shape: Pose::identity(), shape }
    }

    #[test]
    fn a_box_that_fits_only_at_a_slant_is_not_said_never_to_fit() {
        // A plank longer than either edge, shorter than the diagonal.
        let plank = body(Shape::Box { size: [0.12, 0.002, 0.1] });
        assert!(!Outline::new(&plank).never_fits(&Rectangle { size: [0.1, 0.1] }));
        let longer = body(Shape::Box { size: [0.142, 0.002, 0.1] });
        assert!(Outline::new(&longer).never_fits(&Rectangle { size: [0.1, 0.1] }));
    }

    #[test]
    fn a_disc_needs_its_diameter_both_ways() {
        let disc = body(Shape::Cylinder { radius: 0.05, length: 0.2 });
        assert!(Outline::new(&disc).never_fits(&Rectangle { size: [0.2, 0.0999] }));
        assert!(!Outline::new(&disc).never_fits(&Rectangle { size: [0.2, 0.1001] }));
        let area = Outline::new(&disc).prism_area().unwrap();
        assert!((area - PI * 0.0025).abs() < 1e-12);
        assert_eq!(Outline::new(&body(Shape::Sphere { radius: 0.05 })).prism_area(), None);
    }

    #[test]
    fn a_lying_box_covers_its_two_horizontal_edges() {
        let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI / 2.0);
        let lying = Body {
            owner_from_shape: Pose::from_parts(nalgebra::Translation3::identity(), turn),
            shape: Shape::Box { size: [0.3, 0.2, 0.1] },
        };
        assert!((Outline::new(&lying).prism_area().unwrap() - 0.03).abs() < 1e-12);
    }
}
