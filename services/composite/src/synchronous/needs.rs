//! From orderings to rounds: what must be done in earlier rounds than a unit.
//!
//! `X ≺ Y` asks that X's unit be in an earlier round than Y's. A point at which the arm is folded belongs to the mode in
//! which the arm is brought there; but where a mode begins with the arm folded already, to the unit before.

use contract::{Assignment, Interrupted};
use model::Point;
use skeleton::{ArcOrigin, Event, ModeId};

use super::team::TeamMode;
use crate::commit::Orders;
use crate::{CommittedMotion, Scene, Timeline};

/// How many units of which robots must be done before a unit.
#[derive(Clone, Debug, Default)]
struct Need {
    /// Robot and number of its units.
    done: Vec<(usize, u32)>,
    /// Something would have to come before the plan begins.
    never: bool,
}

/// Needs of every unit.
#[derive(Clone, Debug)]
pub(super) struct Needs(Vec<Vec<Need>>);

impl Needs {
    /// What the given orderings and the assignment's ask for.
    ///
    /// # Errors
    /// [`Interrupted::Unfit`] if they contradict one another.
    pub fn new(scene: &Scene, assignment: &Assignment, modes: &[Vec<TeamMode<'_>>]) -> Result<Self, Interrupted> {
        let graph = scene.graph(assignment)?;
        let timeline = Timeline::new(scene, assignment, CommittedMotion::default())?;
        let orders = Orders { scene, graph: &graph, timeline: &timeline };
        let mut needs: Vec<Vec<Need>> = modes.iter().map(|of_robot| vec![Need::default(); of_robot.len()]).collect();
        for arc in graph.arcs().iter().filter(|arc| arc.origin != ArcOrigin::Robot) {
            let before = orders.mode_of(arc.before).and_then(|mode| unit_of(modes, mode, arc.before));
            let after = orders.mode_of(arc.after);
            let unit = after.and_then(|mode| unit_of(modes, mode, arc.after));
            let robot = scene.problem().pair(arc.after.pair).robot.index();
            match (before, unit) {
                // The beginning of the plan is before everything.
                (None, _) => {}
                (Some(before), _) if before.robot.index() == robot => {}
                (Some(before), Some(unit)) => {
                    needs[robot][unit.step as usize].done.push((before.robot.index(), before.step + 1));
                }
                (Some(_), None) => needs[robot].iter_mut().take(1).for_each(|need| need.never = true),
            }
        }
        Ok(Self(needs))
    }

    /// Whether all that must come in earlier rounds than a robot's unit is done.
    pub fn are_met(&self, robot: usize, unit: u32, done: &[u32]) -> bool {
        let need = self.0[robot].get(unit as usize);
        need.is_some_and(|need| !need.never && need.done.iter().all(|(other, units)| done[*other] >= *units))
    }
}

/// The unit at whose end, or in which, an event happens that belongs to a mode. `None`: the beginning of the plan.
fn unit_of(modes: &[Vec<TeamMode<'_>>], mode: ModeId, event: Event) -> Option<ModeId> {
    let graph = &modes[mode.robot.index()][mode.step as usize].graph;
    let (start, goal) = (graph.roadmap.start, graph.roadmap.goal);
    let with_the_fold = match event.point {
        Point::Grasp | Point::Release => false,
        Point::Carry | Point::Done | Point::Start => true,
        Point::AtPick | Point::AtPlace => graph.same_stand(start, goal),
    };
    if with_the_fold && graph.is_folded(start) {
        return mode.step.checked_sub(1).map(|step| ModeId { step, ..mode });
    }
    Some(mode)
}
