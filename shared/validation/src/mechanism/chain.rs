//! The joints between a robot's root and one link, as lines and ranges.

use glamx::DVec3;
use model::{LinkId, Robot};

use super::{Mechanism, Motion, Posture};
use crate::frame::Frame;

/// A joint that moves, with everything in the root link's frame while all coordinates are 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub(crate) point: DVec3,
    pub(crate) direction: DVec3,
    /// Whether it turns; else it slides.
    pub(crate) turns: bool,
    /// Least and greatest value relative to that at coordinates 0 (rad or m).
    pub(crate) range: (f64, f64),
}

impl Mechanism {
    /// The joints that can move `link` against the root, the root's first, and the link's origin.
    pub(crate) fn chain(&self, robot: &Robot, link: LinkId) -> (Vec<Axis>, DVec3) {
        let mut posture = Posture::default();
        self.place(&vec![0.0; robot.coordinates.len()], 0.0, &mut posture);
        let root_from_world = posture.links[0].inverse();
        let axis = |joint: &usize| {
            let value = self.joints[*joint].value;
            let ends = match value.coordinate.filter(|_| value.slope != 0.0).map(|c| &robot.coordinates[c]) {
                Some(coordinate) => [value.slope * coordinate.lower, value.slope * coordinate.upper],
                None => [0.0, value.per_opening * robot.end_effector.max_opening],
            };
            let turns = match self.joints[*joint].motion {
                Motion::Fixed => return None,
                Motion::Revolute(_) => true,
                Motion::Prismatic(_) => false,
            };
            let (point, direction) = posture.axes[*joint];
            let (point, direction) = (root_from_world.point(point), root_from_world.rotation * direction);
            Some(Axis { point, direction, turns, range: (ends[0].min(ends[1]), ends[0].max(ends[1])) })
        };
        let axes = self.paths[link.index()].iter().filter_map(axis).collect();
        (axes, root_from_world.point(posture.links[link.index()].origin))
    }

    /// Frames of the links that ride with `hand`, in the hand's frame: those that nothing but the opening moves against it.
    pub(crate) fn riding_with(&self, robot: &Robot, hand: LinkId, opening: f64) -> Vec<(LinkId, Frame)> {
        let mut posture = Posture::default();
        self.place(&vec![0.0; robot.coordinates.len()], opening, &mut posture);
        let hand_from_world = posture.links[hand.index()].inverse();
        let is_planned = |joint: &usize| {
            self.joints[*joint].value.coordinate.is_some() && !matches!(self.joints[*joint].motion, Motion::Fixed)
        };
        let rides = |link: &LinkId| {
            let between = self.path_beyond(hand, *link).iter().chain(self.path_beyond(*link, hand));
            !between.into_iter().any(is_planned)
        };
        let links = (0..self.links).map(LinkId::at).filter(rides);
        links.map(|link| (link, hand_from_world * posture.links[link.index()])).collect()
    }
}
