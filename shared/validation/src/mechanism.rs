//! Forward kinematics, and bounds on how fast bodies move, written from the model alone.

mod chain;

use glamx::DVec3;
use model::{JointId, JointMotion, JointValue, LinkId, Robot};

use crate::frame::Frame;
use crate::solid::Solid;
use crate::track::Leg;

pub(crate) use chain::Axis;

/// A robot made ready for evaluation.
pub(crate) struct Mechanism {
    world_from_base: Frame,
    planar: bool,
    joints: Vec<Joint>,
    links: usize,
    /// For each link, the joints between the root and it, the root's first.
    paths: Vec<Vec<usize>>,
    /// Bodies of all links.
    pub(crate) bodies: Vec<(LinkId, Solid)>,
}

struct Joint {
    parent: usize,
    child: usize,
    parent_from_joint: Frame,
    motion: Motion,
    value: Value,
}

#[derive(Clone, Copy)]
enum Motion {
    Fixed,
    Revolute(DVec3),
    Prismatic(DVec3),
}

/// A joint's value: `slope · q[coordinate] + per_opening · opening + offset`.
#[derive(Clone, Copy, Default)]
struct Value {
    coordinate: Option<usize>,
    slope: f64,
    per_opening: f64,
    offset: f64,
}

/// Where all links and joint axes are at one instant.
#[derive(Default)]
pub(crate) struct Posture {
    pub(crate) links: Vec<Frame>,
    /// A point on each joint's axis, and its direction, in the world.
    axes: Vec<(DVec3, DVec3)>,
    q: Vec<f64>,
}

/// How fast each joint and the base move during a leg (absolute values).
#[derive(Default)]
pub(crate) struct Rates {
    joints: Vec<f64>,
    base_speed: f64,
    yaw_rate: f64,
}

fn axis(axis: [f64; 3]) -> DVec3 {
    DVec3::from(axis).normalize_or(DVec3::Z)
}

fn value(robot: &Robot, joint: JointId, depth: usize) -> Option<Value> {
    if depth > robot.joints.len() {
        return None;
    }
    Some(match robot.joints.get(joint.index())?.value {
        JointValue::Coordinate(id) => Value { coordinate: Some(id.index()), slope: 1.0, ..Value::default() },
        JointValue::Finger { scale } => Value { per_opening: scale, ..Value::default() },
        JointValue::Constant(offset) => Value { offset, ..Value::default() },
        JointValue::Mimic { of, multiplier, offset } => {
            let followed = value(robot, of, depth + 1)?;
            Value {
                coordinate: followed.coordinate,
                slope: followed.slope * multiplier,
                per_opening: followed.per_opening * multiplier,
                offset: followed.offset * multiplier + offset,
            }
        }
    })
}

impl Mechanism {
    /// `None` if the robot is not a tree in the order the model promises, or its mimic joints follow one another in a ring.
    pub(crate) fn new(robot: &Robot) -> Option<Self> {
        let mut joints = Vec::new();
        let mut paths: Vec<Option<Vec<usize>>> = vec![None; robot.links.len()];
        *paths.first_mut()? = Some(Vec::new());
        for (i, joint) in robot.joints.iter().enumerate() {
            let (parent, child) = (joint.parent.index(), joint.child.index());
            let mut path = paths.get(parent)?.clone()?;
            path.push(i);
            *paths.get_mut(child).filter(|path| path.is_none())? = Some(path);
            let motion = match joint.motion {
                JointMotion::Fixed => Motion::Fixed,
                JointMotion::Revolute { axis: a } => Motion::Revolute(axis(a)),
                JointMotion::Prismatic { axis: a } => Motion::Prismatic(axis(a)),
            };
            let value = value(robot, JointId::at(i), 0)?;
            if value.coordinate.is_some_and(|c| c >= robot.coordinates.len()) {
                return None;
            }
            joints.push(Joint { parent, child, parent_from_joint: Frame::of(&joint.parent_from_joint), motion, value });
        }
        let bodies = robot
            .links
            .iter()
            .enumerate()
            .flat_map(|(i, link)| link.bodies.iter().map(move |body| (LinkId::at(i), Solid::new(body))))
            .collect();
        Some(Self {
            world_from_base: Frame::of(&robot.world_from_base),
            planar: robot.base.is_some(),
            joints,
            links: robot.links.len(),
            paths: paths.into_iter().collect::<Option<_>>()?,
            bodies,
        })
    }

