//! Where a base may stand: cells over its limits that no fixed object is proven to block.

use glamx::DVec2;
use model::{LinkId, Problem, Robot};
use plan::{BaseMap, Disc};

use crate::frame::Frame;
use crate::mechanism::Mechanism;
use crate::section::{Inside, Polygon};

/// Least edge length of a cell (m), and greatest number of cells.
const LEAST_CELL: f64 = 1e-3;
const MOST_CELLS: f64 = 4e6;
/// Allowance (m) for rounding, and for what rule V3 lets a base be out of its limits.
const ROUNDING: f64 = 1e-6;
/// Parts of a common range of heights at which an obstacle is cut.
const CUTS: [f64; 3] = [0.02, 0.5, 0.98];
/// Cosine short of 1 of a tilt that counts as none.
const LEVEL: f64 = 1e-9;

/// Places of a robot's base, in the frame of its coordinates.
pub(crate) struct Places {
    least: DVec2,
    edge: DVec2,
    counts: [usize; 2],
    blocked: Vec<bool>,
    /// Farthest that a place of a cell is from the cell's middle (m).
    pub(crate) spread: f64,
}

impl Places {
    /// The one place of a fixed base, or what is left of a planar base's limits.
    pub(crate) fn of(problem: &Problem, robot: &Robot, map: Option<&BaseMap>) -> Result<Self, String> {
        match (map, robot.base.is_some()) {
            (None, false) => {
                let (least, edge) = (DVec2::ZERO, DVec2::ZERO);
                Ok(Self { least, edge, counts: [1, 1], blocked: vec![false], spread: 0.0 })
            }
            (Some(map), true) => Self::on_map(problem, robot, map),
            (None, true) => Err(format!("{} drives, but there is no map", robot.name)),
            (Some(_), false) => Err(format!("{} does not drive, but there is a map", robot.name)),
        }
    }

    fn on_map(problem: &Problem, robot: &Robot, map: &BaseMap) -> Result<Self, String> {
        let limits = [0, 1].map(|i| (robot.coordinates[i].lower - ROUNDING, robot.coordinates[i].upper + ROUNDING));
        let [least, greatest] = [DVec2::new(limits[0].0, limits[1].0), DVec2::new(limits[0].1, limits[1].1)];
        let size = greatest - least;
        let counts = (size / map.cell_m).ceil().max(DVec2::ONE);
        if !(size.is_finite() && map.cell_m >= LEAST_CELL && counts.x * counts.y <= MOST_CELLS) {
            return Err(format!("the limits of {} cannot be cut into cells of {} m", robot.name, map.cell_m));
        }
        let (edge, counts) = (size / counts, [counts.x as usize, counts.y as usize]);
        let blocked = vec![false; counts[0] * counts[1]];
        let mut places = Self { least, edge, counts, blocked, spread: edge.length() / 2.0 };
        let base_from_world = base_from_world(robot)?;
        let bodies = problem.fixed.iter().flat_map(|fixed| {
            let frame = base_from_world * Frame::of(&fixed.world_from_object);
            fixed.bodies.iter().map(move |body| Inside::of(body, &frame))
        });
        let bodies: Vec<Inside> = bodies.collect();
        for disc in &map.discs {
            check_disc(robot, disc)?;
            bodies.iter().for_each(|body| places.block(disc, body));
        }
        Ok(places)
    }

    /// Blocks the cells in which the disc meets a body wherever its centre is.
    fn block(&mut self, disc: &Disc, body: &Inside) {
        let (low, high) = body.heights();
        let (bottom, top) = (low.max(disc.bottom_m), high.min(disc.top_m));
        let reach = disc.radius_m - self.spread - ROUNDING;
        if top - bottom <= ROUNDING || reach <= 0.0 {
            return;
        }
        for part in CUTS {
            let section = body.section(bottom + part * (top - bottom));
            if section.area() > 0.0 {
                self.block_near(&section, reach);
            }
        }
    }

