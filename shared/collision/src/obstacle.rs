//! Bodies that stand still in the world.

use std::sync::Arc;

use model::Pose;
use nalgebra::Vector3;

use crate::BodyName;
use crate::separation::Posed;
use crate::solid::{Placed, Solid};

/// A convex body standing in the world.
#[derive(Clone, Debug)]
pub(crate) struct Obstacle {
    pub name: BodyName,
    pub solid: Arc<Solid>,
    pub placed: Placed,
    /// Least corner of its axis-aligned bounds (m).
    pub least: Vector3<f64>,
    /// Greatest corner (m).
    pub greatest: Vector3<f64>,
}

impl Obstacle {
    /// A solid at a pose.
    pub fn new(name: BodyName, solid: &Arc<Solid>, world_from_solid: &Pose) -> Self {
        let placed = Placed::at(world_from_solid);
        let (least, greatest) = solid.bounds(&placed);
        Self { name, solid: Arc::clone(solid), placed, least, greatest }
    }

    /// Its solid and pose.
    pub fn posed(&self) -> Posed<'_> {
        (&self.solid, &self.placed)
    }

    /// Whether a ball about `center` stays outside of its bounds.
    pub fn clear_of_ball(&self, center: &Vector3<f64>, radius: f64) -> bool {
        let outside = (self.least - center).sup(&(center - self.greatest)).sup(&Vector3::zeros());
        outside.norm_squared() >= radius * radius
    }

    /// Whether a solid whose lowest point is at height `bottom` (m) touches its top from above: not lower than `below`
    /// under it, and nearer than `above`.
    pub fn carries(&self, bottom: f64, below: f64, above: f64) -> bool {
        let gap = bottom - self.greatest.z;
        gap >= -below && gap < above
    }
}
