//! Whether a hand is blocked at every pose of the object: poses are covered with cells, and in each a body that is made
//! smaller by all that it could move within the cell still meets a fixed object.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use model::{FixedId, Grasp, ObjectId, Pair, Pose};
use nalgebra::Vector3;

use super::floor::meet;
use super::hand::{Rider, hand, object};
use super::poses::{Patch, Poses, own_solid};
use crate::solid::{Placed, Solid};
use crate::{BodyName, Geometry};

/// Most cells looked at.
const MOST_CELLS: u32 = 20_000;
/// Yaws at which a cover begins.
const YAWS: u32 = 16;
/// A pose this far outside of the region (m) is none.
const OUTSIDE: f64 = 2e-6;

/// Poses about a middle: u, v (m) and yaw (rad), with half widths.
#[derive(Clone, Copy)]
struct Cell {
    middle: [f64; 3],
    half: [f64; 3],
}

impl Geometry {
    /// Fixed objects of which one is in the way of the hand, or of the object, at every pose.
    pub(super) fn blocked_grasp(&self, pair: &Pair, poses: &Poses, grasp: &Grasp) -> Option<Vec<FixedId>> {
        let mut riders = hand(self, pair.robot, grasp);
        let mut by = BTreeSet::new();
        match poses {
            Poses::Start(pose) => {
                by.insert(self.blocking(&riders, pose, &[0.0; 3])?);
            }
            Poses::Region(patch) => {
                riders.iter_mut().for_each(|rider| rider.off += patch.tolerance);
                riders.push(object(self, pair.object));
                self.cover(pair.object, &riders, patch, &mut by)?;
            }
        }
        Some(by.into_iter().collect())
    }

    fn cover(&self, object: ObjectId, riders: &[Rider], patch: &Patch, by: &mut BTreeSet<FixedId>) -> Option<()> {
        let part = PI / f64::from(YAWS);
        let [u, v] = patch.half;
        let first = |i: u32| Cell { middle: [0.0, 0.0, part * f64::from(2 * i)], half: [u, v, part] };
        let mut open: Vec<Cell> = (0..YAWS).map(first).collect();
        let swing = riders.iter().map(|rider| rider.swing).fold(0.0, f64::max);
        for _ in 0..MOST_CELLS {
            let Some(cell) = open.pop() else { return Some(()) };
            if self.is_outside(object, patch, &cell) {
                continue;
            }
            let [u, v, yaw] = cell.middle;
            let pose = patch.pose(u, v, yaw);
            if let Some(fixed) = self.blocking(riders, &pose, &cell.half) {
                by.insert(fixed);
                continue;
            }
            let point = Cell { half: [0.0; 3], ..cell };
            if !self.is_outside(object, patch, &point) && self.blocking(riders, &pose, &[0.0; 3]).is_none() {
                return None;
            }
            open.extend(cell.halves(swing));
        }
        None
    }

    /// A fixed object that some body meets throughout a cell.
    fn blocking(&self, riders: &[Rider], world_from_object: &Pose, half: &[f64; 3]) -> Option<FixedId> {
        riders.iter().find_map(|rider| {
            let moves = half[0].hypot(half[1]) + half[2] * rider.swing + rider.off;
            let (smaller, placed) = (rider.solid.shrunk(moves), rider.placed(world_from_object));
            self.fixed_obstacles().iter().find_map(|obstacle| {
                let BodyName::Fixed(fixed) = obstacle.name else { return None };
                let (solid, at) = obstacle.posed();
                let reach = rider.solid.radius + solid.radius;
                let is_near = (at.center - placed.center).norm_squared() <= reach * reach;
                let deep = |a: Option<&Solid>, b: Option<&Solid>| match (a, b) {
                    (Some(a), Some(b)) => meet((a, &placed), (b, at)),
                    _ => false,
                };
                let blocks = is_near
                    && (deep(smaller.as_ref(), Some(solid)) || deep(Some(&rider.solid), solid.shrunk(moves).as_ref()));
                blocks.then_some(fixed)
            })
        })
    }

    /// Whether the object sticks out of the region at every pose of a cell.
    fn is_outside(&self, object: ObjectId, patch: &Patch, cell: &Cell) -> bool {
        let turn = Pose::rotation(Vector3::z() * cell.middle[2]);
        let (solid, placed): (&Solid, Placed) = own_solid(self, object, &turn);
        let turns = cell.half[2] * (placed.center.norm() + solid.radius) + OUTSIDE;
        (0..2).any(|i| {
            let axis = Vector3::ith(i, 1.0);
            let (ahead, behind) = (solid.extent(&placed, &axis), solid.extent(&placed, &-axis));
            let (low, high) = (cell.middle[i] - cell.half[i], cell.middle[i] + cell.half[i]);
            low + ahead - turns > patch.free[i] || behind - high - turns > patch.free[i]
        })
    }
}

impl Cell {
    /// Both halves across the direction that moves things the most.
    fn halves(self, swing: f64) -> [Self; 2] {
        let moves = [self.half[0], self.half[1], self.half[2] * swing];
        let axis = if moves[2] >= moves[0].max(moves[1]) { 2 } else { usize::from(moves[1] > moves[0]) };
        [-0.5, 0.5].map(|side| {
            let mut part = self;
            part.middle[axis] += side * self.half[axis];
            part.half[axis] /= 2.0;
            part
        })
    }
}
