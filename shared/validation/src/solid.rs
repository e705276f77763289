//! Convex bodies and certified distances between them.

use glamx::{DQuat, DVec3};
use model::{Body, Shape};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;

use crate::frame::Frame;

/// What remains of a shape when its rounding is taken off.
#[derive(Clone, Debug)]
enum Core {
    Point,
    /// Along z.
    Segment {
        half: f64,
    },
    Box {
        half: DVec3,
    },
    /// Along z.
    Cylinder {
        radius: f64,
        half: f64,
    },
    Hull {
        points: Vec<DVec3>,
    },
}

/// A convex body: a core grown by a radius, placed in its owner's frame.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    core: Core,
    rounding: f64,
    pub(crate) owner_from_shape: Frame,
    /// Centre of a bounding sphere, in the owner's frame.
    pub(crate) centre: DVec3,
    /// Radius of that sphere.
    pub(crate) radius: f64,
}

/// Outcome of a distance query at one instant.
pub(crate) enum Separation {
    /// The cores are apart: unit axis from the first body to the second, and distance of the bodies as the query measured
    /// it (m), below 0 where their roundings overlap.
    Apart(DVec3, f64),
    /// The cores touch or overlap.
    Touching,
    /// The query did not converge.
    Unknown,
}

fn corner(p: &nalgebra::Point3<f64>) -> DVec3 {
    DVec3::new(p.x, p.y, p.z)
}

impl Solid {
    pub(crate) fn new(body: &Body) -> Self {
        let (core, rounding) = match &body.shape {
            Shape::Box { size: [x, y, z] } => (Core::Box { half: DVec3::new(x / 2.0, y / 2.0, z / 2.0) }, 0.0),
            Shape::Sphere { radius } => (Core::Point, *radius),
            Shape::Cylinder { radius, length } => (Core::Cylinder { radius: *radius, half: length / 2.0 }, 0.0),
            Shape::Capsule { radius, length } => (Core::Segment { half: length / 2.0 }, *radius),
            Shape::Hull { points } => (Core::Hull { points: points.iter().map(corner).collect() }, 0.0),
        };
        let owner_from_shape = Frame::of(&body.owner_from_shape);
        let (middle, extent) = core.bounding_sphere();
        Self { core, rounding, owner_from_shape, centre: owner_from_shape.point(middle), radius: extent + rounding }
    }

    /// Greatest value of `direction · x` over the body, for the shape's own frame placed at `frame`.
    pub(crate) fn height_along(&self, frame: &Frame, direction: DVec3) -> f64 {
        let local = frame.rotation.transpose() * direction;
        direction.dot(frame.origin) + self.core.height_along(local) + self.rounding * direction.length()
    }

    /// Upper bound of the gap is the distance; a positive gap along any unit axis proves the bodies apart by that much.
    pub(crate) fn gap_along(&self, frame: &Frame, other: &Solid, other_frame: &Frame, axis: DVec3) -> f64 {
        -other.height_along(other_frame, -axis) - self.height_along(frame, axis)
    }

    /// Distance by GJK on the cores, started along `axis` (world, from `self` to `other`).
    pub(crate) fn separation(&self, frame: &Frame, other: &Solid, other_frame: &Frame, axis: DVec3) -> Separation {
        let relative = frame.inverse() * *other_frame;
        let pose12 = Pose::from_parts(relative.origin, DQuat::from_mat3(&relative.rotation));
        let start = frame.rotation.transpose() * -axis;
        let mut simplex = VoronoiSimplex::new();
        simplex.reset(CsoPoint::from_shapes(&pose12, &self.core, &other.core, start));
        match gjk::closest_points(&pose12, &self.core, &other.core, f64::MAX, true, &mut simplex) {
            GJKResult::ClosestPoints(p1, p2, normal) => {
                let between = p2 - p1;
                let local = if between.length() > 1e-9 { between.normalize() } else { normal };
                let distance = between.length() - self.rounding - other.rounding;
                Separation::Apart(frame.rotation * local, distance)
            }
            GJKResult::Intersection => Separation::Touching,
            GJKResult::Proximity(_) | GJKResult::NoIntersection(_) => Separation::Unknown,
        }
    }

