//! Poses that an object may have at one end of a pair.

use std::f64::consts::TAU;

use model::{ObjectId, Pair, Pose};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use plan::PairEnd;

use super::floor::is_level;
use crate::Geometry;
use crate::solid::{Placed, Solid};

/// Directions in which a footprint is measured.
const DIRECTIONS: u32 = 360;

/// Poses of a standing object.
pub(super) enum Poses {
    /// Its start pose.
    Start(Pose),
    /// Anywhere in a region, upright, at any yaw.
    Region(Patch),
}

/// Where the origin of an object may be in a region.
pub(super) struct Patch {
    /// The region's frame, raised to the height of the object's origin.
    pub world_from_patch: Pose,
    /// Half edges of the rectangle that the footprint must stay in (m).
    pub free: [f64; 2],
    /// Half edges of one that holds all origins (m).
    pub half: [f64; 2],
    /// How far it may be higher or lower (m).
    pub tolerance: f64,
}

impl Poses {
    /// `None` for a region that is not level.
    pub fn of(geometry: &Geometry, pair: &Pair, end: PairEnd) -> Option<Self> {
        let problem = geometry.problem();
        let object = &problem.movable[pair.object.index()];
        if end == PairEnd::Pick
            && problem.hops_of_object(pair.object).iter().all(|hop| problem.pair(*hop).hop >= pair.hop)
        {
            return Some(Self::Start(object.world_from_start));
        }
        let region = &problem.regions[if end == PairEnd::Pick { pair.from } else { pair.to }.index()];
        let lift = Translation3::new(0.0, 0.0, object.origin_height());
        let free = region.size.map(|edge| edge / 2.0 - problem.settings.region_margin);
        let inner = least_extent(geometry, pair.object);
        is_level(&region.world_from_region).then(|| {
            Self::Region(Patch {
                world_from_patch: lift * region.world_from_region,
                free,
                half: free.map(|free| (free - inner).max(0.0) + 1e-5),
                tolerance: problem.settings.support_tolerance,
            })
        })
    }
}

impl Patch {
    /// The object's pose with its origin at `u`, `v` (m) and turned by `yaw` (rad).
    pub fn pose(&self, u: f64, v: f64, yaw: f64) -> Pose {
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
        self.world_from_patch * Pose::from_parts(Translation3::new(u, v, 0.0), turned)
    }
}

/// How far an object reaches from its origin in each horizontal direction, at least (m).
fn least_extent(geometry: &Geometry, object: ObjectId) -> f64 {
    let (solid, placed) = own_solid(geometry, object, &Pose::identity());
    let farthest = placed.center.norm() + solid.radius;
    let extent = |i: u32| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(DIRECTIONS)).sin_cos();
        solid.extent(&placed, &Vector3::new(cos, sin, 0.0))
    };
    (0..DIRECTIONS).map(extent).fold(f64::INFINITY, f64::min) - farthest * TAU / f64::from(DIRECTIONS)
}

/// An object's solid where the object stands.
pub(super) fn own_solid<'a>(geometry: &'a Geometry, object: ObjectId, world_from_object: &Pose) -> (&'a Solid, Placed) {
    let (solid, object_from_solid) = geometry.object_solid(object);
    (solid, Placed::at(&(world_from_object * object_from_solid)))
}