    /// Places all links for a configuration `q` (m, rad) and an opening between the fingers (m).
    pub(crate) fn place(&self, q: &[f64], opening: f64, posture: &mut Posture) {
        posture.links.clear();
        posture.links.resize(self.links, Frame::IDENTITY);
        posture.axes.clear();
        posture.links[0] = self.world_from_base;
        if self.planar {
            let driven = Frame::shifted(DVec3::new(q[0], q[1], 0.0)) * Frame::turned(DVec3::Z, q[2]);
            posture.links[0] = self.world_from_base * driven;
        }
        for joint in &self.joints {
            let v = joint.value;
            let value = v.coordinate.map_or(0.0, |c| v.slope * q[c]) + v.per_opening * opening + v.offset;
            let frame = posture.links[joint.parent] * joint.parent_from_joint;
            let (moved, direction) = match joint.motion {
                Motion::Fixed => (Frame::IDENTITY, DVec3::ZERO),
                Motion::Revolute(axis) => (Frame::turned(axis, value), axis),
                Motion::Prismatic(axis) => (Frame::shifted(axis * value), axis),
            };
            posture.axes.push((frame.origin, frame.rotation * direction));
            posture.links[joint.child] = frame * moved;
        }
    }

    /// As [`Mechanism::place`], for the instant `t` of a leg.
    pub(crate) fn place_at(&self, leg: &Leg, t: f64, opening: f64, posture: &mut Posture) {
        let mut q = std::mem::take(&mut posture.q);
        leg.configuration(t, &mut q);
        self.place(&q, opening, posture);
        posture.q = q;
    }

    pub(crate) fn rates(&self, leg: &Leg, rates: &mut Rates) {
        rates.joints.clear();
        rates.joints.extend(self.joints.iter().map(|joint| {
            let moves = !matches!(joint.motion, Motion::Fixed);
            joint.value.coordinate.filter(|_| moves).map_or(0.0, |c| (joint.value.slope * leg.rate(c)).abs())
        }));
        (rates.base_speed, rates.yaw_rate) =
            if self.planar { (leg.rate(0).hypot(leg.rate(1)), leg.rate(2).abs()) } else { (0.0, 0.0) };
    }

    /// Bound on the average speed, over any time before or after the posture's instant within the leg, of every point that
    /// belongs to `link` and lies within `radius` of `centre`.
    ///
    /// Moving one joint after the other from the posture's configuration, tip first, each moves the point by no more than
    /// its own turn times the point's distance from its axis *in the posture*; the displacements add up.
    pub(crate) fn speed(&self, posture: &Posture, rates: &Rates, link: LinkId, centre: DVec3, radius: f64) -> f64 {
        let mut speed = rates.base_speed;
        if rates.yaw_rate > 0.0 {
            let up = self.world_from_base.rotation.z_axis;
            speed += rates.yaw_rate * (distance_to_axis(centre, posture.links[0].origin, up) + radius);
        }
        speed + self.path_speed(posture, rates, &self.paths[link.index()], centre, radius)
    }

    /// As [`Mechanism::speed`], relative to the link at which the paths to `link` and to `other` part.
    pub(crate) fn speed_beyond(
        &self,
        posture: &Posture,
        rates: &Rates,
        link: LinkId,
        other: LinkId,
        centre: DVec3,
        radius: f64,
    ) -> f64 {
        let path = self.path_beyond(link, other);
        self.path_speed(posture, rates, path, centre, radius)
    }

    /// Whether two links can move relative to one another, fingers included.
    pub(crate) fn can_move(&self, link: LinkId, other: LinkId) -> bool {
        let moves = |j: &usize| {
            let v = self.joints[*j].value;
            !matches!(self.joints[*j].motion, Motion::Fixed) && (v.coordinate.is_some() || v.per_opening != 0.0)
        };
        self.path_beyond(link, other).iter().chain(self.path_beyond(other, link)).any(moves)
    }

    fn path_beyond(&self, link: LinkId, other: LinkId) -> &[usize] {
        let (path, other) = (&self.paths[link.index()], &self.paths[other.index()]);
        let shared = path.iter().zip(other).take_while(|(a, b)| a == b).count();
        &path[shared..]
    }

    fn path_speed(&self, posture: &Posture, rates: &Rates, path: &[usize], centre: DVec3, radius: f64) -> f64 {
        let mut speed = 0.0;
        for &j in path {
            let rate = rates.joints[j];
            if rate > 0.0 {
                let (point, direction) = posture.axes[j];
                speed += match self.joints[j].motion {
                    Motion::Fixed => 0.0,
                    Motion::Prismatic(_) => rate,
                    Motion::Revolute(_) => rate * (distance_to_axis(centre, point, direction) + radius),
                };
            }
        }
        speed
    }
}

fn distance_to_axis(point: DVec3, on_axis: DVec3, direction: DVec3) -> f64 {
    (point - on_axis).cross(direction).length()
}

#[cfg(test)]
mod tests;
