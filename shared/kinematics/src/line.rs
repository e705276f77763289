//! Directed lines in space: the axes of joints.

use nalgebra::{Matrix3, Point3, Unit, UnitQuaternion, Vector3};

/// A directed line; for a sliding joint only its direction matters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// A point on the line (m).
    pub point: Point3<f64>,
    /// Unit direction.
    pub axis: Vector3<f64>,
}

impl Line {
    /// Vector to `point` from its foot on the line (m).
    pub fn to(&self, point: &Point3<f64>) -> Vector3<f64> {
        perpendicular(&(point - self.point), &self.axis)
    }

    /// Where `point` comes to when it turns about the line by `angle` (rad).
    pub fn turn(&self, point: &Point3<f64>, angle: f64) -> Point3<f64> {
        self.point + rotation(&self.axis, angle) * (point - self.point)
    }
}

/// Rotation about a unit axis by `angle` (rad).
pub(crate) fn rotation(axis: &Vector3<f64>, angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Unit::new_unchecked(*axis), angle)
}

/// The part of `vector` at right angles to the unit vector `axis`.
pub(crate) fn perpendicular(vector: &Vector3<f64>, axis: &Vector3<f64>) -> Vector3<f64> {
    vector - axis * axis.dot(vector)
}

/// Signed angle (rad) about the unit vector `axis` that brings `from` above `to`, seen along the axis.
pub(crate) fn angle_about(axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    // Perpendicular parts first: both vectors may lie almost along the axis.
    let (from, to) = (perpendicular(from, axis), perpendicular(to, axis));
    axis.dot(&from.cross(&to)).atan2(from.dot(&to))
}

/// The point nearest to all lines in the least-squares sense and its greatest distance from one (m); none if all are parallel.
pub(crate) fn meeting_point(lines: &[Line]) -> Option<(Point3<f64>, f64)> {
    let mut normal = Matrix3::zeros();
    let mut moment = Vector3::zeros();
    for line in lines {
        let across = Matrix3::identity() - line.axis * line.axis.transpose();
        normal += across;
        moment += across * line.point.coords;
    }
    let point = Point3::from(normal.try_inverse()? * moment);
    let miss = lines.iter().map(|line| line.to(&point).norm()).fold(0.0, f64::max);
    point.coords.iter().all(|x| x.is_finite()).then_some((point, miss))
}
