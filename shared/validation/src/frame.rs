//! Rigid transforms as rotation matrix and origin.

use glamx::{DMat3, DQuat, DVec3};
use model::Pose;

/// Takes coordinates in one frame to another's (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) rotation: DMat3,
    pub(crate) origin: DVec3,
}

impl Frame {
    pub(crate) const IDENTITY: Frame = Frame { rotation: DMat3::IDENTITY, origin: DVec3::ZERO };

    pub(crate) fn of(pose: &Pose) -> Self {
        let (t, q) = (pose.translation.vector, pose.rotation.coords);
        let rotation = DMat3::from_quat(DQuat::from_xyzw(q.x, q.y, q.z, q.w).normalize());
        Self { rotation, origin: DVec3::new(t.x, t.y, t.z) }
    }

    pub(crate) fn turned(axis: DVec3, angle: f64) -> Self {
        Self { rotation: DMat3::from_axis_angle(axis, angle), origin: DVec3::ZERO }
    }

    pub(crate) fn shifted(origin: DVec3) -> Self {
        Self { rotation: DMat3::IDENTITY, origin }
    }

    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.origin
    }

    pub(crate) fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, origin: -(rotation * self.origin) }
    }

    /// Distance of the origins (m) and angle of the rotation (rad) between two frames.
    pub(crate) fn difference(&self, other: &Frame) -> (f64, f64) {
        let d = self.rotation - other.rotation;
        let squares = d.x_axis.length_squared() + d.y_axis.length_squared() + d.z_axis.length_squared();
        // ‖R − S‖ = 2√2 sin(angle / 2): well conditioned at small angles, where the arc cosine of a trace is not.
        let angle = 2.0 * (squares.sqrt() / 8.0_f64.sqrt()).min(1.0).asin();
        ((self.origin - other.origin).length(), angle)
    }
}

impl std::ops::Mul for Frame {
    type Output = Frame;

    fn mul(self, inner: Frame) -> Frame {
        Frame { rotation: self.rotation * inner.rotation, origin: self.point(inner.origin) }
    }
}
