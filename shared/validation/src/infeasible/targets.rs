//! Where a hand would have to be at one end of a pair, over all poses that the object may have there.

use glamx::{DVec2, DVec3};
use model::{Grasp, MovableObject, Problem};
use plan::PairEnd;

use crate::contact::{ATTACH_ANGLE, ATTACH_DISTANCE, UPRIGHT};
use crate::frame::Frame;
use crate::infeasible::named::PairAt;
use crate::infeasible::room::Rectangle;
use crate::solid::Solid;

/// Directions in which a footprint is measured.
const DIRECTIONS: usize = 720;
/// Allowance for rounding (m).
const ROUNDING: f64 = 1e-6;

/// Poses that an object may have at one end of a pair.
pub(crate) enum Poses {
    /// It stands where the problem says.
    Start(Frame),
    /// It is upright, anywhere in a region.
    Within(Patch),
}

/// Origins of an upright object in a region; the yaw is free.
pub(crate) struct Patch {
    pub(crate) rectangle: Rectangle,
    /// Half edge lengths of a rectangle, parallel to the region's, that holds all origins (m).
    pub(crate) half: DVec2,
    /// Height of the origin (m), and how far it may be off.
    pub(crate) height: f64,
    pub(crate) tolerance: f64,
}

impl Poses {
    pub(crate) fn of(problem: &Problem, at: &PairAt) -> Result<Self, String> {
        let object = &problem.movable[at.pair.object.index()];
        let first = problem.hops_of_object(at.pair.object).first().map(|hop| problem.pair(*hop));
        if at.end == PairEnd::Pick && first.is_some_and(|first| std::ptr::eq(first, at.pair)) {
            return Ok(Self::Start(Frame::of(&object.world_from_start)));
        }
        let region = &problem.regions[at.region.index()];
        let rectangle =
            Rectangle::of(region, &problem.settings).ok_or_else(|| format!("{} is not level", region.name))?;
        let solid = Solid::new(&object.body);
        let lowest = -solid.height_along(&solid.owner_from_shape, -DVec3::Z);
        Ok(Self::Within(Patch {
            half: (rectangle.half - DVec2::splat(narrowest(object))).max(DVec2::ZERO) + DVec2::splat(ROUNDING),
            height: rectangle.height - lowest,
            tolerance: problem.settings.support_tolerance + ROUNDING,
            rectangle,
        }))
    }
}

/// A lower bound of how far the object reaches from its origin in every horizontal direction (m); negative if the origin
/// is not inside of the footprint.
fn narrowest(object: &MovableObject) -> f64 {
    let solid = Solid::new(&object.body);
    let step = std::f64::consts::TAU / DIRECTIONS as f64;
    let reach = |i: usize| {
        let (sin, cos) = (step * i as f64).sin_cos();
        solid.height_along(&solid.owner_from_shape, DVec3::new(cos, sin, 0.0))
    };
    let least = (0..DIRECTIONS).map(reach).fold(f64::INFINITY, f64::min);
    least - step * (solid.centre.length() + solid.radius)
}

/// What the checker's tolerances at an attach and a release let a point of the hand be off (m): one for the hand against
/// the object where it stands, one for the hold against the listed grasp. `lever` is its distance from the object's origin.
pub(crate) fn hand_slack(lever: f64) -> f64 {
    2.0 * ATTACH_DISTANCE + (2.0 * ATTACH_ANGLE + UPRIGHT) * (lever + 2.0 * ATTACH_DISTANCE) + ROUNDING
}

/// Places of the hand's origin under one grasp, in the frame of the robot's base: level.
pub(crate) struct Targets {
    centre: DVec2,
    axes: [DVec2; 2],
    half: DVec2,
    /// Radius of the circle on which the hand is as the object turns (m).
    swing: f64,
    heights: (f64, f64),
    slack: f64,
}

impl Targets {
    pub(crate) fn of(poses: &Poses, grasp: &Grasp, base_from_world: &Frame) -> Self {
        let object_from_hand = Frame::of(&grasp.link_from_object).inverse().origin;
        let slack = hand_slack(object_from_hand.length());
        match poses {
            Poses::Start(world_from_object) => {
                let hand = base_from_world.point(world_from_object.point(object_from_hand));
                let heights = (hand.z, hand.z);
                let (centre, axes) = (hand.truncate(), [DVec2::X, DVec2::Y]);
                Self { centre, axes, half: DVec2::ZERO, swing: 0.0, heights, slack }
            }
            Poses::Within(patch) => {
                let world_from_region = &patch.rectangle.world_from_region;
                let origin = base_from_world.point(world_from_region.origin.with_z(patch.height));
                let axis = |axis: DVec3| (base_from_world.rotation * axis).truncate().normalize_or(DVec2::X);
                let height = origin.z + object_from_hand.z;
                Self {
                    centre: origin.truncate(),
                    axes: [axis(world_from_region.rotation.x_axis), axis(world_from_region.rotation.y_axis)],
                    half: patch.half,
                    swing: object_from_hand.truncate().length(),
                    heights: (height - patch.tolerance, height + patch.tolerance),
                    slack,
                }
            }
        }
    }

    /// No place of the hand is nearer (m) than this to a point at `height` that is within `spread` of `from`.
    pub(crate) fn nearest(&self, from: DVec2, spread: f64, height: f64) -> f64 {
        let off = self.axes.map(|axis| axis.dot(from - self.centre).abs());
        let outside = (DVec2::from(off) - self.half).max(DVec2::ZERO).length();
        let across = (outside - self.swing - spread).max(0.0);
        let up = (self.heights.0 - height).max(height - self.heights.1).max(0.0);
        across.hypot(up) - self.slack
    }

    /// No place of the hand is farther (m) than this from a point at `height` that is within `spread` of `from`.
    pub(crate) fn farthest(&self, from: DVec2, spread: f64, height: f64) -> f64 {
        let off = self.axes.map(|axis| axis.dot(from - self.centre).abs());
        let across = (DVec2::from(off) + self.half).length() + self.swing + spread;
        let up = (height - self.heights.0).abs().max((self.heights.1 - height).abs());
        across.hypot(up) + self.slack
    }
}
