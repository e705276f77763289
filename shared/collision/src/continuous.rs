//! Continuous checking of one robot's straight motion: bisection with bounds on how far each body can get.

use model::ObjectId;
use nalgebra::Vector3;

use crate::mover::{Frame, Mover};
use crate::obstacle::Obstacle;
use crate::robot_shape::OwnPair;
use crate::separation::{Need, Verdict, balls_clear, judge};
use crate::{BodyName, Contact};

/// Finest division of a motion: 2^24 parts. Only motions of astronomical length meet it.
const DEEPEST: u32 = 24;
/// Least displacement bound (m) at which bisection ends, whatever the clearance.
const LEAST_FLOOR: f64 = 1e-4;

/// A straight motion of one robot among obstacles.
pub(crate) struct Passage<'a> {
    pub mover: Mover<'a>,
    pub from: &'a [f64],
    pub to: &'a [f64],
    pub clearance: f64,
    pub obstacles: &'a [Obstacle],
    /// Whether the robot's own pairs are tested too.
    pub own: bool,
    /// The object that touch links may touch.
    pub touch: Option<ObjectId>,
    /// Obstacles (indices) that the load may touch.
    pub supports: &'a [usize],
}

/// Two bodies that bounds have not yet proven clear of each other.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    body: u16,
    against: Against,
    /// An axis that nearly separated them.
    hint: Vector3<f64>,
}

#[derive(Clone, Copy, Debug)]
enum Against {
    Own(OwnPair),
    Obstacle(u32),
}

/// A part of the motion, number `index` of 2^level, and its candidates `[first, last)`.
#[derive(Clone, Copy, Debug)]
struct Part {
    index: u32,
    first: usize,
    last: usize,
}

