//! Who holds what when, and what stands where when: rules V5 and V8.

use model::{FixedId, ObjectId, PairId, RobotId};
use plan::EventKind;

use crate::frame::Frame;
use crate::script::{Script, Step};
use crate::violation::{Rule, Violation};

/// An object in a hand.
pub(crate) struct Hold {
    pub(crate) robot: RobotId,
    pub(crate) pair: PairId,
    pub(crate) object: ObjectId,
    /// The attach, in `Script::steps`.
    pub(crate) attach: usize,
    /// The detach; none if the object is never released.
    pub(crate) detach: Option<usize>,
    pub(crate) from: f64,
    /// Infinite if never released.
    pub(crate) to: f64,
}

/// An object standing somewhere.
pub(crate) struct Standing {
    pub(crate) object: ObjectId,
    pub(crate) world_from_object: Frame,
    /// Negative infinity at the start.
    pub(crate) from: f64,
    /// Infinite at the end.
    pub(crate) to: f64,
    /// The hold that put it there, in `Timeline::holds`.
    pub(crate) put_by: Option<usize>,
    /// The hold that takes it away.
    pub(crate) taken_by: Option<usize>,
    /// What it stands on.
    pub(crate) support: Option<FixedId>,
}

/// All holds and all standing poses.
pub(crate) struct Timeline {
    pub(crate) holds: Vec<Hold>,
    pub(crate) standings: Vec<Standing>,
}

impl Timeline {
    /// Orders the events by robot and by object; `None`, with violations, if they make no sense.
    pub(crate) fn build(script: &Script, wrong: &mut Vec<Violation>) -> Option<Self> {
        let before = wrong.len();
        let mut holds = Vec::new();
        for robot in script.problem.robot_ids() {
            collect_holds(script, robot, &mut holds, wrong);
        }
        if wrong.len() > before {
            return None;
        }
        holds.sort_by(|a, b| a.from.total_cmp(&b.from));
        let mut standings = Vec::new();
        for object in (0..script.problem.movable.len()).map(ObjectId::at) {
            collect_standings(script, object, &holds, &mut standings, wrong);
        }
        (wrong.len() == before).then_some(Self { holds, standings })
    }

    pub(crate) fn hold_of(&self, pair: PairId) -> Option<&Hold> {
        self.holds.iter().find(|hold| hold.pair == pair)
    }
}

/// Attach and detach must alternate through the robot's pairs in their order; it may break off early (V13's business).
fn collect_holds(script: &Script, robot: RobotId, holds: &mut Vec<Hold>, wrong: &mut Vec<Violation>) {
    let steps: Vec<usize> = (0..script.steps.len()).filter(|i| script.steps[*i].robot == robot).collect();
    let expected =
        script.problem.pairs_of_robot(robot).flat_map(|pair| [(pair, EventKind::Attach), (pair, EventKind::Detach)]);
    let mut expected = expected.collect::<Vec<_>>().into_iter();
    let mut last_knot = None;
    for i in steps {
        let step = &script.steps[i];
        let name = script.pair_name(step.pair);
        match expected.next() {
            Some((pair, kind)) if pair == step.pair && kind == step.kind => {}
            Some((pair, kind)) => {
                let due = script.pair_name(pair);
                let message = format!("{:?} of {name} where {kind:?} of {due} is due", step.kind);
                return wrong.push(script.about(step, Rule::V5, message));
            }
            None => {
                let message = format!("{:?} of {name} after the robot's last pair", step.kind);
                return wrong.push(script.about(step, Rule::V5, message));
            }
        }
        if last_knot.is_some_and(|last| last >= step.knot) {
            let message = format!("{:?} of {name} at knot {}, not after the event before it", step.kind, step.knot);
            return wrong.push(script.about(step, Rule::V5, message));
        }
        last_knot = Some(step.knot);
        add_step(step, i, holds);
    }
}

fn add_step(step: &Step, index: usize, holds: &mut Vec<Hold>) {
    let Step { robot, pair, object, t, .. } = *step;
    match step.kind {
        EventKind::Attach => {
            holds.push(Hold { robot, pair, object, attach: index, detach: None, from: t, to: f64::INFINITY });
        }
        EventKind::Detach => {
            if let Some(hold) = holds.last_mut() {
                (hold.detach, hold.to) = (Some(index), t);
            }
        }
    }
}

/// `holds` in order of time. The object must be handed on in the order of its hops, from one hand at a time.
fn collect_standings(
    script: &Script,
    object: ObjectId,
    holds: &[Hold],
    standings: &mut Vec<Standing>,
    wrong: &mut Vec<Violation>,
) {
    let movable = &script.problem.movable[object.index()];
    let hops = script.problem.hops_of_object(object);
    let first_region = hops.first().map(|pair| script.problem.pair(*pair).from);
    let support = movable.start_support.or(first_region.map(|r| script.problem.regions[r.index()].support));
    let world_from_object = Frame::of(&movable.world_from_start);
    let (from, to) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut standing = Standing { object, world_from_object, from, to, put_by: None, taken_by: None, support };
    let own: Vec<usize> = (0..holds.len()).filter(|i| holds[*i].object == object).collect();
    for (turn, &i) in own.iter().enumerate() {
        let (hold, attach) = (&holds[i], &script.steps[holds[i].attach]);
        if hold.from < standing.from {
            let holder = &holds[own[turn - 1]];
            let message = format!(
                "{} is attached by {} while {} holds it",
                movable.name,
                script.robot_name(hold.robot),
                script.robot_name(holder.robot)
            );
            return wrong.push(script.about(attach, Rule::V8, message).robot(script.robot_name(holder.robot)));
        }
        if hops.get(turn) != Some(&hold.pair) {
            let message =
                format!("{} moves {} out of the order of its hops", script.pair_name(hold.pair), movable.name);
            return wrong.push(script.about(attach, Rule::V5, message));
        }
        (standing.to, standing.taken_by) = (hold.from, Some(i));
        let region = &script.problem.regions[script.problem.pair(hold.pair).to.index()];
        let pose = hold.detach.map(|d| script.steps[d].world_from_object);
        let next = Standing {
            object,
            world_from_object: pose.unwrap_or(Frame::IDENTITY),
            from: hold.to,
            to: f64::INFINITY,
            put_by: Some(i),
            taken_by: None,
            support: Some(region.support),
        };
        standings.push(std::mem::replace(&mut standing, next));
    }
    if standing.from < f64::INFINITY {
        standings.push(standing);
    }
}
