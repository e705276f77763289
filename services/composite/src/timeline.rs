//! What is committed, in time: motions of all robots and poses of all objects.

use collision::Motion;
use contract::{Assignment, Commitment, Interrupted, Move};
use model::{AllowedContacts, Holding, Problem, RobotId};
use skeleton::{Event, Occupancy};

use crate::conflict::cell_times;
use crate::{CommittedMotion, Scene, TimedStanding, Travel};

/// A committed move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedMove {
    /// Motion and its cells.
    pub travel: Travel,
    /// Begin (s).
    pub begins_s: f64,
    /// End (s); infinite for the last standing.
    pub ends_s: f64,
}

impl TimedMove {
    /// A move of a robot.
    #[must_use]
    pub fn new(scene: &Scene, robot: RobotId, holding: Option<Holding>, step: &Move) -> Self {
        let travel = scene.conflicts.travel(&motion_of(robot, holding, step));
        Self { travel, begins_s: step.begins_s, ends_s: step.ends_s }
    }

    /// Begin and end of a cell (s).
    #[must_use]
    pub fn cell_times(&self, cell: u32) -> (f64, f64) {
        cell_times(self.travel.cells, cell, self.begins_s, self.ends_s)
    }

    /// The cell that is travelled at a time (s) within the move.
    #[must_use]
    pub fn cell_at(&self, time_s: f64) -> u32 {
        if self.travel.cells == 1 {
            return 0;
        }
        let share = (time_s - self.begins_s) / (self.ends_s - self.begins_s);
        let cell = (share * f64::from(self.travel.cells)).max(0.0) as u32;
        cell.min(self.travel.cells - 1)
    }
}

/// The motion of a move.
#[must_use]
pub fn motion_of(robot: RobotId, holding: Option<Holding>, step: &Move) -> Motion {
    Motion { robot, holding, from: step.from.clone(), to: step.to.clone(), allowed: step.allowed }
}

/// What one robot is committed to.
#[derive(Clone, Debug)]
pub struct RobotTimeline {
    /// Robot.
    pub robot: RobotId,
    /// Its commitments, in the order of its modes.
    pub commitments: Vec<Commitment>,
    /// All motion from 0 s on without gaps, the last commitment's tail included; the last move stands for ever.
    pub moves: Vec<TimedMove>,
    /// Configuration of the last standing.
    pub rests_at: Vec<f64>,
}

impl RobotTimeline {
    fn new(scene: &Scene, robot: RobotId, commitments: Vec<Commitment>, first_tail: &[Move]) -> Self {
        let mut moves = Vec::new();
        let mut rests_at = scene.problem().robot(robot).start.clone();
        let (mut ends_s, mut holding, mut allowed) = (0.0, None, AllowedContacts::default());
        let mut push = |step: &Move, held: Option<Holding>| {
            if step.ends_s > step.begins_s {
                moves.push(TimedMove::new(scene, robot, held, step));
            }
            rests_at.clone_from(&step.to);
            allowed = if step.from == step.to { step.allowed } else { AllowedContacts::default() };
            (ends_s, holding) = (step.ends_s, held);
        };
        for commitment in &commitments {
            commitment.moves.iter().for_each(|step| push(step, commitment.holding));
        }
        if commitments.is_empty() {
            first_tail.iter().for_each(|step| push(step, None));
        }
        if let Some(last) = commitments.last() {
            last.tail.iter().for_each(|step| push(step, last.tail_holding));
            if last.tail.is_empty() {
                holding = last.tail_holding;
            }
        }
        let rest = Motion { robot, holding, from: rests_at.clone(), to: rests_at.clone(), allowed };
        moves.push(TimedMove { travel: scene.conflicts.travel(&rest), begins_s: ends_s, ends_s: f64::INFINITY });
        Self { robot, commitments, moves, rests_at }
    }

    /// When the last committed mode ended (s); 0 if none is committed.
    #[must_use]
    pub fn event_s(&self) -> f64 {
        self.commitments.last().map_or(0.0, |last| last.event_s)
    }

    /// When the robot comes to its last standing (s).
    #[must_use]
    pub fn rests_from_s(&self) -> f64 {
        self.moves.last().map_or(0.0, |rest| rest.begins_s)
    }