impl Passage<'_> {
    /// The first pair found that cannot be proven clear all the way.
    pub fn contact(&self) -> Option<Contact> {
        if !self.is_sane() {
            return (self.mover.len() > 0).then(|| Contact { first: self.mover.name(0), second: self.mover.name(0) });
        }
        let mut frame = Frame::default();
        self.mover.place(self.from, self.to, 0.5, 0.5, &mut frame);
        let mut pairs = self.candidates(&frame);
        let mut parts = vec![Part { index: 0, first: 0, last: pairs.len() }];
        let (mut next_pairs, mut next_parts) = (Vec::new(), Vec::new());
        for level in 0..=DEEPEST {
            let half = 0.5 / f64::from(1u32 << level);
            for part in &parts {
                if level > 0 {
                    let middle = f64::from(2 * part.index + 1) * half;
                    self.mover.place(self.from, self.to, middle, half, &mut frame);
                }
                let first = next_pairs.len();
                if let Some(contact) = self.examine(&frame, &pairs[part.first..part.last], &mut next_pairs) {
                    return Some(contact);
                }
                let last = next_pairs.len();
                if last > first {
                    next_parts.push(Part { index: 2 * part.index, first, last });
                    next_parts.push(Part { index: 2 * part.index + 1, first, last });
                }
            }
            if next_parts.is_empty() {
                return None;
            }
            std::mem::swap(&mut pairs, &mut next_pairs);
            std::mem::swap(&mut parts, &mut next_parts);
            next_pairs.clear();
            next_parts.clear();
        }
        pairs.first().map(|pair| self.name(pair))
    }

    /// Whether both ends are configurations of the robot, and its grasp exists. If not, it touches itself.
    fn is_sane(&self) -> bool {
        let coordinates = self.mover.robot.coordinates.len();
        !self.mover.impossible
            && [self.from, self.to].iter().all(|q| q.len() == coordinates && q.iter().all(|value| value.is_finite()))
    }

    /// Pairs that the balls around the bodies do not prove clear for the whole motion.
    fn candidates(&self, frame: &Frame) -> Vec<Candidate> {
        let mut candidates = Vec::with_capacity(32);
        self.obstacle_candidates(frame, &mut candidates);
        if self.own {
            let load_pairs = if self.mover.load.is_some() { &self.mover.shape.load_pairs[..] } else { &[] };
            for pair in self.mover.shape.own_pairs.iter().chain(load_pairs) {
                let candidate = Candidate { body: pair.a, against: Against::Own(*pair), hint: Vector3::zeros() };
                let (a, b) = (&frame.bodies[usize::from(pair.a)], &frame.bodies[usize::from(pair.b)]);
                let first = (self.mover.solid(usize::from(pair.a)), &a.placed);
                let second = (self.mover.solid(usize::from(pair.b)), &b.placed);
                if !balls_clear(first, second, &self.need(frame, &candidate)) {
                    candidates.push(candidate);
                }
            }
        }
        candidates
    }

    fn obstacle_candidates(&self, frame: &Frame, candidates: &mut Vec<Candidate>) {
        let reach = self.clearance + frame.drift.norm();
        let radius = |i: usize| self.mover.solid(i).radius + frame.bodies[i].spread + reach;
        let (mut least, mut greatest) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
        for (i, body) in frame.bodies.iter().enumerate() {
            let radius = radius(i);
            least = least.inf(&body.placed.center.add_scalar(-radius));
            greatest = greatest.sup(&body.placed.center.add_scalar(radius));
        }
        for (k, obstacle) in self.obstacles.iter().enumerate() {
            let apart = (0..3).any(|i| obstacle.least[i] > greatest[i] || obstacle.greatest[i] < least[i]);
            if apart {
                continue;
            }
            for (i, body) in frame.bodies.iter().enumerate() {
                if !obstacle.clear_of_ball(&body.placed.center, radius(i)) && !self.may_touch(i, k) {
                    let (body, k) = (u16::try_from(i).unwrap_or(0), u32::try_from(k).unwrap_or(0));
                    candidates.push(Candidate { body, against: Against::Obstacle(k), hint: Vector3::zeros() });
                }
            }
        }
    }

    /// Whether body `i` may touch obstacle `k`.
    fn may_touch(&self, i: usize, k: usize) -> bool {
        let object = match self.obstacles[k].name {
            BodyName::Object(object) => Some(object),
            _ => None,
        };
        match self.mover.shape.bodies.get(i) {
            Some(body) => body.touch && object.is_some() && object == self.touch,
            None => self.supports.contains(&k) || object.is_some() && object == self.mover.load.map(|load| load.object),
        }
    }

    fn need(&self, frame: &Frame, candidate: &Candidate) -> Need {
        match candidate.against {
            Against::Own(pair) => {
                let spread = frame.relative_spread(pair.a, pair.common) + frame.relative_spread(pair.b, pair.common);
                Need { spread, ..Need::still(self.clearance) }
            }
            Against::Obstacle(_) => {
                let spread = frame.bodies[usize::from(candidate.body)].spread;
                Need::moving(self.clearance, spread, [frame.drift, Vector3::zeros()])
            }
        }
    }

    /// Judges the candidates of one part; those that remain go to `kept`.
    fn examine(&self, frame: &Frame, pairs: &[Candidate], kept: &mut Vec<Candidate>) -> Option<Contact> {
        let floor = (self.clearance / 4.0).max(LEAST_FLOOR);
        let posed = |i: u16| (self.mover.solid(usize::from(i)), &frame.bodies[usize::from(i)].placed);
        for pair in pairs {
            let need = self.need(frame, pair);
            let second = match pair.against {
                Against::Own(own) => posed(own.b),
                Against::Obstacle(k) => self.obstacles[k as usize].posed(),
            };
            match judge(posed(pair.body), second, &need, &pair.hint) {
                Verdict::Clear => {}
                Verdict::Unsure(hint) if need.displacement() > floor => kept.push(Candidate { hint, ..*pair }),
                Verdict::Unsure(_) | Verdict::Contact => return Some(self.name(pair)),
            }
        }
        None
    }

    fn name(&self, pair: &Candidate) -> Contact {
        let second = match pair.against {
            Against::Own(own) => self.mover.name(usize::from(own.b)),
            Against::Obstacle(k) => self.obstacles[k as usize].name,
        };
        Contact { first: self.mover.name(usize::from(pair.body)), second }
    }
}
