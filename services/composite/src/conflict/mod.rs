//! The conflict relation between cells of motions, and between cells and standing objects.

mod memo;

use std::cell::RefCell;
use std::sync::Arc;

use collision::{Geometry, Motion};
use model::{Holding, RobotId, Standing};
use nalgebra::Point3;

use memo::Memo;

/// Bound on how far a point of a robot gets from where it is at a cell's middle (m): motions are cut to it. Half of it
/// makes plans shorter by 0.05 %, with twice as many arcs and half as much work again (scenes figure1, t04).
pub const CELL_REACH_M: f64 = 0.06;

/// Overlaps in time up to this (s) do not count: rounding of times.
pub const TIME_ROUNDING_S: f64 = 1e-9;

/// Corners of an axis-aligned box in the world (m).
pub type Bounds = (Point3<f64>, Point3<f64>);

/// A straight motion that [`Conflicts`] knows, in the direction in which it is travelled. Cell 0 is the first travelled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// Who moves.
    pub robot: RobotId,
    /// What it holds.
    pub holding: Option<Holding>,
    /// Number of equal cells.
    pub cells: u32,
    /// Box around everything swept, clearance included (m).
    pub bounds: Bounds,
    motion: u32,
    reversed: bool,
}

impl Travel {
    /// The same motion travelled the other way.
    #[must_use]
    pub fn back(self) -> Self {
        Self { reversed: !self.reversed, ..self }
    }

    fn canonical(&self, cell: u32) -> u32 {
        if self.reversed { self.cells - 1 - cell } else { cell }
    }
}

/// A straight motion at constant speed over a time.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedMotion {
    /// Motion.
    pub motion: Motion,
    /// Time at its first configuration (s).
    pub begins_s: f64,
    /// Time at its last configuration (s); infinite for a robot that stands for ever.
    pub ends_s: f64,
}

/// An object standing at a pose for a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedStanding {
    /// Object and pose.
    pub standing: Standing,
    /// From when on (s); minus infinity for where it stands at the start.
    pub from_s: f64,
    /// Until when (s); infinite if nobody takes it.
    pub until_s: f64,
}

/// Whether two boxes have nothing in common.
#[must_use]
pub fn apart(a: &Bounds, b: &Bounds) -> bool {
    (0..3).any(|i| a.0[i] > b.1[i] || b.0[i] > a.1[i])
}

/// Time `[begins, ends]` of one cell (s).
#[must_use]
pub fn cell_times(cells: u32, cell: u32, begins_s: f64, ends_s: f64) -> (f64, f64) {
    let at = |i: u32| {
        if i == 0 {
            begins_s
        } else if i == cells {
            ends_s
        } else {
            begins_s + (ends_s - begins_s) * (f64::from(i) / f64::from(cells))
        }
    };
    (at(cell), at(cell + 1))
}

/// The conflict relation of one problem, with a memo by content. `false` is a proof: two closed cells that do not
/// conflict keep the clearance wherever in them the robots are.
pub struct Conflicts {
    geometry: Arc<Geometry>,
    memo: RefCell<Memo>,
}

impl Conflicts {
    /// The relation of a problem's geometry.
    #[must_use]
    pub fn new(geometry: Arc<Geometry>) -> Self {
        Self { geometry, memo: RefCell::default() }
    }

    /// The geometry.
    #[must_use]
    pub fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }

    /// Number of equal cells of a motion; 1 if it stands.
    #[must_use]
    pub fn cells(&self, motion: &Motion) -> u32 {
        self.travel(motion).cells
    }

    /// Notes a motion. A motion and its reverse have the same cells, counted from either end.
    #[must_use]
    pub fn travel(&self, motion: &Motion) -> Travel {
        self.memo.borrow_mut().travel(&self.geometry, motion)
    }

    /// Whether two cells of two robots conflict.
    #[must_use]
    pub fn cells_conflict(&self, a: &Travel, i: u32, b: &Travel, j: u32) -> bool {
        a.robot != b.robot
            && !apart(&a.bounds, &b.bounds)
            && self.memo.borrow_mut().conflict(&self.geometry, (a, a.canonical(i)), (b, b.canonical(j)))
    }

    /// Whether a cell hits an object standing at a pose. The object in the robot's own hand it never hits.
    #[must_use]
    pub fn cell_hits(&self, a: &Travel, i: u32, standing: &Standing) -> bool {
        a.holding.is_none_or(|holding| holding.object != standing.object)
            && self.memo.borrow_mut().hits(&self.geometry, (a, a.canonical(i)), standing)
    }

    /// Whether any cell of a motion hits an object standing at a pose.
    #[must_use]
    pub fn motion_hits(&self, motion: &Motion, standing: &Standing) -> bool {
        let travel = self.travel(motion);
        (0..travel.cells).any(|cell| self.cell_hits(&travel, cell, standing))
    }

    /// Whether two timed motions of two robots, each at constant speed, have conflicting cells that overlap in time.
    #[must_use]
    pub fn moves_conflict(&self, a: &TimedMotion, b: &TimedMotion) -> bool {
        let (a_begins, a_ends, b_begins, b_ends) = (a.begins_s, a.ends_s, b.begins_s, b.ends_s);
        if a.motion.robot == b.motion.robot || a_ends.min(b_ends) - a_begins.max(b_begins) <= TIME_ROUNDING_S {
            return false;
        }
        let (a, b) = (self.travel(&a.motion), self.travel(&b.motion));
        if apart(&a.bounds, &b.bounds) {
            return false;
        }
        let (mut i, mut j) = (0, 0);
        while i < a.cells && j < b.cells {
            let (a_from, a_to) = cell_times(a.cells, i, a_begins, a_ends);
            let (b_from, b_to) = cell_times(b.cells, j, b_begins, b_ends);
            if a_to.min(b_to) - a_from.max(b_from) > TIME_ROUNDING_S && self.cells_conflict(&a, i, &b, j) {
                return true;
            }
            if a_to <= b_to {
                i += 1;
            } else {
                j += 1;
            }
        }
        false
    }

    /// Whether a timed motion hits an object while it stands.
    #[must_use]
    pub fn move_hits(&self, a: &TimedMotion, standing: &TimedStanding) -> bool {
        if a.ends_s.min(standing.until_s) - a.begins_s.max(standing.from_s) <= TIME_ROUNDING_S {
            return false;
        }
        let travel = self.travel(&a.motion);
        (0..travel.cells).any(|cell| {
            let (from, to) = cell_times(travel.cells, cell, a.begins_s, a.ends_s);
            to.min(standing.until_s) - from.max(standing.from_s) > TIME_ROUNDING_S
                && self.cell_hits(&travel, cell, &standing.standing)
        })
    }

    /// Drops the memo if it has grown large. Every [`Travel`] made before is void then: call it between jobs only.
    pub fn forget_if_large(&self) {
        let mut memo = self.memo.borrow_mut();
        if memo.is_large() {
            *memo = Memo::default();
        }
    }
}
