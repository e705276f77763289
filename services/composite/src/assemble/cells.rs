//! Committed motion as sequences of cells, waits left out.

use contract::{Commitment, Move};
use model::{Configuration, RobotId};
use plan::SegmentKind;
use skeleton::{Event, Mode};

use crate::points::{arrival_len, retract_len, same_stand};
use crate::timeline::{RobotTimeline, motion_of};
use crate::{Scene, TimedMove, Travel};

/// Least time of the stand with which an event happens where the robot is already (s).
const INSTANT_S: f64 = 1e-6;

/// A part of a robot's motion that is never interrupted.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    pub travel: Travel,
    /// Which cell of the motion.
    pub cell: u32,
    /// Committed times (s).
    pub begins_s: f64,
    pub ends_s: f64,
    /// Time it takes (s).
    pub duration_s: f64,
    /// Configuration at its end.
    pub to: Configuration,
    /// Whether a move ends with it.
    pub ends_move: bool,
    /// The grasp or release at its end.
    pub event: Option<Event>,
    pub kind: SegmentKind,
    /// Position of its mode in the robot's sequence.
    pub step: usize,
}

/// Where the points of a mode lie: each number counts the robot's cells up to there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ModeCells {
    /// Where the mode begins.
    pub first: usize,
    /// Where the arm is first folded after the event that begins the mode.
    pub fold: Option<usize>,
    /// Where the base has come to stand until the end, the arm folded.
    pub arrive: usize,
    /// Where the mode ends.
    pub last: usize,
}

/// One robot's cells.
#[derive(Clone, Debug)]
pub(crate) struct RobotCells {
    pub start: Configuration,
    pub cells: Vec<Cell>,
    pub modes: Vec<ModeCells>,
}

impl RobotCells {
    /// Cuts a robot's commitments.
    ///
    /// # Errors
    /// A sentence, if the hand's pause is missing somewhere.
    pub fn new(scene: &Scene, timeline: &RobotTimeline) -> Result<Self, String> {
        let start = scene.problem().robot(timeline.robot).start.clone();
        let mut cells = Self { start, cells: Vec::new(), modes: Vec::new() };
        let modes = &scene.skeleton.modes[timeline.robot.index()];
        let mut begins_s = 0.0;
        for (mode, commitment) in modes.iter().zip(&timeline.commitments) {
            cells.add_mode(scene, mode, commitment, begins_s)?;
            begins_s = commitment.event_s;
        }
        Ok(cells)
    }

    fn add_mode(&mut self, scene: &Scene, mode: &Mode, commitment: &Commitment, begins_s: f64) -> Result<(), String> {
        let robot = scene.problem().robot(mode.id.robot);
        let moves = &commitment.moves;
        let holding = commitment.holding.is_some();
        let first = self.cells.len();
        let retract = if mode.begins.is_some() { retract_len(robot, holding, moves) } else { None };
        let whole_return = mode.ends.is_none() && retract.is_none();
        let (mut fold, mut arrive) = (None, first);
        if mode.begins.is_some() {
            self.add_pause(scene, mode, commitment, begins_s)?;
        }
        let moving: Vec<(usize, &Move)> =
            moves.iter().enumerate().filter(|(_, m)| m.from != m.to && m.ends_s > m.begins_s).collect();
        let arrival = arrival_len(robot, moves);
        for (index, step) in moving {
            if retract.is_some_and(|retract| index >= retract) {
                fold.get_or_insert(self.cells.len());
            }
            let kind = if !same_stand(robot, &step.from, &step.to) {
                SegmentKind::Base
            } else if mode.begins.is_some() && (whole_return || retract.is_some_and(|retract| index < retract)) {
                SegmentKind::Retract
            } else {
                SegmentKind::Reach
            };
            self.add_move(scene, mode.id.robot, commitment, step, kind);
            if index < arrival {
                arrive = self.cells.len();
            }
        }
        if mode.ends.is_some() {
            self.add_event(scene, mode, commitment, first);
        }
        let last = self.cells.len();
        let fold = fold.or(retract.map(|_| last)).or(whole_return.then_some(last));
        self.modes.push(ModeCells { first, fold, arrive: arrive.max(fold.unwrap_or(first)), last });
        Ok(())
    }

    /// The hand's pause after the event that begins a mode.
    fn add_pause(&mut self, scene: &Scene, mode: &Mode, commitment: &Commitment, begins_s: f64) -> Result<(), String> {
        let pause_s = scene.problem().settings.grip_time;
        if pause_s <= 0.0 {
            return Ok(());
        }
        let stands = commitment.moves.iter().take_while(|step| step.from == step.to);
        let stands_until_s = stands.map(|step| step.ends_s).last().unwrap_or(begins_s);
        let Some(first) = commitment.moves.first().filter(|_| stands_until_s >= begins_s + pause_s - 1e-9) else {
            return Err(format!("robot {} does not pause after its event at {begins_s} s", mode.id.robot.0));
        };
        let pause = Move { ends_s: begins_s + pause_s, to: first.from.clone(), ..first.clone() };
        self.add_move(scene, mode.id.robot, commitment, &pause, SegmentKind::Wait);
        Ok(())
    }

    fn add_move(&mut self, scene: &Scene, robot: RobotId, commitment: &Commitment, step: &Move, kind: SegmentKind) {
        let travel = scene.conflicts.travel(&motion_of(robot, commitment.holding, step));
        let timed = TimedMove { travel, begins_s: step.begins_s, ends_s: step.ends_s };
        let duration_s = (step.ends_s - step.begins_s) / f64::from(travel.cells);
        for cell in 0..travel.cells {
            let (begins_s, ends_s) = timed.cell_times(cell);
            let ends_move = cell + 1 == travel.cells;
            let share = f64::from(cell + 1) / f64::from(travel.cells);
            let between = |(a, b): (&f64, &f64)| a + (b - a) * share;
            let to = if ends_move { step.to.clone() } else { step.from.iter().zip(&step.to).map(between).collect() };
            let mode = commitment.mode.step as usize;
            let event = None;
            self.cells.push(Cell {
                travel,
                cell,
                begins_s,
                ends_s,
                duration_s,
                to,
                ends_move,
                event,
                kind,
                step: mode,
            });
        }
    }

    /// Marks the last cell with the mode's event. Where the robot is there already, it stands for an instant.
    fn add_event(&mut self, scene: &Scene, mode: &Mode, commitment: &Commitment, first: usize) {
        let moves = self.cells[first..].iter().any(|cell| cell.kind != SegmentKind::Wait);
        if !moves {
            let at = self.cells.last().map_or_else(|| self.start.clone(), |cell| cell.to.clone());
            let last = commitment.moves.last();
            let stand = Move {
                from: at.clone(),
                to: at,
                begins_s: commitment.event_s - INSTANT_S,
                ends_s: commitment.event_s,
                kind: last.map_or(contract::EdgeKind::Arm, |step| step.kind),
                allowed: last.map(|step| step.allowed).unwrap_or_default(),
            };
            self.add_move(scene, mode.id.robot, commitment, &stand, SegmentKind::Wait);
        }
        if let Some(cell) = self.cells.last_mut() {
            cell.event = mode.ends;
        }
    }
}
