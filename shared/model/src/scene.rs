//! Fixed objects, movable objects and workspace regions.

use serde::{Deserialize, Serialize};

use crate::{Body, FixedId, Grasp, GraspId, Pose, RobotId};

/// Something that never moves: one or more convex bodies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedObject {
    /// Unique name.
    pub name: String,
    /// Takes the object's frame to the world's.
    pub world_from_object: Pose,
    /// Convex bodies in the object's frame.
    pub bodies: Vec<Body>,
}

/// Something that robots pick and place: one convex body, upright, with free yaw when it stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MovableObject {
    /// Unique name.
    pub name: String,
    /// Convex body in the object's frame; the object's z axis points up when it stands.
    pub body: Body,
    /// Where it stands at the start.
    pub world_from_start: Pose,
    /// The fixed object that it stands on at the start.
    pub start_support: Option<FixedId>,
    /// Grasps, for each robot (indexed by [`RobotId`]), in canonical order; none for robots that no pair has carry it.
    pub grasps: Vec<Vec<Grasp>>,
}

impl MovableObject {
    /// One grasp of one robot.
    #[must_use]
    pub fn grasp(&self, robot: RobotId, grasp: GraspId) -> &Grasp {
        &self.grasps[robot.index()][grasp.index()]
    }

    /// Height of the object's origin above its lowest point when it stands upright (m).
    #[must_use]
    pub fn origin_height(&self) -> f64 {
        let lowest = self
            .body
            .shape
            .support_points()
            .iter()
            .fold(f64::MAX, |least, p| least.min((self.body.owner_from_shape * p).z));
        self.body.shape.rounding() - lowest
    }

    /// Corners, in the object's frame, of the convex footprint seen from above (m); its hull counts.
    #[must_use]
    pub fn footprint(&self) -> Vec<[f64; 2]> {
        let rounding = self.body.shape.rounding();
        self.body
            .shape
            .support_points()
            .iter()
            .flat_map(|p| {
                let p = self.body.owner_from_shape * p;
                [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
                    .map(|(x, y)| [p.x + x * rounding, p.y + y * rounding])
            })
            .collect()
    }
}

/// A workspace region: a rectangle on top of a fixed object on which objects may stand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Unique name.
    pub name: String,
    /// Region frame: origin at the rectangle's centre, z up, at the height of the support surface.
    pub world_from_region: Pose,
    /// Full edge lengths along the region's x and y (m).
    pub size: [f64; 2],
    /// The fixed object whose surface it lies on; a standing object may touch it.
    pub support: FixedId,
}
