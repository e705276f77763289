//! A robot's bodies, what moves each of them, and which of them can touch each other.

use std::sync::Arc;

use model::{CoordinateId, JointMotion, JointValue, LinkId, Pose, Robot};
use nalgebra::Vector3;

use crate::hull;
use crate::solid::Solid;

/// A convex body of a link.
#[derive(Clone, Debug)]
pub(crate) struct LinkBody {
    pub link: LinkId,
    pub link_from_solid: Pose,
    pub solid: Arc<Solid>,
    /// Whether it may touch an object that the robot is about to grasp.
    pub touch: bool,
}

/// A joint that a planned coordinate moves.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    /// The coordinate; mimicking is followed to its end.
    pub coordinate: CoordinateId,
    /// |joint value per coordinate value|.
    pub gear: f64,
    /// The link it moves; its origin lies on the axis.
    pub child: LinkId,
    /// Unit axis in the child's frame of a turning joint; a sliding one has none.
    pub turns_about: Option<Vector3<f64>>,
}

/// Two bodies of one robot (indices; the body after the last is the load) that may not touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OwnPair {
    pub a: u16,
    pub b: u16,
    /// How many leading steps move both alike.
    pub common: u16,
}

/// What the geometry knows of one robot.
#[derive(Clone, Debug)]
pub(crate) struct RobotShape {
    pub bodies: Vec<LinkBody>,
    pub steps: Vec<Step>,
    /// For each link, the steps that move it, the root's first.
    pub chains: Vec<Vec<u16>>,
    /// Pairs of the robot's own bodies.
    pub own_pairs: Vec<OwnPair>,
    /// Pairs of a body and the load.
    pub load_pairs: Vec<OwnPair>,
}

impl RobotShape {
    /// Prepares a robot.
    ///
    /// # Errors
    /// The name of a link and what is wrong with its shape.
    pub fn new(robot: &Robot) -> Result<Self, (String, String)> {
        let mut bodies = Vec::new();
        for (i, link) in robot.links.iter().enumerate() {
            for body in &link.bodies {
                let (solid, origin) = Solid::new(&body.shape).map_err(|reason| (link.name.clone(), reason))?;
                bodies.push(LinkBody {
                    link: LinkId::at(i),
                    link_from_solid: hull::shifted(&body.owner_from_shape, &origin),
                    solid: Arc::new(solid),
                    touch: robot.is_touch_link(LinkId::at(i)),
                });
            }
        }
        let (steps, chains) = steps_and_chains(robot);
        let own_pairs = own_pairs(robot, &bodies, &chains);
        let load_pairs = load_pairs(robot, &bodies, &chains);
        Ok(Self { bodies, steps, chains, own_pairs, load_pairs })
    }

    /// Most steps on any chain.
    pub fn depth(&self) -> usize {
        self.chains.iter().map(Vec::len).max().unwrap_or(0)
    }
}

/// The coordinate that a joint follows, and its |gear|; `None` if no coordinate moves it.
fn source(robot: &Robot, value: &JointValue) -> Option<(CoordinateId, f64)> {
    let (mut gear, mut value) = (1.0, value);
    for _ in 0..=robot.joints.len() {
        match value {
            JointValue::Coordinate(coordinate) => return Some((*coordinate, f64::abs(gear))),
            JointValue::Mimic { of, multiplier, .. } => {
                gear *= multiplier;
                value = &robot.joints[of.index()].value;
            }
            JointValue::Finger { .. } | JointValue::Constant(_) => return None,
        }
    }
    None
}

fn steps_and_chains(robot: &Robot) -> (Vec<Step>, Vec<Vec<u16>>) {
    let mut steps = Vec::new();
    let mut chains = vec![Vec::new(); robot.links.len()];
    for joint in &robot.joints {
        let mut chain: Vec<u16> = chains[joint.parent.index()].clone();
        let turns_about = match &joint.motion {
            JointMotion::Revolute { axis } => Some(Vector3::from(*axis)),
            JointMotion::Prismatic { .. } | JointMotion::Fixed => None,
        };
        let moving = source(robot, &joint.value).filter(|_| joint.motion != JointMotion::Fixed);
        if let Some((coordinate, gear)) = moving {
            chain.push(u16::try_from(steps.len()).unwrap_or(u16::MAX));
            steps.push(Step { coordinate, gear, child: joint.child, turns_about });
        }
        chains[joint.child.index()] = chain;
    }
    (steps, chains)
}

fn common_steps(first: &[u16], second: &[u16]) -> u16 {
    let common = first.iter().zip(second).take_while(|(a, b)| a == b).count();
    u16::try_from(common).unwrap_or(0)
}

fn own_pairs(robot: &Robot, bodies: &[LinkBody], chains: &[Vec<u16>]) -> Vec<OwnPair> {
    let mut pairs = Vec::new();
    for (i, first) in bodies.iter().enumerate() {
        for (j, second) in bodies.iter().enumerate().skip(i + 1) {
            let links = (first.link.min(second.link), first.link.max(second.link));
            if links.0 == links.1 || robot.disabled_pairs.contains(&links) {
                continue;
            }
            let common = common_steps(&chains[first.link.index()], &chains[second.link.index()]);
            if let (Ok(a), Ok(b)) = (u16::try_from(i), u16::try_from(j)) {
                pairs.push(OwnPair { a, b, common });
            }
        }
    }
    pairs
}

fn load_pairs(robot: &Robot, bodies: &[LinkBody], chains: &[Vec<u16>]) -> Vec<OwnPair> {
    let hand = &chains[robot.end_effector.parent_link.index()];
    let load = u16::try_from(bodies.len()).unwrap_or(u16::MAX);
    let outside = (0..load).zip(bodies).filter(|(_, body)| !body.touch);
    outside.map(|(a, body)| OwnPair { a, b: load, common: common_steps(&chains[body.link.index()], hand) }).collect()
}
