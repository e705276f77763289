//! Where the origin of the hand's link would have to be under one grasp.

use model::{Grasp, Pose};
use nalgebra::{Point3, Vector2};

use super::poses::Poses;

/// What a plan may be off and still be accepted: twice 1 mm, and twice 0.2° at the lever of the hand; rounded up.
const OFF_M: f64 = 2.2e-3;
const OFF_RAD: f64 = 7.5e-3;

/// All places of the hand's origin, in the base's frame: an upright box round which it may swing.
pub(super) struct Target {
    centre: Vector2<f64>,
    axes: [Vector2<f64>; 2],
    half: Vector2<f64>,
    /// Horizontal distance of the hand from the object's origin, where the yaw is free (m).
    swing: f64,
    /// Heights between which it is (m).
    heights: [f64; 2],
    /// How far it may be off (m).
    off: f64,
}

impl Target {
    pub fn of(poses: &Poses, grasp: &Grasp, base_from_world: &Pose) -> Self {
        let object_from_hand = grasp.link_from_object.inverse().translation.vector;
        let off = OFF_M + OFF_RAD * object_from_hand.norm();
        match poses {
            Poses::Start(world_from_object) => {
                let hand = base_from_world * world_from_object * Point3::from(object_from_hand);
                Self {
                    centre: hand.coords.xy(),
                    axes: [Vector2::x(), Vector2::y()],
                    half: Vector2::zeros(),
                    swing: 0.0,
                    heights: [hand.z; 2],
                    off,
                }
            }
            Poses::Region(patch) => {
                let base_from_patch = base_from_world * patch.world_from_patch;
                let turned = base_from_patch.rotation.to_rotation_matrix();
                let axis = |i: usize| turned.matrix().fixed_view::<2, 1>(0, i).normalize();
                let height = base_from_patch.translation.z + object_from_hand.z;
                Self {
                    centre: base_from_patch.translation.vector.xy(),
                    axes: [axis(0), axis(1)],
                    half: Vector2::from(patch.half),
                    swing: object_from_hand.xy().norm(),
                    heights: [height - patch.tolerance, height + patch.tolerance],
                    off,
                }
            }
        }
    }

    /// Offsets of a point from the centre, along the box's axes (m, absolute).
    fn offsets(&self, [x, y, _]: [f64; 3]) -> Vector2<f64> {
        let from_centre = Vector2::new(x, y) - self.centre;
        Vector2::from(self.axes.map(|axis| axis.dot(&from_centre).abs()))
    }

    /// Lower bound (m) on the distance from anywhere within `spread` of a point.
    pub fn nearest(&self, from: [f64; 3], spread: f64) -> f64 {
        let outside = (self.offsets(from) - self.half).sup(&Vector2::zeros()).norm();
        let level = (outside - self.swing - spread).max(0.0);
        let up = (self.heights[0] - from[2]).max(from[2] - self.heights[1]).max(0.0);
        level.hypot(up) - self.off
    }

    /// Upper bound (m) on the distance from anywhere within `spread` of a point.
    pub fn farthest(&self, from: [f64; 3], spread: f64) -> f64 {
        let level = (self.offsets(from) + self.half).norm() + self.swing + spread;
        let up = (from[2] - self.heights[0]).abs().max((self.heights[1] - from[2]).abs());
        level.hypot(up) + self.off
    }
}