    fn block_near(&mut self, section: &Polygon, reach: f64) {
        let (low, high) = section.bounds();
        let cell = |p: DVec2| ((p - self.least) / self.edge).floor().max(DVec2::ZERO);
        let (from, to) = (cell(low - DVec2::splat(reach)), cell(high + DVec2::splat(reach)));
        for row in from.y as usize..self.counts[1].min(to.y as usize + 1) {
            for column in from.x as usize..self.counts[0].min(to.x as usize + 1) {
                let index = row * self.counts[0] + column;
                if !self.blocked[index] && section.distance(self.middle(index)) <= reach {
                    self.blocked[index] = true;
                }
            }
        }
    }

    fn middle(&self, index: usize) -> DVec2 {
        let cell = DVec2::new((index % self.counts[0]) as f64, (index / self.counts[0]) as f64);
        self.least + self.edge * (cell + DVec2::splat(0.5))
    }

    /// Middles of the cells that may be free.
    pub(crate) fn free(&self) -> impl Iterator<Item = DVec2> + '_ {
        (0..self.blocked.len()).filter(|index| !self.blocked[*index]).map(|index| self.middle(index))
    }

    /// Middles of the cells that may be reached from a place without leaving free cells, corners included.
    pub(crate) fn connected(&self, from: DVec2) -> Result<Vec<DVec2>, String> {
        let cell = ((from - self.least) / self.edge).floor();
        let last = DVec2::new(self.counts[0] as f64, self.counts[1] as f64) - DVec2::ONE;
        if !(cell.cmpge(DVec2::ZERO).all() && cell.cmple(last + DVec2::ONE).all()) {
            return Err("the base starts outside of its limits".to_owned());
        }
        let cell = cell.min(last);
        let start = cell.y as usize * self.counts[0] + cell.x as usize;
        if self.blocked[start] {
            return Err("the base starts where it cannot stand".to_owned());
        }
        let (mut seen, mut open, mut middles) = (self.blocked.clone(), vec![start], Vec::new());
        seen[start] = true;
        while let Some(index) = open.pop() {
            middles.push(self.middle(index));
            let [column, row] = [index % self.counts[0], index / self.counts[0]];
            for row in row.saturating_sub(1)..(row + 2).min(self.counts[1]) {
                for column in column.saturating_sub(1)..(column + 2).min(self.counts[0]) {
                    let next = row * self.counts[0] + column;
                    if !std::mem::replace(&mut seen[next], true) {
                        open.push(next);
                    }
                }
            }
        }
        Ok(middles)
    }
}

/// The frame in which a base's coordinates are measured; it must be level.
pub(crate) fn base_from_world(robot: &Robot) -> Result<Frame, String> {
    let world_from_base = Frame::of(&robot.world_from_base);
    if world_from_base.rotation.z_axis.z < 1.0 - LEVEL {
        return Err(format!("{} does not stand level", robot.name));
    }
    Ok(world_from_base.inverse())
}

/// Checks that a disc about the yaw axis is inside of a body of the base at the lowest and at the highest height of its
/// slice; bodies are convex, so it is at all heights between.
fn check_disc(robot: &Robot, disc: &Disc) -> Result<(), String> {
    let mechanism = Mechanism::new(robot).ok_or_else(|| format!("the joints of {} are no tree", robot.name))?;
    let [closed, open] =
        [0.0, robot.end_effector.max_opening].map(|opening| mechanism.riding_with(robot, LinkId(0), opening));
    let bodies = closed.iter().filter(|link| open.contains(link)).flat_map(|(link, root_from_link)| {
        robot.links[link.index()].bodies.iter().map(|body| Inside::of(body, root_from_link))
    });
    let holds = |body: Inside| {
        let fits = |z: f64| body.section(z).radius_about(DVec2::ZERO) >= disc.radius_m;
        fits(disc.bottom_m) && fits(disc.top_m)
    };
    let sane = disc.radius_m > 0.0 && disc.bottom_m < disc.top_m;
    if sane && bodies.into_iter().any(holds) {
        return Ok(());
    }
    let Disc { bottom_m, top_m, radius_m } = disc;
    Err(format!("no body of {}'s base holds a disc of {radius_m} m from {bottom_m} to {top_m} m", robot.name))
}
