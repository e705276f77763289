//! Rounds of a synchronous schedule as arcs: no unit of a round begins before all of the round before it are over.

use contract::Interrupted;
use skeleton::{Mode, ModeId};

use super::cells::RobotCells;
use super::order::CellArc;
use crate::Scene;

/// Times up to this apart (s) count as equal.
const EQUAL_S: f64 = 1e-9;

/// First and last cell of a unit: robot and numbers.
type UnitCells = (usize, usize, usize);

/// Arcs from every unit of a round to every unit of the next. Units that take no time are nowhere.
///
/// # Errors
/// [`Interrupted::Unfit`] if the rounds do not hold every mode once, each robot's in order.
pub(crate) fn barriers(
    scene: &Scene,
    robots: &[RobotCells],
    rounds: &[Vec<ModeId>],
) -> Result<Vec<CellArc>, Interrupted> {
    if rounds.is_empty() {
        return Ok(Vec::new());
    }
    check_rounds(&scene.skeleton.modes, rounds)?;
    let pause = usize::from(scene.problem().settings.grip_time > 0.0);
    let cells_of = |mode: &ModeId| unit_cells(&robots[mode.robot.index()], *mode, pause);
    let units: Vec<Vec<UnitCells>> = rounds.iter().map(|round| round.iter().filter_map(cells_of).collect()).collect();
    let units: Vec<Vec<UnitCells>> = units.into_iter().filter(|round| !round.is_empty()).collect();
    let mut arcs = Vec::new();
    for pair in units.windows(2) {
        for (before, _, last) in &pair[0] {
            let others = pair[1].iter().filter(|(after, ..)| after != before);
            arcs.extend(others.map(|(after, first, _)| CellArc { before: (*before, *last), after: (*after, *first) }));
        }
    }
    let cell = |(robot, cell): (usize, usize)| &robots[robot].cells[cell];
    if arcs.iter().any(|arc: &CellArc| cell(arc.before).ends_s > cell(arc.after).begins_s + EQUAL_S) {
        return Err(Interrupted::Unfit("the rounds are not those of the prefix".into()));
    }
    Ok(arcs)
}

/// A mode's cells without the hand's pause at its begin, which belongs to the mode before, but with the one at its end.
fn unit_cells(robot: &RobotCells, mode: ModeId, pause: usize) -> Option<UnitCells> {
    let step = mode.step as usize;
    let begins = |step: usize| robot.modes.get(step).map(|cells| cells.first + if step > 0 { pause } else { 0 });
    let (first, end) = (begins(step)?, begins(step + 1).unwrap_or(robot.cells.len()));
    (first < end).then(|| (mode.robot.index(), first, end - 1))
}

fn check_rounds(modes: &[Vec<Mode>], rounds: &[Vec<ModeId>]) -> Result<(), Interrupted> {
    let mut done = vec![0; modes.len()];
    for round in rounds {
        let mut moved = vec![false; modes.len()];
        for mode in round {
            let robot = mode.robot.index();
            let is_next = done.get(robot) == Some(&mode.step) && !moved[robot];
            if !is_next {
                return Err(Interrupted::Unfit(format!("mode {mode:?} is not the next of its robot in the rounds")));
            }
            (done[robot], moved[robot]) = (mode.step + 1, true);
        }
    }
    if done.iter().zip(modes).any(|(done, modes)| *done as usize != modes.len()) {
        return Err(Interrupted::Unfit("the rounds do not hold all modes".into()));
    }
    Ok(())
}
