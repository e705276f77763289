//! Which of a robot's own links touch at a configuration, and which can touch at none.

use model::{CoordinateId, JointMotion, JointValue, LinkId, Robot, RobotId};

use crate::Geometry;
use crate::mover::{Frame, Mover};
use crate::robot_shape::OwnPair;
use crate::separation::{Need, Verdict, judge};

/// Range of an unlimited joint (rad): a turn.
const TURN: [f64; 2] = [-std::f64::consts::PI, std::f64::consts::PI];

impl Geometry {
    /// All pairs of a robot's own links that are nearer than the clearance at one configuration, its hand empty: each once and
    /// sorted, the smaller link first. Pairs that the robot's model disables are left out.
    #[must_use]
    pub fn own_contacts(&self, robot: RobotId, q: &[f64]) -> Vec<(LinkId, LinkId)> {
        let mover = self.mover(robot, None);
        let mut frame = Frame::default();
        mover.place(q, q, 0.5, 0.5, &mut frame);
        let touch = |pair: &&OwnPair| verdict(&mover, &frame, pair, Need::still(self.clearance())) != Verdict::Clear;
        let mut contacts: Vec<_> =
            mover.shape.own_pairs.iter().filter(touch).map(|pair| links_of(&mover, pair)).collect();
        contacts.sort_unstable();
        contacts.dedup();
        contacts
    }

    /// Whether two links of a robot keep the clearance at every configuration within the limits and every opening of the hand.
    ///
    /// `true` is a proof, by bisection of the ranges of the joints between the two: each part of them is cleared by a bound
    /// on how far the bodies get. `false`: they touch somewhere, or the proof needs more than `most_parts` parts.
    #[must_use]
    pub fn links_never_touch(&self, robot: RobotId, links: (LinkId, LinkId), most_parts: usize) -> bool {
        let mut mover = self.mover(robot, None);
        mover.opening /= 2.0;
        let links = (links.0.min(links.1), links.0.max(links.1));
        let pairs: Vec<OwnPair> =
            mover.shape.own_pairs.iter().filter(|pair| links_of(&mover, pair) == links).copied().collect();
        pairs.iter().all(|pair| self.pair_never_touches(&mover, pair, most_parts))
    }

    fn pair_never_touches(&self, mover: &Mover<'_>, pair: &OwnPair, most_parts: usize) -> bool {
        let links = links_of(mover, pair);
        let by_fingers = finger_travel(mover.robot, links.0) + finger_travel(mover.robot, links.1);
        let between = coordinates_between(mover, pair);
        let ranges =
            mover.robot.coordinates.iter().map(|c| if c.upper.is_finite() { [c.lower, c.upper] } else { TURN });
        let mut whole: Vec<[f64; 2]> = ranges.collect();
        for (i, range) in whole.iter_mut().enumerate() {
            if !between.contains(&CoordinateId::at(i)) {
                *range = [range[0]; 2];
            }
        }
        let (mut parts, mut frame) = (vec![whole], Frame::default());
        let mut looked_at = 0;
        while let Some(part) = parts.pop() {
            looked_at += 1;
            let [from, to] = [0, 1].map(|end| part.iter().map(|range| range[end]).collect::<Vec<f64>>());
            mover.place(&from, &to, 0.5, 0.5, &mut frame);
            let spread = frame.relative_spread(pair.a, pair.common) + frame.relative_spread(pair.b, pair.common);
            let need = Need { spread: spread + by_fingers, ..Need::still(self.clearance()) };
            match verdict(mover, &frame, pair, need) {
                Verdict::Clear => {}
                Verdict::Unsure(_) if looked_at < most_parts && spread > self.clearance() / 4.0 => {
                    parts.extend(halves(&part));
                }
                Verdict::Unsure(_) | Verdict::Contact => return false,
            }
        }
        true
    }
}

fn verdict(mover: &Mover<'_>, frame: &Frame, pair: &OwnPair, need: Need) -> Verdict {
    let posed = |i: u16| (mover.solid(usize::from(i)), &frame.bodies[usize::from(i)].placed);
    judge(posed(pair.a), posed(pair.b), &need, &nalgebra::zero())
}

fn links_of(mover: &Mover<'_>, pair: &OwnPair) -> (LinkId, LinkId) {
    let link = |i: u16| mover.shape.bodies[usize::from(i)].link;
    (link(pair.a).min(link(pair.b)), link(pair.a).max(link(pair.b)))
}

/// Coordinates that move the two bodies of a pair against each other.
fn coordinates_between(mover: &Mover<'_>, pair: &OwnPair) -> Vec<CoordinateId> {
    let beyond = |i: u16| {
        let chain = &mover.shape.chains[mover.shape.bodies[usize::from(i)].link.index()];
        chain.iter().skip(usize::from(pair.common)).map(|step| mover.shape.steps[usize::from(*step)].coordinate)
    };
    beyond(pair.a).chain(beyond(pair.b)).collect()
}

/// Both halves of the widest range, the others whole.
fn halves(part: &[[f64; 2]]) -> [Vec<[f64; 2]>; 2] {
    let width = |i: &usize| part[*i][1] - part[*i][0];
    let widest = (0..part.len()).max_by(|i, j| width(i).total_cmp(&width(j))).unwrap_or(0);
    let middle = part.get(widest).map_or(0.0, |range| f64::midpoint(range[0], range[1]));
    [1, 0].map(|end| {
        let mut half = part.to_vec();
        if let Some(range) = half.get_mut(widest) {
            range[end] = middle;
        }
        half
    })
}

/// How far (m) a link gets from where it is when the hand is half open; infinite where the opening turns it.
fn finger_travel(robot: &Robot, link: LinkId) -> f64 {
    let (mut travel, mut at) = (0.0, link);
    while let Some(joint) = robot.joint_of_link(at).map(|joint| &robot.joints[joint.index()]) {
        let by = per_opening(robot, &joint.value).abs() * robot.end_effector.max_opening / 2.0;
        travel += match joint.motion {
            JointMotion::Revolute { .. } if by > 0.0 => f64::INFINITY,
            _ => by,
        };
        at = joint.parent;
    }
    travel
}

/// What one metre of the hand's opening adds to a joint's value.
fn per_opening(robot: &Robot, value: &JointValue) -> f64 {
    let (mut gear, mut value) = (1.0, value);
    for _ in 0..=robot.joints.len() {
        match value {
            JointValue::Finger { scale } => return gear * scale,
            JointValue::Mimic { of, multiplier, .. } => {
                gear *= multiplier;
                value = &robot.joints[of.index()].value;
            }
            JointValue::Coordinate(_) | JointValue::Constant(_) => return 0.0,
        }
    }
    0.0
}
