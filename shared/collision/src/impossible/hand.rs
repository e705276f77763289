//! The hand round an object: bodies that ride with it, and what they may be off.

use model::{Grasp, ObjectId, Pose, RobotId};

use super::poses::own_solid;
use crate::Geometry;
use crate::solid::{Placed, Solid};

/// What a plan may be off and still be accepted: twice 1 mm, and twice 0.2° at the lever; rounded up.
const OFF_M: f64 = 2.2e-3;
const OFF_RAD: f64 = 7.5e-3;

/// A solid that moves with an object.
pub(super) struct Rider {
    pub solid: Solid,
    pub object_from_solid: Pose,
    /// How far its points may be off (m).
    pub off: f64,
    /// Farthest that they are from the object's z axis (m).
    pub swing: f64,
}

impl Rider {
    fn new(solid: &Solid, object_from_solid: Pose, off: f64, off_rad: f64) -> Self {
        let origin = object_from_solid.translation.vector;
        let off = off + off_rad * (origin.norm() + solid.radius);
        Self { solid: solid.clone(), object_from_solid, off, swing: origin.xy().norm() + solid.radius }
    }

    pub fn placed(&self, world_from_object: &Pose) -> Placed {
        Placed::at(&(world_from_object * self.object_from_solid))
    }
}

/// The bodies of the links that only the opening moves against the hand's link, open as before an attach and as while
/// holding: the hand is at the same place in both states.
pub(super) fn hand(geometry: &Geometry, robot: RobotId, grasp: &Grasp) -> Vec<Rider> {
    let model = geometry.problem().robot(robot);
    let (shape, link) = (geometry.robot_shape(robot), model.end_effector.parent_link.index());
    let still = vec![0.0; model.coordinates.len()];
    let mut riders = Vec::new();
    for opening in [model.end_effector.max_opening, grasp.opening] {
        let poses = kinematics::link_poses(model, &still, opening);
        let rides = shape.bodies.iter().filter(|body| shape.chains[body.link.index()] == shape.chains[link]);
        riders.extend(rides.map(|body| {
            let hand_from_solid = poses[link].inverse() * poses[body.link.index()] * body.link_from_solid;
            Rider::new(&body.solid, grasp.link_from_object.inverse() * hand_from_solid, OFF_M, OFF_RAD)
        }));
    }
    riders
}

/// The object itself: it may sink into what it stands on by the tolerance, and stand as much lower.
pub(super) fn object(geometry: &Geometry, object: ObjectId) -> Rider {
    let (solid, _) = own_solid(geometry, object, &Pose::identity());
    let (_, object_from_solid) = geometry.object_solid(object);
    Rider::new(solid, *object_from_solid, 2.0 * geometry.problem().settings.support_tolerance + 1e-4, 1e-5)
}
