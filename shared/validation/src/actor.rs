//! A robot with what it holds, placed at instants of its trajectory.

use glamx::DVec3;
use model::{LinkId, Robot};
use plan::BodyRef;

use crate::mechanism::{Mechanism, Posture, Rates};
use crate::script::Script;
use crate::solid::Solid;
use crate::sweep::Placed;
use crate::timeline::Timeline;
use crate::track::{Leg, Track};

/// Bodies are numbered as in `Mechanism::bodies`; a held object comes after them.
pub(crate) struct Actor<'a> {
    pub(crate) robot: &'a Robot,
    pub(crate) mechanism: &'a Mechanism,
    pub(crate) track: Track<'a>,
    /// The robot's holds, with what each carries.
    loads: Vec<Load<'a>>,
    leg: Leg<'a>,
    rates: Rates,
    /// The load held during the current leg, in `loads`.
    held: Option<usize>,
    posture: Posture,
    placed: Vec<Placed>,
    /// For each leg, a ball that contains the robot throughout: before the first knot, between knots, after the last.
    rooms: Vec<(DVec3, f64)>,
}

struct Load<'a> {
    /// In `Timeline::holds`.
    hold: usize,
    from: f64,
    to: f64,
    link: LinkId,
    link_from_object: crate::frame::Frame,
    opening: f64,
    solid: Solid,
    object: &'a str,
}

/// A ball around all bodies of a robot, with a bound on their speeds.
pub(crate) struct Ball {
    pub(crate) centre: DVec3,
    pub(crate) radius: f64,
    pub(crate) speed: f64,
}

impl<'a> Actor<'a> {
    pub(crate) fn new(script: &'a Script<'a>, timeline: &Timeline, robot: usize) -> Self {
        let track = script.tracks[robot];
        let load = |(index, hold): (usize, &crate::timeline::Hold)| {
            let step = &script.steps[hold.attach];
            Load {
                hold: index,
                from: hold.from,
                to: hold.to,
                link: step.link,
                link_from_object: step.link_from_object,
                opening: step.opening,
                solid: Solid::new(&script.problem.movable[hold.object.index()].body),
                object: script.object_name(hold.object),
            }
        };
        let own = timeline.holds.iter().enumerate().filter(|(_, hold)| hold.robot.index() == robot);
        let mut actor = Self {
            robot: &script.problem.robots[robot],
            mechanism: &script.mechanisms[robot],
            track,
            loads: own.map(load).collect(),
            leg: track.leg(0.0),
            rates: Rates::default(),
            held: None,
            posture: Posture::default(),
            placed: Vec::new(),
            rooms: Vec::new(),
        };
        actor.rooms = (0..=track.knots.len()).map(|leg| actor.room_of(leg)).collect();
        actor
    }

    /// The ball of the leg that ends at knot `next`.
    fn room_of(&mut self, next: usize) -> (DVec3, f64) {
        let from = self.track.knots[next.saturating_sub(1)].t;
        let to = self.track.knots.get(next).map_or(from, |knot| knot.t.max(from));
        self.enter((from, to));
        let ball = self.ball();
        (ball.centre, ball.radius + ball.speed * (to - from) / 2.0 + 1e-6)
    }

    /// A ball that contains the robot throughout the leg at `t`: centre and radius (m).
    pub(crate) fn room(&self, t: f64) -> (DVec3, f64) {
        self.rooms[self.track.knots.partition_point(|knot| knot.t <= t)]
    }

    /// Turns to the leg of a stretch of time without a knot inside it, and places the robot at its middle. Returns whether
    /// it holds something else than before. The stretch may be so short that no number lies between its ends.
    pub(crate) fn enter(&mut self, stretch: (f64, f64)) -> bool {
        self.leg = self.track.leg(stretch.0);
        self.mechanism.rates(&self.leg, &mut self.rates);
        let held = self.load_at(stretch.0);
        let changed = held != self.held;
        self.held = held;
        self.place(f64::midpoint(stretch.0, stretch.1));
        changed
    }

    /// Places the robot at an instant of the current leg.
    pub(crate) fn place(&mut self, t: f64) {
        let load = self.held.map(|i| &self.loads[i]);
        let opening = load.map_or(self.robot.end_effector.max_opening, |load| load.opening);
        self.mechanism.place_at(&self.leg, t, opening, &mut self.posture);
        self.placed.clear();
        for (link, solid) in &self.mechanism.bodies {
            let mut placed = Placed::still(solid, self.posture.links[link.index()]);
            placed.speed = self.mechanism.speed(&self.posture, &self.rates, *link, placed.centre, solid.radius);
            self.placed.push(placed);
        }
        if let Some(load) = load {
            let mut placed = Placed::still(&load.solid, self.posture.links[load.link.index()] * load.link_from_object);
            placed.speed =
                self.mechanism.speed(&self.posture, &self.rates, load.link, placed.centre, load.solid.radius);
            self.placed.push(placed);
        }
    }

    /// Number of the links' bodies; the number of a held object's body.
    pub(crate) fn link_bodies(&self) -> usize {
        self.mechanism.bodies.len()
    }

    /// Number of bodies, a held object's included.
    pub(crate) fn bodies(&self) -> usize {
        self.placed.len()
    }

    /// The hold of the current leg, in `Timeline::holds`.
    pub(crate) fn hold(&self) -> Option<usize> {
        self.held.map(|i| self.loads[i].hold)
    }

    pub(crate) fn body(&self, i: usize) -> (&Solid, &Placed) {
        let solid = match self.mechanism.bodies.get(i) {
            Some((_, solid)) => solid,
            None => &self.loads[self.held.unwrap_or(0)].solid,
        };
        (solid, &self.placed[i])
    }

    /// Link that a body belongs to, or that holds it.
    pub(crate) fn link(&self, i: usize) -> LinkId {
        self.mechanism.bodies.get(i).map_or(self.robot.end_effector.parent_link, |(link, _)| *link)
    }

    /// Bound on how fast two bodies of this robot move against one another (m/s).
    pub(crate) fn own_speed(&self, first: usize, second: usize) -> f64 {
        let beyond = |i: usize, other: usize| {
            let (solid, placed) = self.body(i);
            let (link, other) = (self.link(i), self.link(other));
            self.mechanism.speed_beyond(&self.posture, &self.rates, link, other, placed.centre, solid.radius)
        };
        beyond(first, second) + beyond(second, first)
    }

    pub(crate) fn ball(&self) -> Ball {
        let count = self.placed.len().max(1) as f64;
        let centre = self.placed.iter().map(|placed| placed.centre).sum::<DVec3>() / count;
        let mut ball = Ball { centre, radius: 0.0, speed: 0.0 };
        for (i, placed) in self.placed.iter().enumerate() {
            ball.radius = ball.radius.max(placed.centre.distance(centre) + self.body(i).0.radius);
            ball.speed = ball.speed.max(placed.speed);
        }
        ball
    }

    /// What body `i` is at `t`, for messages.
    pub(crate) fn name(&self, i: usize, t: f64) -> BodyRef {
        let robot = self.robot.name.clone();
        match (self.mechanism.bodies.get(i), self.load_at(t)) {
            (None, Some(load)) => BodyRef::Held { robot, object: self.loads[load].object.to_owned() },
            _ => BodyRef::Link { robot, link: self.robot.links[self.link(i).index()].name.clone() },
        }
    }

    /// The load held at `t`; where one stretch ends and another begins, the later.
    fn load_at(&self, t: f64) -> Option<usize> {
        self.loads.iter().rposition(|load| load.from <= t && t < load.to)
    }
}
