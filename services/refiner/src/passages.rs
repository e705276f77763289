//! Modes that another robot makes impossible, wherever it is: no composite motion exists, so none is searched for.

use contract::{Answer, Composition, Decision, StageKind};
use model::{Problem, RobotId};
use plan::{BodyRef, Cause};
use skeleton::{Mode, ModeId};

use crate::asking::misfit;
use crate::candidate::{Candidate, Modes};
use crate::compose::roadmaps_of;
use crate::conflict::{Choice, Conflict, Halt};
use crate::search::Search;

impl Candidate<'_> {
    /// The conflict of the first mode that has no passage.
    pub(crate) fn no_passage(&self, search: &mut Search<'_>, modes: &Modes) -> Result<Option<Conflict>, Halt> {
        let job = self.compose_job(Composition::Passages { roadmaps: roadmaps_of(modes) });
        let found = match search.ask_one(&job)?.result {
            Ok(Answer::NoPassage(found)) => found,
            Ok(_) => return Err(misfit(StageKind::Composite).into()),
            // Who cannot tell has found none.
            Err(_) => Vec::new(),
        };
        let Some((mode, other)) = found.first().copied() else { return Ok(None) };
        let known = self.skeleton.modes.get(mode.robot.index()).and_then(|modes| modes.get(mode.step as usize));
        let Some(known) = known.filter(|_| other.index() < self.problem.robots.len()) else {
            return Err(misfit(StageKind::Composite).into());
        };
        let cause = no_passage(self.problem, known, other);
        search.backtrack(StageKind::Composite, Decision::Commit(mode), Some(cause.clone()));
        Ok(Some(Conflict::of(self.choices_of_passage(mode, other), &[(cause, 1)], Some(search.id(&job)))))
    }

    /// What a passage depends on: the pairs at the mode's ends, how the other robot does its own, and what stands about.
    fn choices_of_passage(&self, mode: ModeId, other: RobotId) -> Vec<Choice> {
        let mode = self.skeleton.mode(mode);
        let ends = mode.pair.into_iter().chain(mode.begins.map(|event| event.pair));
        let meanwhile = self.skeleton.modes[other.index()]
            .iter()
            .filter(|theirs| self.skeleton.graph.may_overlap(theirs.interval(), mode.interval()));
        let theirs = meanwhile.flat_map(|theirs| theirs.pair.into_iter().chain(theirs.begins.map(|event| event.pair)));
        let pairs = ends.chain(theirs).map(Choice::Alternative);
        pairs.chain(self.skeleton.occupancies().map(Choice::Pose)).collect()
    }
}

fn no_passage(problem: &Problem, mode: &Mode, other: RobotId) -> Cause {
    let (robot, other) = (problem.robot(mode.id.robot), problem.robot(other));
    let link = other.links.iter().find(|link| !link.bodies.is_empty()).or(other.links.first());
    let blocking = link.map(|link| BodyRef::Link { robot: other.name.clone(), link: link.name.clone() });
    Cause::NoPath {
        pair: mode.pair.map(|pair| problem.pair(pair).name.clone()),
        robot: robot.name.clone(),
        blocking: blocking.into_iter().collect(),
    }
}
