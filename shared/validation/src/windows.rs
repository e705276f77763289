//! When contact is allowed (rule V12): hand and object about a grasp or release, object and support about a pick or place.

use glamx::DVec3;

use crate::contact::{ATTACH_ANGLE, ATTACH_DISTANCE};
use crate::mechanism::Posture;
use crate::script::{Script, Step};
use crate::solid::Solid;
use crate::timeline::{Hold, Timeline};

/// Way of the tool frame's origin (m) before an attach, and after a detach, on which the hand may touch the object.
const HAND_WAY: f64 = 0.20;
/// Height (m) above its support below which a held object may touch it.
const SUPPORT_HEIGHT: f64 = 0.03;

/// The stretches of time (s) on which one hold allows contacts.
pub(crate) struct Windows {
    /// Hand and object before the attach.
    pub(crate) approach: (f64, f64),
    /// Hand and object after the detach.
    pub(crate) retreat: (f64, f64),
    /// Held object and what it stood on.
    pub(crate) lift: (f64, f64),
    /// Held object and what it will stand on.
    pub(crate) lower: (f64, f64),
}

const NEVER: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

impl Windows {
    /// Windows of the hold with this index.
    pub(crate) fn of(script: &Script, timeline: &Timeline, hold: usize) -> Self {
        let this = &timeline.holds[hold];
        let own = || timeline.holds.iter().filter(|other| other.robot == this.robot);
        let previous = own().map(|other| other.to).filter(|to| *to <= this.from).fold(0.0, f64::max);
        let next = own().map(|other| other.from).filter(|from| *from >= this.to).fold(script.horizon(), f64::min);
        let until = this.to.min(script.horizon());
        let attach = &script.steps[this.attach];
        let floor = |standing: usize| bottom(script, timeline, standing);
        let before = timeline.standings.iter().position(|s| s.taken_by == Some(hold));
        let after = timeline.standings.iter().position(|s| s.put_by == Some(hold));
        Self {
            approach: (hand_way(script, attach, this.from, previous), this.from),
            retreat: if this.detach.is_some() { (this.to, hand_way(script, attach, this.to, next)) } else { NEVER },
            lift: before.map_or(NEVER, |s| (this.from, near_support(script, this, floor(s), this.from, until))),
            lower: after.map_or(NEVER, |s| (near_support(script, this, floor(s), until, this.from), until)),
        }
    }

    /// Their ends.
    pub(crate) fn breaks(&self) -> impl Iterator<Item = f64> {
        [self.approach, self.retreat, self.lift, self.lower].into_iter().flat_map(|(a, b)| [a, b])
    }
}

/// Whether a stretch contains an instant.
pub(crate) fn within(window: (f64, f64), t: f64) -> bool {
    window.0 <= t && t <= window.1
}

/// Height of a standing object's lowest point (m).
pub(crate) fn bottom(script: &Script, timeline: &Timeline, standing: usize) -> f64 {
    let standing = &timeline.standings[standing];
    let solid = Solid::new(&script.problem.movable[standing.object.index()].body);
    -solid.height_along(&(standing.world_from_object * solid.owner_from_shape), -DVec3::Z)
}

/// What a held object may overlap its support by (m) without breaking V6 or V7.
pub(crate) fn contact_depth(script: &Script, solid: &Solid) -> f64 {
    script.problem.settings.support_tolerance + ATTACH_DISTANCE + (solid.radius + solid.centre.length()) * ATTACH_ANGLE
}

/// The farthest instant from `event` towards `limit` before which the tool's origin has travelled [`HAND_WAY`].
fn hand_way(script: &Script, step: &Step, event: f64, limit: f64) -> f64 {
    let robot = step.robot.index();
    let tool = script.problem.robots[robot].end_effector.link_from_tool.translation.vector;
    let (track, mut posture) = (script.tracks[robot], Posture::default());
    let mut tool_at = |t: f64| {
        script.mechanisms[robot].place_at(&track.leg(t), t, step.opening, &mut posture);
        posture.links[step.link.index()].point(DVec3::new(tool.x, tool.y, tool.z))
    };
    let (mut here, mut reached, mut way) = (tool_at(event), event, 0.0);
    for t in track.grid(event, limit) {
        let next = tool_at(t);
        way += next.distance(here);
        if way > HAND_WAY {
            return reached;
        }
        (here, reached) = (next, t);
    }
    reached
}

/// The first instant from `from` towards `to` at which the held object has risen by [`SUPPORT_HEIGHT`] above `floor`.
fn near_support(script: &Script, hold: &Hold, floor: f64, from: f64, to: f64) -> f64 {
    let (robot, step) = (hold.robot.index(), &script.steps[hold.attach]);
    let solid = Solid::new(&script.problem.movable[hold.object.index()].body);
    let (track, mut posture) = (script.tracks[robot], Posture::default());
    for t in track.grid(from, to) {
        script.mechanisms[robot].place_at(&track.leg(t), t, step.opening, &mut posture);
        let frame = posture.links[step.link.index()] * step.link_from_object * solid.owner_from_shape;
        if -solid.height_along(&frame, -DVec3::Z) > floor + SUPPORT_HEIGHT {
            return t;
        }
    }
    to
}
