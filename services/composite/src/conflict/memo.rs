//! Memo of motions, their cells' sweeps, and answers about them. Keyed by content, so it never changes an answer.

use std::collections::HashMap;
use std::sync::Arc;

use collision::{Geometry, Motion, Sweep};
use model::{AllowedContacts, Holding, ObjectId, RobotId, Standing};

use super::{Bounds, CELL_REACH_M, Travel, apart};

/// Cells beyond which the memo is dropped between jobs.
const MANY_CELLS: usize = 2_000_000;
/// Sweeps kept at once; beyond it they are made anew.
const MANY_SWEEPS: usize = 40_000;

/// Grid (rad) of unbounded coordinates: far below any clearance, far above the rounding of a few turns.
const ANGLE_GRID: f64 = 1.0 / (1_u64 << 36) as f64;

#[derive(PartialEq, Eq, Hash)]
struct MotionKey {
    robot: RobotId,
    holding: Option<Holding>,
    from: Vec<u64>,
    to: Vec<u64>,
    allowed: AllowedContacts,
}

#[derive(PartialEq, Eq, Hash)]
struct StandingKey {
    object: ObjectId,
    pose: [u64; 7],
}

struct Known {
    motion: Motion,
    cells: u32,
    bounds: Bounds,
    /// Number of the motion's first cell among all cells.
    first_cell: usize,
}

/// Which cells of a motion hit a standing object; `None`: none does.
type Hits = Option<Box<[bool]>>;

/// What has been found out so far.
#[derive(Default)]
pub(super) struct Memo {
    ids: HashMap<MotionKey, u32>,
    motions: Vec<Known>,
    bounds: Vec<Option<Bounds>>,
    sweeps: HashMap<usize, Arc<Sweep>>,
    conflicts: HashMap<(usize, usize), bool>,
    standings: HashMap<StandingKey, u32>,
    hits: HashMap<(u32, u32), Hits>,
}

impl Memo {
    pub fn is_large(&self) -> bool {
        self.bounds.len() > MANY_CELLS
    }

    pub fn travel(&mut self, geometry: &Geometry, motion: &Motion) -> Travel {
        let (canonical, reversed) = canonical(geometry, motion);
        let bits = |q: &[f64]| q.iter().map(|x| (x + 0.0).to_bits()).collect();
        let Motion { robot, holding, allowed, .. } = *motion;
        let key = MotionKey { robot, holding, from: bits(&canonical.from), to: bits(&canonical.to), allowed };
        let next = u32::try_from(self.motions.len()).unwrap_or(u32::MAX);
        let id = *self.ids.entry(key).or_insert(next);
        if id == next {
            self.note(geometry, canonical);
        }
        let known = &self.motions[id as usize];
        Travel { robot, holding, cells: known.cells, bounds: known.bounds, motion: id, reversed }
    }

    fn note(&mut self, geometry: &Geometry, motion: Motion) {
        let stands = motion.from == motion.to;
        let cells = if stands { 1 } else { geometry.cells(&motion, CELL_REACH_M).max(1) };
        let bounds = geometry.sweep(&motion, 0, 1).bounds();
        let first_cell = self.bounds.len();
        self.bounds.resize(first_cell + cells as usize, None);
        self.motions.push(Known { motion, cells, bounds, first_cell });
    }

    pub fn conflict(&mut self, geometry: &Geometry, a: (&Travel, u32), b: (&Travel, u32)) -> bool {
        let (a_cell, b_cell) = (self.cell(a), self.cell(b));
        if apart(&self.cell_bounds(geometry, a), &self.cell_bounds(geometry, b)) {
            return false;
        }
        let key = (a_cell.min(b_cell), a_cell.max(b_cell));
        if let Some(known) = self.conflicts.get(&key) {
            return *known;
        }
        // The lower robot first, so that the answer cannot depend on who asks.
        let (first, second) = if a.0.robot < b.0.robot { (a, b) } else { (b, a) };
        let (first, second) = (self.sweep(geometry, first), self.sweep(geometry, second));
        let conflict = geometry.sweeps_conflict(&first, &second);
        self.conflicts.insert(key, conflict);
        conflict
    }

