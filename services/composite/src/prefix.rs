//! Reading committed motion.

use std::collections::BTreeMap;

use contract::{Commitment, Interrupted, JobContext, Move, Prefix, Product, ProductRef, Tail};
use model::{Holding, Problem, RobotId};

use crate::Scene;

/// Longest chain of prefixes that is followed.
const LONGEST_CHAIN: usize = 1 << 16;

/// Committed motion of all robots.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CommittedMotion {
    /// In the order in which they were made.
    pub commitments: Vec<Commitment>,
    /// What robots do that have no commitment yet, from 0 s on.
    pub first_tails: BTreeMap<RobotId, Vec<Move>>,
}

impl From<Vec<Commitment>> for CommittedMotion {
    fn from(commitments: Vec<Commitment>) -> Self {
        Self { commitments, first_tails: BTreeMap::new() }
    }
}

impl CommittedMotion {
    /// What a robot does after its last commitment, or instead of standing where it starts.
    #[must_use]
    pub fn tail(&self, robot: RobotId) -> &[Move] {
        match self.last(robot) {
            Some(last) => &last.tail,
            None => self.first_tails.get(&robot).map_or(&[], Vec::as_slice),
        }
    }

    /// A robot's last commitment.
    #[must_use]
    pub fn last(&self, robot: RobotId) -> Option<&Commitment> {
        self.commitments.iter().rev().find(|commitment| commitment.mode.robot == robot)
    }

    /// Appends what a prefix adds.
    pub(crate) fn extend(&mut self, commitments: Vec<Commitment>, tails: Vec<Tail>) {
        for commitment in commitments {
            self.first_tails.remove(&commitment.mode.robot);
            self.commitments.push(commitment);
        }
        for Tail { robot, moves } in tails {
            match self.commitments.iter_mut().rev().find(|commitment| commitment.mode.robot == robot) {
                Some(last) => last.tail = moves,
                None => drop(self.first_tails.insert(robot, moves)),
            }
        }
    }

    /// Whether this can be of a problem: each robot's modes in order, configurations of the right length, moves without gaps
    /// in time or place.
    pub(crate) fn check(&self, scene: &Scene) -> Result<(), Interrupted> {
        let problem = scene.problem();
        let mut next: Vec<(usize, f64, Vec<f64>)> = problem.robots.iter().map(|r| (0, 0.0, r.start.clone())).collect();
        for (robot, tail) in &self.first_tails {
            let Some(robot) = problem.robots.get(robot.index()) else {
                return Err(Interrupted::Unfit("a tail of a robot that is none".into()));
            };
            check_moves(tail, 0.0, &robot.start, robot.coordinates.len())?;
        }
        for commitment in &self.commitments {
            let robot = commitment.mode.robot.index();
            let fits = |holding| is_holding_of(problem, commitment.mode.robot, holding);
            let Some((step, ends_s, at)) = next.get_mut(robot) else {
                return Err(Interrupted::Unfit("a commitment of a robot that is none".into()));
            };
            let is_next = commitment.mode.step as usize == *step && *step < scene.skeleton.modes[robot].len();
            let mode = scene.skeleton.modes[robot].get(*step);
            let held = mode.filter(|mode| mode.is_holding()).and_then(|mode| mode.pair);
            let holds = held.map(|pair| problem.pair(pair).object) == commitment.holding.map(|holding| holding.object);
            if !is_next || !holds || !fits(commitment.holding) || !fits(commitment.tail_holding) {
                return Err(Interrupted::Unfit(format!(
                    "commitment {:?} is not its robot's next mode",
                    commitment.mode
                )));
            }
            let dof = problem.robots[robot].coordinates.len();
            let (event_s, event_at) = check_moves(&commitment.moves, *ends_s, at, dof)?;
            if event_s != commitment.event_s {
                return Err(Interrupted::Unfit("a commitment whose event is not at the end of its moves".into()));
            }
            check_moves(&commitment.tail, event_s, &event_at, dof)?;
            (*step, *ends_s, *at) = (*step + 1, event_s, event_at);
        }
        Ok(())
    }
}

/// All motion of a prefix and its parents.
///
/// # Errors
/// [`Interrupted::Lacking`]; [`Interrupted::Unfit`] if a product is no prefix.
pub fn load_prefix(context: &mut JobContext<'_>, prefix: Option<ProductRef>) -> Result<CommittedMotion, Interrupted> {
    let mut parts = Vec::new();
    let mut next = prefix;
    while let Some(wanted) = next {
        context.spend(0)?;
        let Product::Prefix(Prefix { parent, commitments, tails }) = context.product(&wanted)? else {
            return Err(Interrupted::Unfit("a product that should be a prefix is none".into()));
        };
        parts.push((commitments, tails));
        next = parent;
        if parts.len() > LONGEST_CHAIN {
            return Err(Interrupted::Unfit("a prefix with too many parents".into()));
        }
    }
    let mut motion = CommittedMotion::default();
    parts.into_iter().rev().for_each(|(commitments, tails)| motion.extend(commitments, tails));
    Ok(motion)
}

/// Time and configuration at the end of moves that begin at `begins_s` and `at`.
fn check_moves(moves: &[Move], begins_s: f64, at: &[f64], dof: usize) -> Result<(f64, Vec<f64>), Interrupted> {
    let (mut time_s, mut at) = (begins_s, at.to_vec());
    for step in moves {
        let finite = step.to.iter().all(|x| x.is_finite()) && step.ends_s.is_finite();
        let follows = step.from == at && step.begins_s == time_s && step.ends_s >= step.begins_s;
        if !finite || !follows || step.to.len() != dof {
            return Err(Interrupted::Unfit(format!("a move at {time_s} s does not follow the one before it")));
        }
        (time_s, at) = (step.ends_s, step.to.clone());
    }
    Ok((time_s, at))
}

/// Whether a robot can hold this: nothing, or an object by one of its grasps for the robot.
pub(crate) fn is_holding_of(problem: &Problem, robot: RobotId, holding: Option<Holding>) -> bool {
    holding.is_none_or(|Holding { object, grasp }| {
        let grasps = problem.movable.get(object.index()).and_then(|object| object.grasps.get(robot.index()));
        grasps.is_some_and(|grasps| grasp.index() < grasps.len())
    })
}