    /// Moves that are not over at `time_s`, in order.
    #[must_use]
    pub fn moves_after(&self, time_s: f64) -> &[TimedMove] {
        &self.moves[self.moves.partition_point(|step| step.ends_s <= time_s)..]
    }
}

/// What all robots and objects are committed to.
#[derive(Clone, Debug)]
pub struct Timeline {
    /// Robots, indexed by their identifiers.
    pub robots: Vec<RobotTimeline>,
    /// Poses of objects that are taken at some time, object by object, in hop order. A pose that a robot brings counts
    /// from the beginning of the last cell before the release: who is in its way must be gone before that cell, for an
    /// arc of the plan can hold the bringer only at a cell's boundary.
    pub standings: Vec<(Occupancy, TimedStanding)>,
}

impl Timeline {
    /// The timeline of committed motion.
    ///
    /// # Errors
    /// [`Interrupted::Unfit`] if the commitments cannot be of this problem or the assignment lacks a pose.
    pub fn new(scene: &Scene, assignment: &Assignment, motion: CommittedMotion) -> Result<Self, Interrupted> {
        motion.check(scene)?;
        let CommittedMotion { commitments, first_tails } = motion;
        let mut of_robots: Vec<Vec<Commitment>> = vec![Vec::new(); scene.problem().robots.len()];
        for commitment in commitments {
            of_robots[commitment.mode.robot.index()].push(commitment);
        }
        let first_tail = |robot: &RobotId| first_tails.get(robot).map_or(&[][..], Vec::as_slice);
        let robots = (0..).map(RobotId::at).zip(of_robots);
        let robots = robots.map(|(id, own)| RobotTimeline::new(scene, id, own, first_tail(&id))).collect();
        let mut timeline = Self { robots, standings: Vec::new() };
        for (object, hops) in scene.skeleton.hops.iter().enumerate() {
            for hop in 0..=hops.len() {
                let occupancy = Occupancy { object: model::ObjectId::at(object), hop: hop as u32 };
                let brought = hop.checked_sub(1).map(|before| Event::release(hops[before]));
                let Some(from_s) = brought.map_or(Some(f64::NEG_INFINITY), |event| timeline.approach_s(scene, event))
                else {
                    break;
                };
                let standing = scene.standing(assignment, occupancy)?;
                let taken = hops.get(hop).and_then(|pair| timeline.event_s(scene, Event::grasp(*pair)));
                let standing = TimedStanding { standing, from_s, until_s: taken.unwrap_or(f64::INFINITY) };
                timeline.standings.push((occupancy, standing));
            }
        }
        Ok(timeline)
    }

    /// One robot.
    #[must_use]
    pub fn robot(&self, robot: RobotId) -> &RobotTimeline {
        &self.robots[robot.index()]
    }

    /// The commitment that ends with a grasp or release.
    #[must_use]
    pub fn commitment_to(&self, scene: &Scene, event: Event) -> Option<&Commitment> {
        let robot = owner(scene.problem(), event);
        let modes = &scene.skeleton.modes[robot.index()];
        let step = modes.iter().position(|mode| mode.ends == Some(event))?;
        self.robot(robot).commitments.get(step)
    }

    /// When a grasp or release happens (s), if it is committed.
    #[must_use]
    pub fn event_s(&self, scene: &Scene, event: Event) -> Option<f64> {
        self.commitment_to(scene, event).map(|commitment| commitment.event_s)
    }

    /// When the last moving cell before a grasp or release begins (s), if it is committed.
    #[must_use]
    pub fn approach_s(&self, scene: &Scene, event: Event) -> Option<f64> {
        self.commitment_to(scene, event).map(|commitment| approach_s(scene, commitment))
    }
}

/// When the last moving cell of a commitment begins (s).
pub(crate) fn approach_s(scene: &Scene, commitment: &Commitment) -> f64 {
    let Some(last) = commitment.moves.iter().rev().find(|step| step.from != step.to && step.ends_s > step.begins_s)
    else {
        return commitment.moves.last().map_or(commitment.event_s, |stand| stand.begins_s);
    };
    let last = TimedMove::new(scene, commitment.mode.robot, commitment.holding, last);
    last.cell_times(last.travel.cells - 1).0
}

/// The robot that does a pair.
fn owner(problem: &Problem, event: Event) -> RobotId {
    problem.pair(event.pair).robot
}
