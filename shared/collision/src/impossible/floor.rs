//! A map of where a base may be: square cells, less those in which fixed objects block every place.

use model::{Pose, Robot, Shape};
use nalgebra::{Translation3, Vector3};
use plan::{BaseMap, Disc};

use super::disc::discs;
use crate::Geometry;
use crate::gjk::{self, Closest};
use crate::obstacle::Obstacle;
use crate::solid::{Placed, Solid};

/// Least edge of a cell (m), and most cells.
const LEAST_CELL: f64 = 0.02;
const MOST_CELLS: f64 = 60_000.0;
/// Cosine of a tilt that counts as none.
const LEVEL: f64 = 1.0 - 1e-10;
/// What a disc must overlap an obstacle by (m) to be blocked.
const OVERLAP: f64 = 1e-4;

/// Places of a base in the frame of its coordinates.
pub(super) struct Floor<'a> {
    pub map: BaseMap,
    /// Farthest that a place of a cell is from its middle (m).
    pub spread: f64,
    obstacles: &'a [Obstacle],
    world_from_base: Pose,
    /// What the base contains wherever it is in a cell: a cylinder and the height of its middle (m).
    cores: Vec<(Solid, f64)>,
    least: [f64; 2],
    edge: [f64; 2],
    counts: [usize; 2],
}

/// Whether a frame's z axis points up.
pub(super) fn is_level(pose: &Pose) -> bool {
    (pose.rotation * Vector3::z()).z >= LEVEL
}

impl<'a> Floor<'a> {
    /// `None` without finite limits.
    pub fn of(geometry: &'a Geometry, robot: &Robot) -> Option<Self> {
        let limits = [&robot.coordinates[0], &robot.coordinates[1]].map(|c| [c.lower - 1e-6, c.upper + 1e-6]);
        let size = limits.map(|[low, high]| high - low);
        if !size.iter().all(|size| size.is_finite() && *size > 0.0) {
            return None;
        }
        let cell_m = (size[0] * size[1] / MOST_CELLS).sqrt().max(LEAST_CELL);
        let counts = size.map(|size| (size / cell_m).ceil().max(1.0) as usize);
        let edge = [size[0] / counts[0] as f64, size[1] / counts[1] as f64];
        let spread = edge[0].hypot(edge[1]) / 2.0;
        let discs = discs(robot);
        Some(Self {
            obstacles: geometry.fixed_obstacles(),
            world_from_base: robot.world_from_base,
            cores: discs.iter().filter_map(|disc| core(disc, spread)).collect(),
            map: BaseMap { cell_m, discs },
            spread,
            least: [limits[0][0], limits[1][0]],
            edge,
            counts,
        })
    }

    /// Numbers of all cells.
    pub fn cells(&self) -> std::ops::Range<usize> {
        0..self.counts[0] * self.counts[1]
    }

    /// Middle of a cell (m).
    pub fn middle(&self, cell: usize) -> [f64; 2] {
        let at = [cell % self.counts[0], cell / self.counts[0]];
        std::array::from_fn(|i| self.least[i] + self.edge[i] * (at[i] as f64 + 0.5))
    }

    /// Whether a fixed object is in the way wherever in the cell the base is.
    pub fn is_blocked(&self, cell: usize) -> bool {
        let [x, y] = self.middle(cell);
        self.cores.iter().any(|(solid, height)| {
            let placed = Placed::at(&(self.world_from_base * Translation3::new(x, y, *height)));
            let near = |obstacle: &&Obstacle| {
                let reach = Vector3::new(solid.half.x, solid.half.x, solid.half.z);
                let (low, high) = (obstacle.least - reach, obstacle.greatest + reach);
                (0..3).all(|i| (low[i]..=high[i]).contains(&placed.center[i]))
            };
            self.obstacles.iter().filter(near).any(|obstacle| meet((solid, &placed), obstacle.posed()))
        })
    }

    /// Cells to which unblocked ones lead from a place, in order of their distance, until `stop` says so of one. `None`: it
    /// did, or the place itself is blocked or outside.
    pub fn connected(&self, from: [f64; 2], stop: impl Fn([f64; 2]) -> bool) -> Option<Vec<usize>> {
        let cell = [0, 1].map(|i| (from[i] - self.least[i]) / self.edge[i]);
        if !(0..2).all(|i| (0.0..self.counts[i] as f64).contains(&cell[i])) {
            return None;
        }
        let start = cell[0] as usize + self.counts[0] * cell[1] as usize;
        if self.is_blocked(start) {
            return None;
        }
        let (mut seen, mut reached) = (vec![false; self.cells().len()], vec![start]);
        seen[start] = true;
        let mut next = 0;
        while let Some(cell) = reached.get(next).copied() {
            next += 1;
            if stop(self.middle(cell)) {
                return None;
            }
            for neighbour in self.neighbours(cell) {
                if !std::mem::replace(&mut seen[neighbour], true) && !self.is_blocked(neighbour) {
                    reached.push(neighbour);
                }
            }
        }
        Some(reached)
    }

    /// The cell itself and those that touch it, at corners too.
    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> {
        let (at, columns) = ([cell % self.counts[0], cell / self.counts[0]], self.counts[0]);
        let near = |i: usize| at[i].saturating_sub(1)..=(at[i] + 1).min(self.counts[i] - 1);
        let (x, y) = (near(0), near(1));
        y.flat_map(move |y| x.clone().map(move |x| x + columns * y))
    }
}

/// A disc less by the size of a cell.
fn core(disc: &Disc, spread: f64) -> Option<(Solid, f64)> {
    let (radius, length) = (disc.radius_m - spread - OVERLAP, disc.top_m - disc.bottom_m - OVERLAP);
    let solid = if radius > 0.0 && length > 0.0 { Solid::new(&Shape::Cylinder { radius, length }).ok() } else { None };
    solid.map(|(solid, _)| (solid, f64::midpoint(disc.bottom_m, disc.top_m)))
}

/// Whether two placed solids overlap for certain.
pub(super) fn meet(a: (&Solid, &Placed), b: (&Solid, &Placed)) -> bool {
    let rounding = a.0.rounding + b.0.rounding;
    match gjk::closest(a, b, rounding, &(b.1.center - a.1.center)) {
        Closest::Meeting => true,
        Closest::Apart { at_most, .. } => at_most < rounding - OVERLAP,
    }
}
