//! A robot with or without a load: where its bodies are, and how far they can get within a straight motion.

use model::{LinkId, ObjectId, Pose, Robot, RobotId};
use nalgebra::Vector3;

use crate::BodyName;
use crate::robot_shape::RobotShape;
use crate::solid::{Placed, Solid};

/// The object in the hand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load<'a> {
    pub object: ObjectId,
    pub link_from_solid: Pose,
    pub solid: &'a Solid,
}

/// One robot in one holding state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mover<'a> {
    pub id: RobotId,
    pub robot: &'a Robot,
    pub shape: &'a RobotShape,
    pub load: Option<Load<'a>>,
    /// Whether it is asked to hold what it has no such grasp for: then it is never clear of anything.
    pub impossible: bool,
    /// Between the fingers (m).
    pub opening: f64,
}

/// One body in the middle of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Swept {
    pub placed: Placed,
    /// Bound on how far its points get from there within the motion, the base's translation not counted (m).
    pub spread: f64,
}

/// All bodies of a robot in the middle of a motion. Kept and refilled, so that it allocates once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frame {
    pub bodies: Vec<Swept>,
    /// Half of the base's translation, in the world (m).
    pub drift: Vector3<f64>,
    /// Bound on how far any point travels within half of the motion, the base's translation not counted: the greatest
    /// speed times the time, if each half lasted 1 (m).
    pub pace: f64,
    links: Vec<Pose>,
    middle: Vec<f64>,
    half: Vec<f64>,
    /// Spread of body i relative to what its first k steps move: `[i * stride + k]`.
    relative: Vec<f64>,
    stride: usize,
}

impl Frame {
    /// Bound (m) on how far body `i` gets relative to what the first `common` steps of its chain move.
    pub fn relative_spread(&self, i: u16, common: u16) -> f64 {
        self.relative[usize::from(i) * self.stride + usize::from(common)]
    }
}

impl Mover<'_> {
    /// Number of bodies, the load (the last) included.
    pub fn len(&self) -> usize {
        self.shape.bodies.len() + usize::from(self.load.is_some())
    }

    /// Solid of body `i`.
    pub fn solid(&self, i: usize) -> &Solid {
        match (self.shape.bodies.get(i), &self.load) {
            (None, Some(load)) => load.solid,
            _ => &self.shape.bodies[i].solid,
        }
    }

    /// Name of body `i`.
    pub fn name(&self, i: usize) -> BodyName {
        match (self.shape.bodies.get(i), &self.load) {
            (None, Some(load)) => BodyName::Held { robot: self.id, object: load.object },
            _ => BodyName::Link { robot: self.id, link: self.shape.bodies[i].link },
        }
    }

    /// The link that bears body `i`, and where the body is in its frame.
    pub fn mount(&self, i: usize) -> (LinkId, &Pose) {
        match (self.shape.bodies.get(i), &self.load) {
            (None, Some(load)) => (self.robot.end_effector.parent_link, &load.link_from_solid),
            _ => (self.shape.bodies[i].link, &self.shape.bodies[i].link_from_solid),
        }
    }

    /// Fills `frame` for the part of the straight motion between fractions `middle - half` and `middle + half`.
    pub fn place(&self, from: &[f64], to: &[f64], middle: f64, half: f64, frame: &mut Frame) {
        frame.middle.clear();
        frame.middle.extend(from.iter().zip(to).map(|(a, b)| a + (b - a) * middle));
        frame.half.clear();
        frame.half.extend(from.iter().zip(to).map(|(a, b)| (b - a) * half));
        // What is no configuration leads to poses that are no numbers, which nothing calls clear.
        let coordinates = self.robot.coordinates.len();
        frame.middle.resize(coordinates, f64::NAN);
        frame.half.resize(coordinates, f64::NAN);
        kinematics::link_poses_into(self.robot, &frame.middle, self.opening, &mut frame.links);
        frame.drift = match self.robot.base {
            Some(_) => self.robot.world_from_base.rotation * Vector3::new(frame.half[0], frame.half[1], 0.0),
            None => Vector3::zeros(),
        };
        frame.stride = self.shape.depth() + 1;
        frame.relative.clear();
        frame.relative.resize(self.len() * frame.stride, 0.0);
        frame.bodies.clear();
        frame.pace = 0.0;
        let moving = half > 0.0 && frame.half.iter().any(|h| *h != 0.0);
        for i in 0..self.len() {
            let (link, link_from_solid) = self.mount(i);
            let placed = Placed::at(&(frame.links[link.index()] * link_from_solid));
            let spread = match (self.impossible, moving) {
                (true, _) => f64::INFINITY,
                (false, true) => self.spread(i, link, &placed, frame),
                (false, false) => 0.0,
            };
            frame.bodies.push(Swept { placed, spread });
        }
    }

    /// Bounds how far body `i` gets. Joints can be turned from the middle to wherever they are one after the other, the
    /// root's last: each then finds the body where it was in the middle, carried along rigidly by the others, and adds no
    /// more than its own angle times the distance of the body from its axis in the middle.
    fn spread(&self, i: usize, link: LinkId, placed: &Placed, frame: &mut Frame) -> f64 {
        let solid = self.solid(i);
        let chain = &self.shape.chains[link.index()];
        let (mut spread, mut pace) = (0.0, 0.0);
        for (k, step) in chain.iter().enumerate().rev() {
            let step = &self.shape.steps[usize::from(*step)];
            let by = step.gear * frame.half[step.coordinate.index()].abs();
            if by != 0.0 {
                let (adds, adds_at_most) = match step.turns_about {
                    None => (by, by),
                    Some(axis) => {
                        let child = &frame.links[step.child.index()];
                        let axis = child.rotation * axis;
                        let far = solid.distance_from_axis(placed, &child.translation.vector, &axis);
                        (by.min(2.0) * far, by * (far + spread))
                    }
                };
                spread += adds;
                pace += adds_at_most;
            }
            frame.relative[i * frame.stride + k] = spread;
        }
        let yaw = if self.robot.base.is_some() { frame.half[2].abs() } else { 0.0 };
        if yaw != 0.0 {
            let up = self.robot.world_from_base.rotation * Vector3::z();
            let far = solid.distance_from_axis(placed, &frame.links[0].translation.vector, &up);
            pace += yaw * (far + spread);
            spread += yaw.min(2.0) * far;
        }
        frame.pace = frame.pace.max(pace);
        spread
    }
}
