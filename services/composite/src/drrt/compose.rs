//! One composite step from the robots' wishes: who has priority does as it wishes, the others give way.

use super::mode_vector::VectorId;
use super::rules::{Act, Refused, Rules, State, Step};
use super::validity::CompositeValidity;

/// Acts tried before a step is given up, for each robot.
const TRIES_PER_ROBOT: usize = 64;

/// What each robot would do, and whose wishes come first.
pub(super) struct Wishes {
    /// Robots, highest priority first.
    pub order: Vec<usize>,
    /// For each robot, acts to try in turn; never empty.
    pub acts: Vec<Vec<Act>>,
}

/// What came of it.
pub(super) struct Composed {
    /// The first step that keeps all rules, in lexicographic order of the wishes.
    pub step: Option<(Vec<Act>, Step)>,
    /// What spoke against first wishes.
    pub refused: Vec<Refused>,
}

impl<V: CompositeValidity> Rules<'_, V> {
    /// Finds a composite step by depth-first search over the robots in order of priority.
    pub fn compose(&mut self, state: &State, wishes: &Wishes) -> Composed {
        let mut refused = Vec::new();
        let first: Vec<Act> = wishes.acts.iter().map(|acts| acts[0]).collect();
        let mut step = self.compose_with(state, wishes, &first, &mut refused);
        if step.is_none() && first.contains(&Act::Event) {
            // An event that cannot happen now, say because a robot stands where the object would: all else may go on.
            step = self.compose_with(state, wishes, &vec![Act::Stay; first.len()], &mut refused);
        }
        Composed { step, refused }
    }

    /// The events are those of `events`, no others.
    fn compose_with(
        &mut self,
        state: &State,
        wishes: &Wishes,
        events: &[Act],
        refused: &mut Vec<Refused>,
    ) -> Option<(Vec<Act>, Step)> {
        let vector = self.after_events(state, events);
        let choices = |robot: usize| match events[robot] {
            Act::Event => vec![Act::Event],
            _ => wishes.acts[robot].iter().copied().filter(|act| *act != Act::Event).collect(),
        };
        let choices: Vec<Vec<Act>> = (0..events.len()).map(choices).collect();
        let mut acts = vec![Act::Stay; events.len()];
        // How many choices each robot that has chosen has been through, in order of priority.
        let mut chosen: Vec<usize> = vec![0];
        let mut tries = TRIES_PER_ROBOT * events.len();
        while let Some(depth) = chosen.len().checked_sub(1) {
            let robot = wishes.order[depth];
            let Some(act) = choices[robot].get(chosen[depth]).copied() else {
                chosen.pop();
                chosen.last_mut().into_iter().for_each(|last| *last += 1);
                continue;
            };
            tries = tries.checked_sub(1)?;
            acts[robot] = act;
            match self.refusal(state, vector, &acts, &wishes.order[..depth], robot) {
                Some(refusal) => {
                    if chosen[depth] == 0 {
                        refused.push(refusal);
                    }
                    chosen[depth] += 1;
                }
                None if depth + 1 < wishes.order.len() => chosen.push(0),
                None if acts.iter().all(|act| *act == Act::Stay) => chosen[depth] += 1,
                None => return Some((acts.clone(), self.step(state, &acts))),
            }
        }
        None
    }

    /// What speaks against a robot's act, given the acts of those before it.
    fn refusal(
        &mut self,
        state: &State,
        vector: VectorId,
        acts: &[Act],
        before: &[usize],
        robot: usize,
    ) -> Option<Refused> {
        if !self.may_alone(state, vector, robot, acts[robot]) {
            return Some(Refused::Alone(robot));
        }
        let own = (robot, acts[robot]);
        for other in before {
            if self.would_meet(state, vector, (*other, acts[*other]), own) {
                return Some(Refused::Pair(*other, robot));
            }
        }
        None
    }
}
