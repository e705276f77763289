//! Bridges between the parts of a base roadmap: where few samples leave it in parts, ways through narrow doors are sought on
//! a grid of the base's limits, at a few yaws.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use collision::Geometry;
use contract::{Interrupted, JobContext, RoadmapPiece};
use model::{AllowedContacts, Configuration, Robot};

use crate::base::{NEIGHBOURS, add_vertex, is_free_drive};
use crate::connect::nearest;

/// Least spacing of the grid (m).
const SPACING_M: f64 = 0.1;
/// Most cells of the grid: a larger hall has a coarser one.
const MOST_CELLS: f64 = 4096.0;
/// Yaws (rad) at which ways are sought, one after the other.
const YAWS: [f64; 2] = [0.0, std::f64::consts::FRAC_PI_2];
/// Parts of fewer vertices are not worth a bridge.
const LEAST_PART: usize = 4;

type Cell = [usize; 2];

/// How often a way whose straight motions turn out not to be free is sought anew.
const MOST_DETOURS: usize = 8;

/// Adds vertices that join the part with the first vertex, the robot's start, to others, as far as a way is found.
pub(crate) fn build_bridges(
    geometry: &Geometry,
    robot: &Robot,
    piece: &mut RoadmapPiece,
    context: &mut JobContext<'_>,
) -> Result<(), Interrupted> {
    for yaw in YAWS {
        let mut grid = Grid::new(geometry, robot, piece, yaw);
        let mut detours = 0;
        loop {
            let (own, others) = parts(piece);
            if others.is_empty() || detours > MOST_DETOURS {
                break;
            }
            let Some(way) = grid.way_out(piece, &own, &others, context)? else { break };
            match grid.stands(piece, &way) {
                Ok(stands) => stands.into_iter().for_each(|q| grid.add(piece, q)),
                Err(narrow) => {
                    grid.free.insert(narrow, false);
                    detours += 1;
                }
            }
        }
    }
    Ok(())
}

/// Vertices connected to the first one, and those of all other parts that are worth a bridge.
fn parts(piece: &RoadmapPiece) -> (Vec<usize>, Vec<usize>) {
    let mut part_of: Vec<usize> = (0..piece.vertices.len()).collect();
    for edge in &piece.edges {
        let [a, b] = [edge.a, edge.b].map(|vertex| part_of[vertex.index()]);
        part_of.iter_mut().filter(|part| **part == b).for_each(|part| *part = a);
    }
    let size = |vertex: usize| part_of.iter().filter(|part| **part == part_of[vertex]).count();
    let (own, others): (Vec<usize>, Vec<usize>) = (0..part_of.len()).partition(|vertex| part_of[*vertex] == part_of[0]);
    (own, others.into_iter().filter(|vertex| size(*vertex) >= LEAST_PART).collect())
}

/// Stands of one yaw in rows and columns over the base's limits.
struct Grid<'a> {
    geometry: &'a Geometry,
    robot: &'a Robot,
    yaw: f64,
    low: [f64; 2],
    spacing_m: f64,
    cells: Cell,
    /// Whether the robot can stand there, once tested.
    free: BTreeMap<Cell, bool>,
    /// Folded, base coordinates first.
    folded: Configuration,
}

impl<'a> Grid<'a> {
    fn new(geometry: &'a Geometry, robot: &'a Robot, piece: &RoadmapPiece, yaw: f64) -> Self {
        let limits = [0, 1].map(|i: usize| (robot.coordinates[i].lower, robot.coordinates[i].upper));
        let size = limits.map(|(low, high)| high - low);
        let spacing_m = (size[0] * size[1] / MOST_CELLS).sqrt().max(SPACING_M);
        let cells = size.map(|size| (size / spacing_m) as usize + 1);
        let folded = piece.vertices.first().cloned().unwrap_or_default();
        let low = limits.map(|(low, _)| low);
        Self { geometry, robot, yaw, low, spacing_m, cells, free: BTreeMap::new(), folded }
    }

    fn at(&self, cell: Cell) -> Configuration {
        let mut q = self.folded.clone();
        q[0] = self.low[0] + cell[0] as f64 * self.spacing_m;
        q[1] = self.low[1] + cell[1] as f64 * self.spacing_m;
        q[2] = self.yaw;
        q
    }

