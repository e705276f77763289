//! Which bodies overlap where a problem puts them at the start.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

use model::{ObjectId, RobotId, Standing};

use crate::mover::Frame;
use crate::obstacle::Obstacle;
use crate::penetration::{depth, only_touch};
use crate::separation::{Need, Verdict, judge};
use crate::{BodyName, Contact, Geometry};

/// Overlaps up to this (m) are touch: files carry a few digits.
const TOUCH: f64 = 1e-6;
/// More contacts than these are not looked for.
const MOST: usize = 40;

/// Two bodies too close to each other at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartContact {
    /// Which; of a robot and something else, the robot's link is the first, of two objects the later one.
    pub contact: Contact,
    /// How deep they overlap (m): by how much one must be moved for them to just touch. Below zero: how far apart they are.
    pub depth: f64,
}

/// A body at the start; of a robot's, which of its bodies it is.
struct AtStart {
    obstacle: Obstacle,
    own: Option<(RobotId, u16)>,
}

impl Geometry {
    /// All bodies that overlap at the start: links, fixed objects and movable objects with links and movable objects; and
    /// links nearer than the clearance to each other, to other robots and to fixed objects, since no motion begins there.
    ///
    /// Fixed objects may overlap each other, and an object stands on its support. Sorted, each pair of names once, with its
    /// deepest overlap; a few dozen are enough to be told.
    #[must_use]
    pub fn start_contacts(&self) -> Vec<StartContact> {
        let bodies = self.bodies_at_start();
        let own_pairs: BTreeSet<(RobotId, u16, u16)> = self
            .problem()
            .robot_ids()
            .flat_map(|robot| self.robot_shape(robot).own_pairs.iter().map(move |pair| (robot, pair.a, pair.b)))
            .collect();
        let mut deepest: BTreeMap<Contact, f64> = BTreeMap::new();
        let mut look_at = |a: &AtStart, b: &AtStart| {
            let may_touch = match (a.own, b.own) {
                (Some(a), Some(b)) if a.0 == b.0 => !own_pairs.contains(&(a.0, a.1.min(b.1), a.1.max(b.1))),
                _ => false,
            };
            if may_touch || self.stands_on(&a.obstacle, &b.obstacle) || self.stands_on(&b.obstacle, &a.obstacle) {
                return ControlFlow::Continue(());
            }
            if let Some(depth) = self.too_deep(&a.obstacle, &b.obstacle) {
                let kept = deepest.entry(ordered(a.obstacle.name, b.obstacle.name)).or_insert(depth);
                *kept = kept.max(depth);
            }
            if deepest.len() < MOST { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        // Broken off or not, the contacts found are there.
        let _ = visit_near(&bodies, self.clearance(), &mut look_at);
        deepest.into_iter().map(|(contact, depth)| StartContact { contact, depth }).collect()
    }

    fn bodies_at_start(&self) -> Vec<AtStart> {
        let still = |obstacle: Obstacle| AtStart { obstacle, own: None };
        let mut bodies: Vec<AtStart> = self.fixed_obstacles().iter().cloned().map(still).collect();
        bodies.extend(self.problem().movable.iter().enumerate().map(|(i, object)| {
            let standing = Standing { object: ObjectId::at(i), world_from_object: object.world_from_start };
            still(self.obstacle(&standing))
        }));
        let mut frame = Frame::default();
        for robot in self.problem().robot_ids() {
            let mover = self.mover(robot, None);
            mover.place(&mover.robot.start, &mover.robot.start, 0.5, 0.0, &mut frame);
            for (i, (body, swept)) in (0_u16..).zip(mover.shape.bodies.iter().zip(&frame.bodies)) {
                let (least, greatest) = body.solid.bounds(&swept.placed);
                let (solid, placed) = (body.solid.clone(), swept.placed);
                let obstacle = Obstacle { name: mover.name(i.into()), solid, placed, least, greatest };
                bodies.push(AtStart { obstacle, own: Some((robot, i)) });
            }
        }
        bodies
    }

    /// Whether `upper` is a movable object and `lower` a body of its support that carries it.
    fn stands_on(&self, upper: &Obstacle, lower: &Obstacle) -> bool {
        let (BodyName::Object(object), BodyName::Fixed(fixed)) = (upper.name, lower.name) else { return false };
        let tolerance = self.problem().settings.support_tolerance;
        self.problem().movable[object.index()].start_support == Some(fixed)
            && lower.carries(upper.least.z, tolerance, self.clearance().max(tolerance))
    }

    /// How deep two bodies overlap, if they may not so much.
    fn too_deep(&self, a: &Obstacle, b: &Obstacle) -> Option<f64> {
        let moved = |name: BodyName| matches!(name, BodyName::Object(_));
        // Next to an object a hand may be about to grasp it, and objects may stand side by side.
        let kept = if moved(a.name) || moved(b.name) { -TOUCH } else { self.clearance() };
        let need = Need::still(kept.max(0.0));
        if judge(a.posed(), b.posed(), &need, &nalgebra::zero()) == Verdict::Clear {
            return None;
        }
        if kept < 0.0 && only_touch(a.posed(), b.posed(), TOUCH) {
            return None;
        }
        Some(depth(a.posed(), b.posed())).filter(|depth| -depth < kept - f64::EPSILON)
    }
}

/// The two names as a contact: links before anything else, later objects before earlier ones and fixed ones.
fn ordered(a: BodyName, b: BodyName) -> Contact {
    let rank = |name: &BodyName| match name {
        BodyName::Link { .. } | BodyName::Held { .. } => 0,
        BodyName::Object(_) => 1,
        BodyName::Fixed(_) => 2,
    };
    let swap = match (rank(&a), rank(&b)) {
        (1, 1) => a < b,
        (0, 0) => b < a,
        (of_a, of_b) => of_b < of_a,
    };
    if swap { Contact { first: b, second: a } } else { Contact { first: a, second: b } }
}

/// Visits pairs of bodies whose bounds are nearer than `reach` (m), by a sweep along x; of two fixed bodies none.
fn visit_near(
    bodies: &[AtStart],
    reach: f64,
    visit: &mut impl FnMut(&AtStart, &AtStart) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let fixed = |body: &AtStart| matches!(body.obstacle.name, BodyName::Fixed(_));
    let mut order: Vec<&AtStart> = bodies.iter().collect();
    order.sort_by(|a, b| a.obstacle.least.x.total_cmp(&b.obstacle.least.x));
    let mut open: Vec<&AtStart> = Vec::new();
    for body in order {
        let (least, greatest) = (&body.obstacle.least, &body.obstacle.greatest);
        open.retain(|other| other.obstacle.greatest.x + reach >= least.x);
        for other in open.iter().filter(|other| !(fixed(body) && fixed(other))) {
            let (low, high) = (&other.obstacle.least, &other.obstacle.greatest);
            if (1..3).all(|axis| low[axis] <= greatest[axis] + reach && least[axis] <= high[axis] + reach) {
                visit(other, body)?;
            }
        }
        open.push(body);
    }
    ControlFlow::Continue(())
}