    pub fn hits(&mut self, geometry: &Geometry, a: (&Travel, u32), standing: &Standing) -> bool {
        let standing_id = self.standing(standing);
        let key = (a.0.motion, standing_id);
        if !self.hits.contains_key(&key) {
            let hits = self.find_hits(geometry, a.0, standing);
            self.hits.insert(key, hits);
        }
        self.hits.get(&key).and_then(Option::as_ref).is_some_and(|hits| hits[a.1 as usize])
    }

    /// The whole motion first, as the roadmap stage asks it: where that is clear, so is every cell.
    fn find_hits(&mut self, geometry: &Geometry, travel: &Travel, standing: &Standing) -> Hits {
        let motion = self.motions[travel.motion as usize].motion.clone();
        geometry.motion_hits(&motion, standing)?;
        let part = |cell: u32| Motion {
            from: between(&motion, cell, travel.cells),
            to: between(&motion, cell + 1, travel.cells),
            ..motion.clone()
        };
        let hits: Box<[bool]> =
            (0..travel.cells).map(|cell| geometry.motion_hits(&part(cell), standing).is_some()).collect();
        hits.contains(&true).then_some(hits)
    }

    fn standing(&mut self, standing: &Standing) -> u32 {
        let (t, q) = (standing.world_from_object.translation.vector, standing.world_from_object.rotation.coords);
        let pose = [t.x, t.y, t.z, q.x, q.y, q.z, q.w].map(|x| (x + 0.0).to_bits());
        let next = u32::try_from(self.standings.len()).unwrap_or(u32::MAX);
        *self.standings.entry(StandingKey { object: standing.object, pose }).or_insert(next)
    }

    fn cell(&self, (travel, cell): (&Travel, u32)) -> usize {
        self.motions[travel.motion as usize].first_cell + cell as usize
    }

    fn cell_bounds(&mut self, geometry: &Geometry, at: (&Travel, u32)) -> Bounds {
        let cell = self.cell(at);
        match self.bounds[cell] {
            Some(bounds) => bounds,
            None => self.sweep(geometry, at).bounds(),
        }
    }

    fn sweep(&mut self, geometry: &Geometry, at: (&Travel, u32)) -> Arc<Sweep> {
        let cell = self.cell(at);
        if let Some(sweep) = self.sweeps.get(&cell) {
            return sweep.clone();
        }
        if self.sweeps.len() >= MANY_SWEEPS {
            self.sweeps.clear();
        }
        let known = &self.motions[at.0.motion as usize];
        let sweep = Arc::new(geometry.sweep(&known.motion, at.1, known.cells));
        self.bounds[cell] = Some(sweep.bounds());
        self.sweeps.insert(cell, sweep.clone());
        sweep
    }
}

fn between(motion: &Motion, cell: u32, cells: u32) -> Vec<f64> {
    if cell == cells {
        return motion.to.clone();
    }
    let share = f64::from(cell) / f64::from(cells);
    motion.from.iter().zip(&motion.to).map(|(a, b)| a + (b - a) * share).collect()
}

/// The one motion that stands for all that differ from it by their direction or by whole turns of unbounded coordinates,
/// and whether it runs the other way. Unbounded coordinates are rounded to [`ANGLE_GRID`], so that adding and taking off
/// turns does not matter.
fn canonical(geometry: &Geometry, motion: &Motion) -> (Motion, bool) {
    let robot = geometry.problem().robot(motion.robot);
    let (mut from, mut to) = (motion.from.clone(), motion.to.clone());
    for (i, coordinate) in robot.coordinates.iter().enumerate().filter(|(_, c)| !c.upper.is_finite()) {
        if let (true, Some(from), Some(to)) = (coordinate.lower == f64::NEG_INFINITY, from.get_mut(i), to.get_mut(i)) {
            let middle = (*from + *to) / 2.0;
            let turns = std::f64::consts::TAU * (middle / std::f64::consts::TAU).round();
            let on_grid = |x: f64| ((x - turns) / ANGLE_GRID).round() * ANGLE_GRID;
            (*from, *to) = (on_grid(*from), on_grid(*to));
        }
    }
    let reversed = is_after(&from, &to);
    if reversed {
        std::mem::swap(&mut from, &mut to);
    }
    (Motion { from, to, ..motion.clone() }, reversed)
}

/// Whether `a` comes after `b` in the order of their first differing coordinate.
fn is_after(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).is_some_and(std::cmp::Ordering::is_gt)
}