    fn nearest_cell(&self, q: &[f64]) -> Cell {
        [0, 1].map(|i| {
            let number = ((q[i] - self.low[i]) / self.spacing_m).round().max(0.0) as usize;
            number.min(self.cells[i] - 1)
        })
    }

    fn is_free(&mut self, piece: &RoadmapPiece, cell: Cell) -> bool {
        if let Some(free) = self.free.get(&cell) {
            return *free;
        }
        let contact =
            self.geometry.state_contact(piece.robot, piece.holding, &self.at(cell), AllowedContacts::default());
        self.free.insert(cell, contact.is_none());
        contact.is_none()
    }

    fn is_straight(&self, piece: &RoadmapPiece, from: &Configuration, to: &Configuration) -> bool {
        is_free_drive(self.geometry, self.robot, piece, from, to)
    }

    /// Cells on a way from one part to others, found breadth first.
    fn way_out(
        &mut self,
        piece: &RoadmapPiece,
        own: &[usize],
        others: &[usize],
        context: &mut JobContext<'_>,
    ) -> Result<Option<Vec<Cell>>, Interrupted> {
        let mut near: BTreeMap<Cell, Vec<usize>> = BTreeMap::new();
        for vertex in others {
            near.entry(self.nearest_cell(&piece.vertices[*vertex])).or_default().push(*vertex);
        }
        let mut reached: BTreeMap<Cell, Option<Cell>> = BTreeMap::new();
        let mut queue = VecDeque::new();
        for vertex in own {
            let (q, cell) = (&piece.vertices[*vertex], self.nearest_cell(&piece.vertices[*vertex]));
            if !reached.contains_key(&cell) && self.is_free(piece, cell) && self.is_straight(piece, q, &self.at(cell)) {
                reached.insert(cell, None);
                queue.push_back(cell);
            }
        }
        while let Some(cell) = queue.pop_front() {
            if !context.spend(1)? {
                return Ok(None);
            }
            let joins = |vertex: &usize| self.is_straight(piece, &self.at(cell), &piece.vertices[*vertex]);
            if near.get(&cell).is_some_and(|vertices| vertices.iter().any(joins)) {
                let mut way = vec![cell];
                while let Some(Some(before)) = way.last().and_then(|cell| reached.get(cell)) {
                    way.push(*before);
                }
                way.reverse();
                return Ok(Some(way));
            }
            for next in self.neighbours(cell) {
                if !reached.contains_key(&next) && self.is_free(piece, next) {
                    reached.insert(next, Some(cell));
                    queue.push_back(next);
                }
            }
        }
        Ok(None)
    }

    fn neighbours(&self, [i, j]: Cell) -> Vec<Cell> {
        let beside = [[i.wrapping_sub(1), j], [i + 1, j], [i, j.wrapping_sub(1)], [i, j + 1]];
        beside.into_iter().filter(|cell| cell[0] < self.cells[0] && cell[1] < self.cells[1]).collect()
    }

    /// Stands along a way, as few as straight motions allow; or the cell that none leads to.
    fn stands(&self, piece: &RoadmapPiece, way: &[Cell]) -> Result<Vec<Configuration>, Cell> {
        let mut stands: Vec<Configuration> = way.first().map(|cell| self.at(*cell)).into_iter().collect();
        let mut at = 0;
        while at + 1 < way.len() {
            let is_straight = |to: &usize| self.is_straight(piece, &self.at(way[at]), &self.at(way[*to]));
            at = (at + 1..way.len()).take_while(is_straight).last().ok_or(way[at + 1])?;
            stands.push(self.at(way[at]));
        }
        Ok(stands)
    }

    /// Adds a stand, connected to those near it and to the last one.
    fn add(&self, piece: &mut RoadmapPiece, q: Configuration) {
        let near = nearest(self.robot, &piece.vertices, &q, NEIGHBOURS);
        let last = piece.vertices.len().checked_sub(1);
        let others: BTreeSet<usize> = near.into_iter().map(|neighbour| neighbour.vertex).chain(last).collect();
        add_vertex(self.geometry, self.robot, piece, q, others);
    }
}
