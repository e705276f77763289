//! Convex solids and where they stand: supports, extents, distances from an axis.

use model::Shape;
use nalgebra::{Matrix3, Point3, Vector3};

use crate::hull;

/// A convex solid about its own origin: its core, grown by a ball of radius `rounding`.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    core: Core,
    /// Radius by which the core is grown (m).
    pub rounding: f64,
    /// Half edge lengths of a centred box in the solid's axes that contains the core (m).
    pub half: Vector3<f64>,
    /// Radius of a ball about the origin that contains the solid, rounding included (m).
    pub radius: f64,
}

#[derive(Clone, Debug)]
enum Core {
    Point,
    /// Along z.
    Segment,
    Box,
    /// About z; the radius is `half.x`.
    Cylinder,
    Hull(Vec<Vector3<f64>>),
}

/// Pose of a solid in the world, its rotation as a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placed {
    /// Rotation from the solid's axes to the world's.
    pub rotation: Matrix3<f64>,
    /// The solid's origin in the world (m).
    pub center: Vector3<f64>,
}

impl Placed {
    /// A solid standing at a pose.
    pub fn at(pose: &model::Pose) -> Self {
        Self { rotation: *pose.rotation.to_rotation_matrix().matrix(), center: pose.translation.vector }
    }
}

impl Solid {
    /// The solid of a shape, and the point of the shape's frame that is its origin.
    ///
    /// # Errors
    /// A sentence, when a size is not a finite number of at least zero or a hull has no point.
    pub fn new(shape: &Shape) -> Result<(Self, Point3<f64>), String> {
        let (core, half, rounding, origin) = match shape {
            Shape::Sphere { radius } => (Core::Point, Vector3::zeros(), *radius, Point3::origin()),
            Shape::Capsule { radius, length } => {
                (Core::Segment, Vector3::new(0.0, 0.0, length / 2.0), *radius, Point3::origin())
            }
            Shape::Box { size } => (Core::Box, Vector3::from(*size) / 2.0, 0.0, Point3::origin()),
            Shape::Cylinder { radius, length } => {
                (Core::Cylinder, Vector3::new(*radius, *radius, length / 2.0), 0.0, Point3::origin())
            }
            Shape::Hull { points } => {
                let hull = hull::corners(points)?;
                (Core::Hull(hull.corners), hull.half, 0.0, hull.middle)
            }
        };
        if !half.iter().chain([&rounding]).all(|size| size.is_finite() && *size >= 0.0) {
            return Err("every size must be a finite number of at least 0".into());
        }
        let core_radius = match &core {
            Core::Cylinder => half.x.hypot(half.z),
            Core::Hull(corners) => corners.iter().fold(0.0, |most: f64, p| most.max(p.norm())),
            _ => half.norm(),
        };
        Ok((Self { core, rounding, half, radius: core_radius + rounding }, origin))
    }

    /// The points of which a ball of radius `by` (m) fits into the solid; `None` if there are none, or if it is a mesh.
    pub fn shrunk(&self, by: f64) -> Option<Self> {
        let mut smaller = self.clone();
        match &self.core {
            Core::Point | Core::Segment => smaller.rounding -= by,
            Core::Box | Core::Cylinder => smaller.half -= Vector3::repeat(by),
            Core::Hull(_) => return None,
        }
        (smaller.rounding >= 0.0 && smaller.half.min() >= 0.0).then_some(smaller)
    }

