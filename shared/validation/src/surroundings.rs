//! What stands: fixed objects and standing movable objects, and which contacts with them are allowed.

use glamx::DVec3;
use model::FixedId;
use plan::BodyRef;

use crate::frame::Frame;
use crate::script::Script;
use crate::solid::Solid;
use crate::sweep::Placed;
use crate::timeline::Timeline;
use crate::windows::{self, Windows, within};

/// A body that does not move while it is there.
pub(crate) struct Still {
    pub(crate) what: What,
    pub(crate) solid: Solid,
    pub(crate) placed: Placed,
    /// From when to when it is there (s).
    pub(crate) from: f64,
    pub(crate) to: f64,
}

/// Whose body it is.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum What {
    /// Of a fixed object.
    Fixed(FixedId),
    /// A standing object, in `Timeline::standings`.
    Standing(usize),
}

/// All standing bodies, and the contacts each hold allows.
pub(crate) struct Surroundings {
    pub(crate) bodies: Vec<Still>,
    /// For each standing object, the bodies it may rest on, in `bodies`.
    rests_on: Vec<Vec<usize>>,
    /// For each hold.
    pub(crate) windows: Vec<Windows>,
    /// For each hold, how deep the held object may overlap what it rests on (m).
    depths: Vec<f64>,
    /// For each hold, the standing objects (in `Timeline::standings`) that it takes and that it puts.
    ends: Vec<[Option<usize>; 2]>,
}

impl Surroundings {
    pub(crate) fn new(script: &Script, timeline: &Timeline) -> Self {
        let mut bodies = Vec::new();
        for (i, fixed) in script.problem.fixed.iter().enumerate() {
            let frame = Frame::of(&fixed.world_from_object);
            for body in &fixed.bodies {
                let (from, to) = (f64::NEG_INFINITY, f64::INFINITY);
                bodies.push(still(What::Fixed(FixedId::at(i)), Solid::new(body), frame, from, to));
            }
        }
        let rests_on = (0..timeline.standings.len()).map(|s| supports(script, timeline, s, &bodies)).collect();
        for (i, standing) in timeline.standings.iter().enumerate() {
            let solid = Solid::new(&script.problem.movable[standing.object.index()].body);
            bodies.push(still(What::Standing(i), solid, standing.world_from_object, standing.from, standing.to));
        }
        let holds = 0..timeline.holds.len();
        let depth = |hold: usize| {
            let object = timeline.holds[hold].object;
            windows::contact_depth(script, &Solid::new(&script.problem.movable[object.index()].body))
        };
        let ends = |hold: usize| {
            let taken = timeline.standings.iter().position(|s| s.taken_by == Some(hold));
            [taken, timeline.standings.iter().position(|s| s.put_by == Some(hold))]
        };
        Self {
            bodies,
            rests_on,
            windows: holds.clone().map(|hold| Windows::of(script, timeline, hold)).collect(),
            depths: holds.clone().map(depth).collect(),
            ends: holds.map(ends).collect(),
        }
    }

    /// Whether the hand of a hold may touch standing body `still` at `t`.
    pub(crate) fn hand_may_touch(&self, hold: usize, still: usize, t: f64) -> bool {
        let [taken, put] = self.ends[hold];
        let is = |standing: Option<usize>| standing.is_some_and(|s| self.bodies[still].what == What::Standing(s));
        let windows = &self.windows[hold];
        is(taken) && within(windows.approach, t) || is(put) && within(windows.retreat, t)
    }

    /// How far a held object is to be raised at `t` before it is tested against `still` (m): above 0 where it may rest on it.
    pub(crate) fn lift(&self, hold: usize, still: usize, t: f64) -> f64 {
        let [taken, put] = self.ends[hold];
        let rests = |standing: Option<usize>| standing.is_some_and(|s| self.rests_on[s].contains(&still));
        let windows = &self.windows[hold];
        let allowed = rests(taken) && within(windows.lift, t) || rests(put) && within(windows.lower, t);
        if allowed { self.depths[hold] } else { 0.0 }
    }

    /// Whether a contact with `still` is ever allowed to a hold's hand (`held` false) or to the object it holds.
    pub(crate) fn concerns(&self, hold: usize, still: usize, held: bool) -> bool {
        let at_end = |standing: usize| match held {
            true => self.rests_on[standing].contains(&still),
            false => self.bodies[still].what == What::Standing(standing),
        };
        self.ends[hold].into_iter().flatten().any(at_end)
    }

    /// Whether a standing object may rest on a body.
    pub(crate) fn rests_on(&self, standing: usize, still: usize) -> bool {
        self.rests_on[standing].contains(&still)
    }

    pub(crate) fn name(&self, script: &Script, timeline: &Timeline, still: usize) -> BodyRef {
        match self.bodies[still].what {
            What::Fixed(id) => BodyRef::Fixed(script.problem.fixed[id.index()].name.clone()),
            What::Standing(s) => BodyRef::Object(script.object_name(timeline.standings[s].object).to_owned()),
        }
    }
}

fn still(what: What, solid: Solid, owner: Frame, from: f64, to: f64) -> Still {
    Still { what, placed: Placed::still(&solid, owner), solid, from, to }
}

/// Bodies of what an object stands on that lie wholly below its bottom, give or take the tolerance on its height.
fn supports(script: &Script, timeline: &Timeline, standing: usize, fixed: &[Still]) -> Vec<usize> {
    let Some(support) = timeline.standings[standing].support else { return Vec::new() };
    let highest = windows::bottom(script, timeline, standing) + script.problem.settings.support_tolerance + 1e-9;
    let below = |body: &Still| body.solid.height_along(&body.placed.frame, DVec3::Z) <= highest;
    (0..fixed.len()).filter(|i| fixed[*i].what == What::Fixed(support) && below(&fixed[*i])).collect()
}