    /// Certified lower bound of the distance (m): the gap along the best axis that is found; at most 0 if they may touch.
    pub(crate) fn certified_gap(&self, frame: &Frame, other: &Solid, other_frame: &Frame) -> f64 {
        let between = other_frame.point(other.owner_from_shape.inverse().point(other.centre))
            - frame.point(self.owner_from_shape.inverse().point(self.centre));
        let axis = between.normalize_or(DVec3::Z);
        let straight = self.gap_along(frame, other, other_frame, axis);
        match self.separation(frame, other, other_frame, axis) {
            Separation::Apart(axis, _) => straight.max(self.gap_along(frame, other, other_frame, axis)),
            Separation::Touching | Separation::Unknown => straight,
        }
    }

    /// How far the bodies would have to be moved apart (m), for messages: least overlap over axes of both and diagonals.
    pub(crate) fn depth(&self, frame: &Frame, other: &Solid, other_frame: &Frame) -> f64 {
        let mut axes: Vec<DVec3> = Vec::new();
        for rotation in [frame.rotation, other_frame.rotation] {
            axes.extend([rotation.x_axis, rotation.y_axis, rotation.z_axis]);
        }
        for i in 0..27 {
            let step = |digit: i32| f64::from(i / digit % 3 - 1);
            axes.extend(DVec3::new(step(1), step(3), step(9)).try_normalize());
        }
        let overlap = |axis: DVec3| -self.gap_along(frame, other, other_frame, axis);
        axes.into_iter().flat_map(|axis| [axis, -axis]).map(overlap).fold(f64::MAX, f64::min).max(0.0)
    }
}

impl Core {
    fn height_along(&self, d: DVec3) -> f64 {
        match self {
            Core::Point => 0.0,
            Core::Segment { half } => d.z.abs() * half,
            Core::Box { half } => d.abs().dot(*half),
            Core::Cylinder { radius, half } => d.x.hypot(d.y) * radius + d.z.abs() * half,
            Core::Hull { points } => points.iter().fold(f64::MIN, |most, p| most.max(p.dot(d))),
        }
    }

    fn bounding_sphere(&self) -> (DVec3, f64) {
        match self {
            Core::Point => (DVec3::ZERO, 0.0),
            Core::Segment { half } => (DVec3::ZERO, *half),
            Core::Box { half } => (DVec3::ZERO, half.length()),
            Core::Cylinder { radius, half } => (DVec3::ZERO, radius.hypot(*half)),
            Core::Hull { points } => {
                let low = points.iter().fold(DVec3::MAX, |a, b| a.min(*b));
                let high = points.iter().fold(DVec3::MIN, |a, b| a.max(*b));
                let middle = (low + high) / 2.0;
                (middle, points.iter().fold(0.0, |most, p| p.distance(middle).max(most)))
            }
        }
    }
}

impl SupportMap for Core {
    fn local_support_point(&self, dir: Vector) -> Vector {
        match self {
            Core::Point => Vector::ZERO,
            Core::Segment { half } => Vector::new(0.0, 0.0, half.copysign(dir.z)),
            Core::Box { half } => half.copysign(dir),
            Core::Cylinder { radius, half } => {
                let across = Vector::new(dir.x, dir.y, 0.0).normalize_or_zero() * *radius;
                Vector::new(across.x, across.y, half.copysign(dir.z))
            }
            Core::Hull { points } => {
                let mut best = (f64::MIN, Vector::ZERO);
                for p in points {
                    let height = p.dot(dir);
                    if height > best.0 {
                        best = (height, *p);
                    }
                }
                best.1
            }
        }
    }
}

#[cfg(test)]
mod tests;
