//! From timed cells to knots and segments.

use plan::{Knot, ModeKind, RobotTrajectory, Segment, SegmentKind};
use skeleton::Mode;

use crate::Scene;

use super::cells::RobotCells;

/// The knots at a boundary between cells: where the robot comes to it, and where it leaves it; one unless it waits there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BoundaryKnots {
    pub reach: usize,
    pub leave: usize,
}

/// A robot's knots, and those of its boundaries: boundary 0 is the start, boundary i the end of cell i - 1.
#[derive(Clone, Debug)]
pub(crate) struct Knots {
    pub knots: Vec<Knot>,
    pub boundaries: Vec<Option<BoundaryKnots>>,
}

impl Knots {
    /// Knots where moves end, where arcs need them (`named`, by boundary) and, in pairs, where the robot waits.
    pub fn new(cells: &RobotCells, times: &[(f64, f64)], named: &[bool]) -> Self {
        let count = cells.cells.len();
        let (mut knots, mut boundaries) = (Vec::new(), Vec::new());
        for boundary in 0..=count {
            let before = boundary.checked_sub(1).map(|cell| &cells.cells[cell]);
            let reach_s = boundary.checked_sub(1).map_or(0.0, |cell| times[cell].1);
            let leave_s = times.get(boundary).map_or(reach_s, |(begins_s, _)| *begins_s);
            let waits = leave_s > reach_s;
            if !(waits || named[boundary] || before.is_none_or(|cell| cell.ends_move)) {
                boundaries.push(None);
                continue;
            }
            let q = before.map_or(&cells.start, |cell| &cell.to);
            let reach = knots.len();
            knots.push(Knot { t: reach_s, q: q.clone() });
            if waits {
                knots.push(Knot { t: leave_s, q: q.clone() });
            }
            boundaries.push(Some(BoundaryKnots { reach, leave: knots.len() - 1 }));
        }
        Self { knots, boundaries }
    }

    /// Knots of a boundary that has some.
    pub fn at(&self, boundary: usize) -> BoundaryKnots {
        let last = self.knots.len() - 1;
        self.boundaries.get(boundary).copied().flatten().unwrap_or(BoundaryKnots { reach: last, leave: last })
    }

    /// The robot's trajectory.
    pub fn trajectory(&self, scene: &Scene, robot: usize, cells: &RobotCells) -> RobotTrajectory {
        let of_robot = &scene.problem().robots[robot];
        RobotTrajectory {
            name: of_robot.name.clone(),
            joints: of_robot.coordinates.iter().map(|coordinate| coordinate.name.clone()).collect(),
            knots: self.knots.clone(),
            segments: self.segments(scene, &scene.skeleton.modes[robot], cells),
        }
    }

    fn segments(&self, scene: &Scene, modes: &[Mode], cells: &RobotCells) -> Vec<Segment> {
        let mut segments: Vec<Segment> = Vec::new();
        let mut leave = 0;
        for (boundary, knots) in self.boundaries.iter().enumerate() {
            let Some(BoundaryKnots { reach, leave: next }) = *knots else { continue };
            if let Some(cell) = boundary.checked_sub(1) {
                push(&mut segments, named_segment(scene, modes, cells, cell, (leave, reach), cells.cells[cell].kind));
            }
            for (step, mode) in modes.iter().enumerate().filter(|(step, _)| folds_at_once(cells, *step, boundary)) {
                let pair = mode.begins.map(|event| scene.problem().pair(event.pair).name.clone());
                let kind = SegmentKind::Retract;
                segments.push(Segment { from: reach, to: reach, pair, mode: modes[step].kind, kind });
            }
            if next > reach {
                push(&mut segments, named_segment(scene, modes, cells, boundary, (reach, next), SegmentKind::Wait));
            }
            leave = next;
        }
        segments
    }
}

/// Whether a mode's arm is folded at a boundary without having been moved: its retract is empty, but it is there.
fn folds_at_once(cells: &RobotCells, step: usize, boundary: usize) -> bool {
    let Some(mode) = cells.modes.get(step).filter(|mode| mode.fold == Some(boundary)) else { return false };
    cells.cells[mode.first..boundary].iter().all(|cell| cell.kind != SegmentKind::Retract)
}

/// A stretch that cell `cell` is part of, or that it follows.
fn named_segment(
    scene: &Scene,
    modes: &[Mode],
    cells: &RobotCells,
    cell: usize,
    (from, to): (usize, usize),
    kind: SegmentKind,
) -> Segment {
    let step = cells.cells.get(cell).map_or(modes.len().saturating_sub(1), |cell| cell.step);
    let retracts = cells.modes.get(step).is_some_and(|mode| mode.fold.is_some_and(|fold| cell < fold));
    let (mode, begins) = modes.get(step).map_or((ModeKind::Return, None), |mode| (mode.kind, mode.begins));
    let begun = begins.filter(|_| retracts).map(|event| event.pair);
    let pair = begun.or_else(|| modes.get(step).and_then(|mode| mode.pair));
    Segment { from, to, pair: pair.map(|pair| scene.problem().pair(pair).name.clone()), mode, kind }
}

/// Appends a stretch, or lengthens the last segment if it is of the same kind.
fn push(segments: &mut Vec<Segment>, next: Segment) {
    match segments.last_mut() {
        Some(last)
            if last.to == next.from
                && last.from < last.to
                && (&last.pair, last.mode, last.kind) == (&next.pair, next.mode, next.kind) =>
        {
            last.to = next.to;
        }
        _ => segments.push(next),
    }
}
