//! The lower bound `assignment-roadmap`: no plan with the same placements, grasps, transition configurations and roadmaps
//! has its work done earlier.

use contract::Interrupted;
use model::{Point, Problem};
use skeleton::{Event, EventGraph, ModeKind, Skeleton};

use crate::points::same_stand;

use super::cells::RobotCells;

/// Longest path to any `done` over the order on events; a mode takes at least its least time on its roadmap (s), and a
/// hand's pause before it.
///
/// # Errors
/// [`Interrupted::Unfit`] if `shortest_s` does not fit the modes.
pub(crate) fn lower_bound_s(
    problem: &Problem,
    skeleton: &Skeleton,
    graph: &EventGraph,
    shortest_s: &[Vec<f64>],
    robots: &[RobotCells],
) -> Result<f64, Interrupted> {
    let fits = shortest_s.len() == skeleton.modes.len()
        && shortest_s.iter().zip(&skeleton.modes).all(|(times, modes)| times.len() == modes.len())
        && shortest_s.iter().flatten().all(|time| time.is_finite() && *time >= 0.0);
    if !fits {
        return Err(Interrupted::Unfit("least times that do not fit the modes".into()));
    }
    let events: Vec<Event> = graph.events().collect();
    let position = |event: Event| events.binary_search(&event).unwrap_or(0);
    let mut earliest_s = vec![0.0_f64; events.len()];
    let arcs: Vec<(usize, usize)> =
        graph.arcs().iter().map(|arc| (position(arc.before), position(arc.after))).collect();
    let mut chains: Vec<(usize, usize, f64)> = arcs.iter().map(|(before, after)| (*before, *after, 0.0)).collect();
    for (robot, modes) in skeleton.modes.iter().enumerate() {
        for (step, mode) in modes.iter().enumerate() {
            let least_s = shortest_s[robot][step];
            match (mode.begins, mode.ends) {
                (None, Some(ends)) => earliest_s[position(ends)] = least_s,
                (Some(begins), Some(ends)) => {
                    chains.push((position(begins), position(ends), problem.settings.grip_time + least_s));
                }
                _ => {}
            }
            if let Some(begins) = mode.begins.filter(|event| event.point == Point::Release) {
                let whole = mode.kind == ModeKind::Return && stays(problem, robot, robots, step);
                let fold_s = if whole { least_s } else { least_fold_s(problem, robot, robots, step) };
                let done = Event::new(begins.pair, Point::Done);
                chains.push((position(begins), position(done), problem.settings.grip_time + fold_s));
            }
        }
    }
    // The order has no cycle, so that many rounds settle it; usually a few do.
    for _ in 0..=events.len() {
        let before = earliest_s.clone();
        for (from, to, least_s) in &chains {
            earliest_s[*to] = earliest_s[*to].max(earliest_s[*from] + least_s);
        }
        if earliest_s == before {
            break;
        }
    }
    let done = events.iter().zip(&earliest_s).filter(|(event, _)| event.point == Point::Done);
    Ok(done.fold(0.0, |latest, (_, time_s)| time_s.max(latest)))
}

/// Least time of the straight motion that folds the arm after the event that begins a mode (s).
fn least_fold_s(problem: &Problem, robot: usize, robots: &[RobotCells], step: usize) -> f64 {
    let robot_cells = &robots[robot];
    let Some(at) = robot_cells.modes.get(step).and_then(|mode| mode.first.checked_sub(1)) else { return 0.0 };
    let (robot, q) = (&problem.robots[robot], &robot_cells.cells[at].to);
    let folded = [&q[..robot.base_len()], &robot.home].concat();
    robot.duration(q, &robot.short_way(q, &folded))
}

/// Whether a closing return only folds the arm, so that it is over when the last pair is done.
fn stays(problem: &Problem, robot: usize, robots: &[RobotCells], step: usize) -> bool {
    let (robot, cells) = (&problem.robots[robot], &robots[robot]);
    let Some(mode) = cells.modes.get(step) else { return false };
    let end = mode.last.checked_sub(1).map_or(&cells.start, |last| &cells.cells[last].to);
    let from = mode.first.checked_sub(1).map_or(&cells.start, |last| &cells.cells[last].to);
    same_stand(robot, from, end) && crate::points::is_folded(robot, false, end) && mode.fold == Some(mode.last)
}