    /// A farthest point of the core in a direction, both in the solid's axes.
    pub fn core_support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        match &self.core {
            Core::Point => Vector3::zeros(),
            Core::Segment => Vector3::new(0.0, 0.0, self.half.z.copysign(direction.z)),
            Core::Box => self.half.zip_map(direction, f64::copysign),
            Core::Cylinder => {
                let z = self.half.z.copysign(direction.z);
                let across = direction.x.hypot(direction.y);
                // Below this the scale overflows, and GJK asserts that supports are finite.
                if across > 1e-300 {
                    let scale = self.half.x / across;
                    Vector3::new(direction.x * scale, direction.y * scale, z)
                } else {
                    Vector3::new(self.half.x, 0.0, z)
                }
            }
            Core::Hull(corners) => hull::support(corners, direction),
        }
    }

    /// Greatest coordinate of the placed solid along a unit direction of the world (m).
    pub fn extent(&self, placed: &Placed, direction: &Vector3<f64>) -> f64 {
        let local = placed.rotation.tr_mul(direction);
        let of_core = match &self.core {
            Core::Point => 0.0,
            Core::Segment => self.half.z * local.z.abs(),
            Core::Box => self.half.dot(&local.abs()),
            Core::Cylinder => self.half.x * local.x.hypot(local.y) + self.half.z * local.z.abs(),
            Core::Hull(corners) => hull::extent(corners, &local),
        };
        placed.center.dot(direction) + of_core + self.rounding
    }

    /// Bound on the distance (m) of the solid's points from the line through `point` along the unit vector `axis`.
    pub fn distance_from_axis(&self, placed: &Placed, point: &Vector3<f64>, axis: &Vector3<f64>) -> f64 {
        (placed.center - point).cross(axis).norm() + self.radius_about(&placed.rotation.tr_mul(axis))
    }

    /// Bound on the distance (m) of the solid's points from the line through its origin along the unit vector `axis`,
    /// given in the solid's axes.
    fn radius_about(&self, axis: &Vector3<f64>) -> f64 {
        match &self.core {
            Core::Point => self.rounding,
            Core::Segment => self.rounding + self.half.z * axis.x.hypot(axis.y),
            // A disc and a segment: neither contributes more than its own.
            Core::Cylinder => (self.half.x + self.half.z * axis.x.hypot(axis.y)).min(self.radius),
            // All corners are equally far from the origin; that one counts which is the nearest to it along the axis.
            Core::Box | Core::Hull(_) => {
                let along = self.half.component_mul(&axis.abs());
                let longest = along.max();
                let least = (2.0 * longest - along.sum()).max(0.0);
                (self.half.norm_squared() - least * least).max(0.0).sqrt().min(self.radius)
            }
        }
    }

    /// Least and greatest corner of an axis-aligned box around the placed solid (m).
    pub fn bounds(&self, placed: &Placed) -> (Vector3<f64>, Vector3<f64>) {
        let mut least = Vector3::zeros();
        let mut greatest = Vector3::zeros();
        for (i, axis) in [Vector3::x(), Vector3::y(), Vector3::z()].iter().enumerate() {
            least[i] = -self.extent(placed, &-axis);
            greatest[i] = self.extent(placed, axis);
        }
        (least, greatest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(shape: &Shape) -> Solid {
        Solid::new(shape).unwrap().0
    }

    #[test]
    fn an_upright_box_is_as_far_from_a_vertical_axis_through_it_as_its_footprint_reaches() {
        let tall = solid(&Shape::Box { size: [0.6, 0.8, 3.0] });
        let at = Placed { rotation: Matrix3::identity(), center: Vector3::new(1.0, 2.0, 0.0) };
        let far = tall.distance_from_axis(&at, &Vector3::new(1.0, 2.0, 7.0), &Vector3::z());
        assert!((far - 0.5).abs() < 1e-12, "{far}");
    }

    #[test]
    fn a_box_about_a_slanted_axis_is_bounded_by_its_farthest_corner() {
        let half = Vector3::new(0.1, 0.2, 0.5);
        let body = solid(&Shape::Box { size: [0.2, 0.4, 1.0] });
        for axis in [Vector3::new(1.0, 1.0, 1.0), Vector3::new(0.0, 1.0, 0.4), Vector3::new(-1.0, 0.2, 3.0)] {
            let axis = axis.normalize();
            let exact = (0..8).fold(0.0, |most: f64, i| {
                let sign = |bit: i32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
                let corner = half.component_mul(&Vector3::new(sign(0), sign(1), sign(2)));
                most.max(corner.cross(&axis).norm())
            });
            assert!((body.radius_about(&axis) - exact).abs() < 1e-9);
        }
    }

    #[test]
    fn supports_are_finite_along_directions_that_all_but_vanish() {
        let pole = solid(&Shape::Cylinder { radius: 0.2, length: 1.0 });
        for direction in [Vector3::new(1e-310, 0.0, 1.0), Vector3::new(0.0, -5e-324, -1.0), Vector3::zeros()] {
            assert!(pole.core_support(&direction).iter().all(|c| c.is_finite()), "{direction:?}");
        }
    }

    #[test]
    fn sizes_that_are_not_numbers_are_refused() {
        assert!(Solid::new(&Shape::Sphere { radius: f64::NAN }).is_err());
        assert!(Solid::new(&Shape::Box { size: [1.0, -1.0, 1.0] }).is_err());
        assert!(Solid::new(&Shape::Hull { points: vec![] }).is_err());
        assert!(Solid::new(&Shape::Hull { points: vec![Point3::new(0.0, f64::INFINITY, 0.0)] }).is_err());
    }
}
